"""The picture of the rooms and of the direction of imports: `python docs/architecture.py` draws it.

The rooms and their order are those of the import contracts in pyproject.toml, the words are the first lines of their
docstrings: what the picture shows is what the tests check.
"""

import ast
import re
import textwrap
import tomllib
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "images" / "architecture.svg"
SVG = "{http://www.w3.org/2000/svg}"
_WIDTH, _GAP, _MARGIN = 960, 8, 16
# The height of a box whose words take one line, and of each line more; narrow boxes have up to three.
_ROW, _LINE, _MOST_LINES = 40, 12, 3
_LETTERS_A_LINE = 31
# Width of a bold letter over the size of its font.
_BOLD_LETTER = 0.68
# Below the command line: a domain may use every generic room, which reach it through the table of domains alone.
_DOMAINS_AT = 1


class Room(NamedTuple):
    """A package or module, the folder it is in, and what its docstring says it is."""

    name: str
    folder: str
    purpose: str


def layers() -> list[list[Room]]:
    """Return the rooms of each layer, uppermost first; imports point downwards only."""
    rooms = _rows("granular_env")
    domains = ROOT / "granular_env" / "domains"
    folders = [path.name for path in sorted(domains.iterdir()) if (path / "__init__.py").exists()]
    rooms.insert(_DOMAINS_AT, [_room(domains, name, "domains/") for name in folders])
    # The lowest of its layers is components/, which has layers of its own.
    return [*rooms[:-1], *_rows("granular_env.components")]


def _rows(package: str) -> list[list[Room]]:
    """Return the rooms of a package, layer by layer, as its import contract has them."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    names = next(contract["layers"] for contract in contracts if contract.get("containers") == [package])
    folder = ROOT / package.rpartition(".")[2]
    return [[_room(folder, name) for name in re.findall(r"\w+", layer)] for layer in names]


def _room(folder: Path, name: str, prefix: str = "") -> Room:
    path = folder / name / "__init__.py" if (folder / name).is_dir() else folder / f"{name}.py"
    text = ast.get_docstring(ast.parse(path.read_text())) or ""
    sentence = " ".join(text.split("\n\n")[0].split())
    return Room(prefix + name, folder.name, re.split(r"(?<!et al)\.(?= |$)", sentence.replace("`", ""))[0])


def picture() -> str:
    """Return the drawing as SVG that adapts to light and dark pages."""
    rows = layers()
    heights = [_ROW + (_lines(rooms) - 1) * _LINE for rooms in rows]
    height = 2 * _MARGIN + sum(heights) + (len(rows) - 1) * _GAP
    drawing = ElementTree.Element(
        "svg", xmlns=SVG[1:-1], viewBox=f"0 0 {_WIDTH} {height}", role="img", attrib={"aria-label": "rooms, layer by layer"}
    )
    ElementTree.SubElement(drawing, "style").text = (
        "text{font-family:sans-serif;fill:#222}.name{font-weight:600}rect{fill:#eef2f6;stroke:#8a99a8}"
        ".components{fill:#f3efe2}"
        "@media (prefers-color-scheme:dark){text{fill:#e2e4e9}rect{fill:#2a2f3a;stroke:#667}.components{fill:#38341f}}"
    )
    for number, rooms in enumerate(rows):
        _draw_row(drawing, rooms, _MARGIN + sum(heights[:number]) + number * _GAP, heights[number])
    ElementTree.indent(drawing)
    return ElementTree.tostring(drawing, "unicode") + "\n"


def _draw_row(drawing: ElementTree.Element, rooms: list[Room], top: float, height: float) -> None:
    width = (_WIDTH - 2 * _MARGIN - (len(rooms) - 1) * _GAP) / len(rooms)
    letters = int(_LETTERS_A_LINE * width / 220)
    for number, room in enumerate(rooms):
        left = _MARGIN + number * (width + _GAP)
        place = {"x": f"{left:.1f}", "y": f"{top}", "width": f"{width:.1f}", "height": f"{height}", "rx": "6"}
        ElementTree.SubElement(drawing, "rect", {"class": room.folder, **place})
        _write(drawing, "name", left + 8, top + 16, room.name, min(13.0, (width - 12) / (_BOLD_LETTER * len(room.name))))
        for line, words in enumerate(_wrap(room.purpose, letters, _lines(rooms))):
            _write(drawing, "purpose", left + 8, top + 31 + 12 * line, words, 11.0)


def _lines(rooms: list[Room]) -> int:
    return min(len(rooms), _MOST_LINES)


def _wrap(text: str, letters: int, lines: int) -> list[str]:
    return textwrap.wrap(text, max(letters, 8), max_lines=lines, placeholder=" ...")


def _write(drawing: ElementTree.Element, kind: str, x: float, y: float, words: str, size: float) -> None:
    place = {"x": f"{x:.1f}", "y": f"{y:.1f}", "style": f"font-size:{size:.1f}px"}
    ElementTree.SubElement(drawing, "text", {"class": kind, **place}).text = words


if __name__ == "__main__":
    PICTURE.write_text(picture())
