"""Control of chains: exact gradients, objectives, and the checks of both."""
