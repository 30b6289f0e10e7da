"""Helpers of several test modules: examples, toys, a browser, a terminal."""
