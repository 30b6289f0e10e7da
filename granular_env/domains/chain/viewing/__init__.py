"""Views of a chain: profile above the grains, bars below the contacts, close-up and x-t diagram."""
