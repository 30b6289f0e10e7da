"""Environments of a chain: acting, judging and observing compiled, one at a time or many in one batch."""
