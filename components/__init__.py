"""Whatever can be stepped: the contract, and the components that keep it."""
