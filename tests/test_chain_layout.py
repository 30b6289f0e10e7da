"""The layout of a chain's table: rows that a core does not mistake for each other."""

from __future__ import annotations

from granular_env.components.chain.layout import BESIDE_GRAINS, row_width

# Words on a page of 4096 bytes, the bits of an address by which a core tells a store from a load.
_PAGE = 512


def test_long_rows_do_not_lie_near_a_multiple_of_a_page_apart() -> None:
    for grains in range(473, 5000):
        beyond = row_width(grains) % _PAGE
        assert 80 <= beyond < _PAGE - 32, grains


def test_rows_are_hardly_longer_than_their_chain_needs() -> None:
    for grains in range(40, 5000):
        spare = row_width(grains) - grains - BESIDE_GRAINS
        assert 0 <= spare < 120 and (spare < 8 or grains > 400), grains
    assert row_width(1_000_000) - 1_000_000 < 120
