"""The chain's own views: the profile above it, bars under its contacts, a close-up and the x-t diagram."""
