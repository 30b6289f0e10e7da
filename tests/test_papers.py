"""The scripts of the papers give their known numbers, and the verdicts follow from the numbers."""

import sys
from pathlib import Path

import pytest

PAPERS = Path(__file__).resolve().parent.parent / "papers"
sys.path.insert(0, str(PAPERS))

import collect  # noqa: E402
from pages import Page, Row, compute_page  # noqa: E402

# Scripts that take more than a few seconds: many samples, half-spaces, notched tubes.
SLOW = {
    "figure_7.py", "section_35_piston.py", "figure_8.py", "waves.py", "rayleigh.py", "exact_solution.py", "figure_2.py",
    "figures_4_and_5.py", "outcomes.py", "criterion.py", "coupling.py", "pressures.py", "gato_shie_2010/figure_3.py",
}  # fmt: skip


SCRIPTS = [path for paper in collect.PAPERS for group in collect.script_groups(paper) for path in group]
NAMES = {path: f"{path.parent.name}/{path.name}" for path in SCRIPTS}


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=name, marks=[pytest.mark.slow] if path.name in SLOW or name in SLOW else [])
        for path, name in NAMES.items()
    ],
)
def test_a_script_gives_the_known_numbers(path, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(path.parent))
    module = collect.load_script(path)
    page = compute_page(module.main, path, module.__doc__, tmp_path)
    assert page.failures == []
    assert page.rows or any(kind == "table" for kind, _ in page.blocks)
    for kind, content in page.blocks:
        assert kind != "figure" or (tmp_path / content[0]).stat().st_size > 1000


def test_every_script_is_in_the_list_of_its_paper():
    written = [path for path in PAPERS.glob("*/*.py") if "def main(page: Page)" in path.read_text()]
    assert sorted(SCRIPTS) == sorted(written)


@pytest.mark.parametrize(
    ("row", "verdict"),
    [
        (Row("", "1.2342", 1.23424999), "reproduced"),
        (Row("", "1.2342", 1.234251), "not reproduced: 0.0041 % off"),
        (Row("", "1/5", 0.2001, near=0.2, within=1e-3), "reproduced"),
        (Row("", "at most 2", 1.9, most=2.0), "bound kept"),
        (Row("", "3, 1", "3, 1"), "reproduced"),
        (Row("", "2.5", 3.0, draws=(2.0, 3.0, 4.0)), "percentile 33"),
        (Row("", "1.5", 3.0, draws=(2.0, 3.0, 4.0)), "not reproduced: outside all samples"),
    ],
)
def test_a_verdict_follows_from_the_numbers(row, verdict):
    assert row.verdict == verdict


def test_another_number_than_the_known_one_is_a_failure(tmp_path):
    page = Page("script", tmp_path)
    page.compare("kept", "2.7", 2.70708, found="2.7071")
    page.compare("drifted", "2.7", 2.70708, found="2.7061")
    page.compare("not as printed, and not known to be so", "2.6", 2.70708)
    page.compare("known not to be as printed", "2.6", 2.70708, found="2.7071")
    page.compare("another word", "more", "less")
    assert [one.partition(":")[0] for one in page.failures] == [
        "drifted", "not as printed, and not known to be so", "another word"
    ]  # fmt: skip
