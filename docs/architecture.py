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
_WIDTH, _ROW, _GAP, _MARGIN = 960, 62, 10, 16
_LETTERS_A_LINE = 34
# Below the command line: a domain may use every generic room, which reach it through the table of domains alone.
_DOMAINS_AT = 1
# The modules of components/ that a newcomer reads.
_PAGES = ("contract", "component", "stepping", "inputs", "snapshot", "catalogue", "oscillator", "discs")


class Room(NamedTuple):
    """A package or module of `granular_env`, or of `components`, and what its docstring says it is."""

    name: str
    purpose: str


def layers() -> list[list[Room]]:
    """Return the rooms of each layer, uppermost first; imports point downwards only."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    names = next(contract["layers"] for contract in contracts if contract.get("containers") == ["granular_env"])
    above = [[_room(ROOT / "granular_env", name) for name in re.findall(r"\w+", layer)] for layer in names]
    domains = ROOT / "granular_env" / "domains"
    folders = [path.name for path in sorted(domains.iterdir()) if (path / "__init__.py").exists()]
    above.insert(_DOMAINS_AT, [_room(domains, name, "domains/") for name in folders])
    parts = sorted(path for path in (ROOT / "components").iterdir() if (path / "__init__.py").exists())
    return [
        *above,
        [_room(ROOT / "components", name) for name in _PAGES],
        [_room(ROOT / "components", path.name) for path in parts],
    ]


def _room(folder: Path, name: str, prefix: str = "") -> Room:
    path = folder / name / "__init__.py" if (folder / name).is_dir() else folder / f"{name}.py"
    text = ast.get_docstring(ast.parse(path.read_text())) or ""
    sentence = " ".join(text.split("\n\n")[0].split())
    return Room(prefix + name, re.split(r"\.(?= |$)", sentence.replace("`", ""))[0])


def picture() -> str:
    """Return the drawing as SVG that adapts to light and dark pages."""
    rows = layers()
    height = 2 * _MARGIN + len(rows) * (_ROW + _GAP) - _GAP
    drawing = ElementTree.Element(
        "svg", xmlns=SVG[1:-1], viewBox=f"0 0 {_WIDTH} {height}", role="img", attrib={"aria-label": "rooms, layer by layer"}
    )
    ElementTree.SubElement(drawing, "style").text = (
        "text{font:13px sans-serif;fill:#222}.name{font-weight:600}.purpose{font-size:11px}rect{fill:#eef2f6;stroke:#8a99a8}"
        "@media (prefers-color-scheme:dark){text{fill:#e2e4e9}rect{fill:#2a2f3a;stroke:#667}}"
    )
    for number, rooms in enumerate(rows):
        _draw_row(drawing, rooms, _MARGIN + number * (_ROW + _GAP))
    ElementTree.indent(drawing)
    return ElementTree.tostring(drawing, "unicode") + "\n"


def _draw_row(drawing: ElementTree.Element, rooms: list[Room], top: float) -> None:
    width = (_WIDTH - 2 * _MARGIN - (len(rooms) - 1) * _GAP) / len(rooms)
    letters = int(_LETTERS_A_LINE * width / 220)
    for number, room in enumerate(rooms):
        left = _MARGIN + number * (width + _GAP)
        ElementTree.SubElement(drawing, "rect", x=f"{left:.1f}", y=f"{top}", width=f"{width:.1f}", height=f"{_ROW}", rx="6")
        _write(drawing, "name", left + 8, top + 18, room.name)
        for line, words in enumerate(_wrap(room.purpose, letters, 3)):
            _write(drawing, "purpose", left + 8, top + 33 + 12 * line, words)


def _wrap(text: str, letters: int, lines: int) -> list[str]:
    return textwrap.wrap(text, max(letters, 8), max_lines=lines, placeholder=" ...")


def _write(drawing: ElementTree.Element, kind: str, x: float, y: float, words: str) -> None:
    ElementTree.SubElement(drawing, "text", attrib={"class": kind}, x=f"{x:.1f}", y=f"{y:.1f}").text = words


if __name__ == "__main__":
    PICTURE.write_text(picture())
