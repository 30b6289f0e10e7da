"""Views of a chain: a curve above the grains (profile), bars below the contacts, a close-up and an x-t diagram."""
