"""Every snippet of the README and the docs runs, page by page, and prints the output stated on the page.

```python blocks are executed in the page's order, in one process and one empty folder per page. A line
``print(...)  # text`` must print exactly this text. ```bash after ``<!-- run -->`` is also executed, and ```toml or any other
block after ``<!-- file: NAME -->`` is written to this file.
"""

import re
from pathlib import Path

import pytest
from support.page_runner import run_page

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(
    r"(?:<!-- (run|file: (?P<file>\S+)) -->\n)?^```(?P<language>\w+)[^\n]*\n(?P<code>.*?)^```$", re.MULTILINE | re.DOTALL
)
PROMISE = re.compile(r"^ *print\(.*\)  # (.+)$", re.MULTILINE)
LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)#\s]+)")


def name_of(page: Path) -> str:
    """Return the page's path in docs/, as in the menu."""
    return page.relative_to(ROOT / "docs").as_posix() if page.is_relative_to(ROOT / "docs") else page.name


def runnable(page: Path) -> list[tuple[str, str, str, list[str]]]:
    """Return the snippets of a page: (python, bash or a file name; location; content; expected output)."""
    text = page.read_text()
    found = []
    for match in BLOCK.finditer(text):
        where = f"{name_of(page)}:{text.count(chr(10), 0, match.start('code'))}"
        code, language = match["code"], match["language"]
        if match["file"]:
            found.append((match["file"], where, code, []))
        elif language == "python" or (language == "bash" and match[1] == "run"):
            found.append((language, where, code, PROMISE.findall(code)))
    return found


@pytest.mark.parametrize("page", [page for page in PAGES if runnable(page)], ids=name_of)
def test_the_snippets_of_a_page_run_and_print_what_it_says(page, tmp_path):
    folder = tmp_path / "work"
    folder.mkdir()
    assert not (said := run_page(runnable(page), folder)), said


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page):
    missing = [link for link in LINK.findall(page.read_text()) if not (page.parent / link).exists()]
    assert not missing


def test_every_page_is_in_the_menu():
    menu = (ROOT / "mkdocs.yml").read_text()
    others = menu.partition("not_in_nav")[2]  # linked from the first page
    assert [name for page in PAGES[1:] if f": {(name := name_of(page))}\n" not in menu and f" {name}\n" not in others] == []


def test_every_test_in_the_table_of_verification_exists():
    named = re.findall(r"`(test_\w+\.py)::(test_\w+)`", (ROOT / "docs" / "reference" / "verification.md").read_text())
    assert len(named) > 40
    assert [f"{file}::{test}" for file, test in named if f"def {test}(" not in (ROOT / "tests" / file).read_text()] == []
