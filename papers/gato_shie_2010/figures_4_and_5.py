"""Figures 4 and 5: the very long notch, 3 in

"First the cracks ran straight on from the notch, then they branched in the direction of the circumference into some small
branches that went around the whole of it and led to the complete failure of the tube (on both sides of the notch)."
"""

from cracks import compare_our_factor, compare_printed_factor, draw_unrolled_tube, has_turned, is_beyond_notch
from pages import Page, show
from tubes import EARLY, LATE, VERY_EARLY, burst_log, outcome


def main(page: Page) -> None:
    """Run the notch with the paper's factor and with our factor."""
    compare_printed_factor(page, 3, "severed", "1.1", "0.025")
    one = outcome(burst_log(3))
    statements = [
        ("first", "straight on", is_beyond_notch(one, 3), True),
        ("then", "branches around the tube", has_turned(one), True),
        ("end", "severed", one.word == "severed", False),
    ]
    compare_our_factor(page, 3, statements, ("axial crack", "6.3", "17", "17", "1", "0.13"))
    page.text("The run ends 0.18 ms after the front, at a plastic strain of 9; its results are no longer valid by then.")
    for title, after in (("Figure 4", VERY_EARLY), ("Figure 4", EARLY), ("Figure 5", LATE)):
        draw_unrolled_tube(page, title, 3, after)


if __name__ == "__main__":
    show(main)
