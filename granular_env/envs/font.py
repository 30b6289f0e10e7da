"""A 3 x 5 pixel alphabet, so that a picture can say what it shows without a drawing library."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

# Each letter is five rows of three pixels; an octal digit is a row.
_ROWS = {
    "0": "75557", "1": "26227", "2": "71747", "3": "71717", "4": "55711", "5": "74717", "6": "74757", "7": "71122",
    "8": "75757", "9": "75717", "A": "25755", "B": "65656", "C": "34443", "D": "65556", "E": "74647", "F": "74644",
    "G": "34553", "H": "55755", "I": "72227", "J": "11152", "K": "55655", "L": "44447", "M": "57755", "N": "65555",
    "O": "25552", "P": "65644", "Q": "25563", "R": "65655", "S": "34216", "T": "72222", "U": "55557", "V": "55552",
    "W": "55775", "X": "55255", "Y": "55222", "Z": "71247", ".": "00002", "-": "00700", "+": "02720", "=": "07070",
    "/": "11244", ":": "02020", "_": "00007", "(": "24442", ")": "21112", ",": "00024", "%": "51245", " ": "00000",
}  # fmt: skip
WIDTH, HEIGHT = 3, 5


def text_mask(text: str, scale: int) -> npt.NDArray[np.bool_]:
    """Which pixels a line of text covers, shape (5 scale, 4 scale per letter); unknown letters are blank."""
    mask = np.zeros((HEIGHT, (WIDTH + 1) * len(text)), dtype=bool)
    for place, letter in enumerate(text.upper()):
        for row, digit in enumerate(_ROWS.get(letter, _ROWS[" "])):
            for column in range(WIDTH):
                mask[row, (WIDTH + 1) * place + column] = int(digit) >> (WIDTH - 1 - column) & 1
    return mask.repeat(scale, axis=0).repeat(scale, axis=1)
