"""Figure 3: the long notch, 2 in

In the experiment one crack ran around the whole tube and severed it. The paper's computation "branches and runs in two
directions around the circumference", and does not predict "complete failure on the other side of the shell"; the authors
explain this by their simple criterion and by the one-way coupling of gas and wall.
"""

from cracks import compare_our_factor, compare_printed_factor, draw_unrolled_tube, has_turned, is_beyond_notch
from pages import Page, show
from tubes import EARLY, LATE, burst_log, outcome


def main(page: Page) -> None:
    """Run the notch with the paper's factor and with our factor."""
    compare_printed_factor(page, 2, "hoop crack", "1.1", "0.03")
    one = outcome(burst_log(2))
    statements = [
        ("first", "short cracks from the notch's ends", is_beyond_notch(one, 2), True),
        ("then", "branches run around the tube", has_turned(one), True),
        ("end, computed", "not parted on the other side", one.word != "severed", True),
        ("end, experiment", "severed", one.word == "severed", False),
    ]
    compare_our_factor(page, 2, statements, ("hoop crack", "6.3", "100", "44", "6", "0.14"))
    for after in (EARLY, LATE):
        draw_unrolled_tube(page, "Figure 3", 2, after)


if __name__ == "__main__":
    show(main)
