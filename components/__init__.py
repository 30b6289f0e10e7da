"""The contract, and the components that implement it."""
