"""Figure 3: the long notch, 2 in

In the experiment one crack ran around the whole tube and severed it. The paper's computation "branches and runs in two
directions around the circumference", and does not predict "complete failure on the other side of the shell"; the authors blame
their simple criterion, and that the gas does not feel the wall.
"""

from cracks import as_printed, draw_rolled_out, runs_beyond, turns, with_our_factor
from pages import Page, show
from tubes import EARLY, LATE, burst, outcome


def main(page: Page) -> None:
    """Run the notch with the paper's factor and with our factor."""
    as_printed(page, 2, "hoop crack", "1.1", "0.03")
    one = outcome(burst(2))
    statements = [
        ("first", "short cracks from the notch's ends", runs_beyond(one, 2), True),
        ("then", "branches run around the tube", turns(one), True),
        ("end, computed", "not parted on the other side", one.word != "severed", True),
        ("end, experiment", "severed", one.word == "severed", False),
    ]
    with_our_factor(page, 2, statements, ("hoop crack", "6.3", "100", "44", "6", "0.14"))
    for after in (EARLY, LATE):
        draw_rolled_out(page, "Figure 3", 2, after)


if __name__ == "__main__":
    show(main)
