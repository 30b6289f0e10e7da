"""The atlas: verdicts from numbers, entries that fail, constants that move figures, the page and the data, the command line."""

import dataclasses
import json
import math
import re
import subprocess
import sys

import numpy as np
import pytest
from support.atlas_toys import HOSTILE, experiment, toy

from granular_env import atlas
from granular_env.atlas import papers
from granular_env.atlas import plane as plane_drawing
from granular_env.atlas.context import Context
from granular_env.atlas.drawing import draw
from granular_env.atlas.model import Arrows, Axis, Curve, Entry, Figure, Findings, Letter, Mark, Shading
from granular_env.atlas.seed_statistics import Band
from granular_env.atlas.verdicts import Value, combine
from granular_env.cli import main
from granular_env.components.errors import GranularError, MissingExtraError, ParameterError, StepError
from granular_env.recording import verify


def built(folder, paper=None, constants=None, **options):
    done = atlas.compute(paper or toy(), folder, constants, **options)
    atlas.write(done, folder)
    return done, json.loads((folder / "atlas.json").read_text()), (folder / "index.html").read_text()


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("atlas")
    return folder, *built(folder)


# -- verdicts --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "kind", "words"),
    [
        (Value("", "1.2342", 1.234213), "reproduced", "reproduced"),
        (Value("", "1.2342", 1.23424999), "reproduced", "reproduced"),
        (Value("", "1.2342", 1.234251), "not reproduced", "0.004 % off"),
        (Value("", "-.0068", -0.00676), "reproduced", "reproduced"),
        (Value("", "2.708", 2.707083, relative=4e-4, source="said"), "reproduced", "reproduced to 0.03 %"),
        (Value("", "2.708", 2.706, relative=4e-4, source="said"), "not reproduced", "0.07 % off"),
        (Value("", "2.708", 2.707083, loose=2e-3), "in part", "only to 0.0009"),
        (Value("", "1.05", 1.0425), "not reproduced", "0.7 % off"),
        (Value("", "5.6e12", 5.64e12), "reproduced", "reproduced"),
        (Value("", "5.6e12", 6.391e12), "not reproduced", "14 % off"),
        (Value("", "about 10", 10.435, "%"), "reproduced", "reproduced"),
        (Value("", "0.915", 0.90747), "not reproduced", "0.8 % off"),
        (Value("", "7", 7), "reproduced", "reproduced"),
        (Value("", "7", 8), "not reproduced", "1 off"),
        (Value("", "about 10", 4.27, "µs"), "not reproduced", "57 % off"),
        (Value("", "unchanged", -1.15, "%", paper=0.0, loose=2.0), "in part", "only to 1.1 %"),
        (Value("", "unchanged", -2.15, "%", paper=0.0, loose=2.0), "not reproduced", "2.1 % off"),
        (Value("", "unchanged", 1e-12, "%", paper=0.0, loose=2.0, resolution=1e-10), "reproduced", "reproduced"),
        (Value("", "at most 2", 1.9, paper=2.0, at_most=True), "bound kept", "bound kept"),
        (Value("", "at most 2", 2.008, paper=2.0, at_most=True), "not reproduced", "0.008 more"),
        (Value("", "much less than 1", 0.07, at_most=True, loose=0.1), "in part", "kept as we read it"),
        (Value("", "much less than 1", 0.17, at_most=True, loose=0.1), "not reproduced", "0.07 more"),
        (Value("", "slight", 10.05, "%", at_most=True, loose=10.0, digits=2), "not reproduced", "just above 10 %"),
        (Value("", "at most 2", math.nan, paper=2.0, at_most=True), "not reproduced", "nan more"),
        (Value("", "3, 1", "3, 1"), "reproduced", "reproduced"),
        (Value("", "3, 1", "1, 3"), "not reproduced", "“1, 3”, not “3, 1”"),
        (Value("", "much larger", "much larger", reading="more than twice"), "in part", "as we read it"),
        (Value("", "much larger", "smaller", reading="more than twice"), "not reproduced", "“smaller”, not “much larger”"),
        (Value("", "near 27", 26.1, "grains", paper=27.0, loose=1.0), "in part", "only to 0.9 grains"),
        (Value("", "1", math.nan), "not reproduced", "not finite"),
        (Value("", None, 5.0), "no figure", "the paper gives none"),
        (Value("", "2.5", 3.0, band=Band.of([2.0, 3.0, 4.0])), "as bands", "33"),
        (Value("", "1.5", 3.0, band=Band.of([2.0, 3.0, 4.0])), "not reproduced", "the paper’s is below all 3 draws"),
    ],
)  # fmt: skip
def test_a_verdict_comes_from_the_numbers(value, kind, words):
    assert (value.verdict.kind, value.verdict.words) == (kind, words)


def test_the_verdict_of_several_values():
    yes, near, no = Value("a", "1", 1), Value("b", "100.0", 100.06, relative=1e-3, source="said"), Value("c", "1", 2)
    silent, drawn = Value("d", None, 3.0), Value("e", "2.5", 3.0, band=Band.of([2.0, 4.0]))
    assert combine([yes, silent]).words == "reproduced"
    assert combine([yes, near]).words == "reproduced to 0.06 %"
    assert combine([near, no]).kind == "in part"
    assert combine([near, no]).words == "in part: b: yes to 0.06 %; c: no, 1 off"
    assert combine([near] * 3 + [no] * 5).words == "in part: of 8 values 5 not reproduced, 3 reproduced"
    assert combine([no, silent]).words == "not reproduced: 1 off"
    assert combine([no, no]).words == "not reproduced: c: 1 off"
    assert combine([drawn, drawn]).words == "as bands: the paper’s draw at percentile 50, 50"
    assert combine([drawn, yes]).kind == "as bands"
    assert combine([drawn, no]).kind == combine([drawn, yes, no]).kind == "in part"
    assert combine([drawn, no]).words == "in part: e: at percentile 50; c: no, 1 off"
    assert combine([silent]).kind == "no figure"
    read = Value("g", "much", "much", reading="twice")
    assert combine([read, silent]).words == combine([read, read]).words == "as we read it"
    assert combine([read, yes]).kind == "in part" and combine([read, yes]).words == "in part: g: as we read it; a: yes"
    bound = Value("f", "at most 2", 1.0, paper=2.0, at_most=True)
    assert combine([bound]).words == "bound kept" and combine([bound, bound]).words == "bounds kept"
    assert combine([bound, yes]).kind == "reproduced" and combine([bound, no]).words == "in part: f: kept; c: no, 1 off"


def test_a_tolerance_without_a_source_is_refused():
    for stated in ({"tolerance": 0.1}, {"relative": 0.1}):
        with pytest.raises(ValueError, match="a tolerance needs a source in the paper; without one use loose"):
            Value("a", "1.0", 1.0, **stated)
    with pytest.raises(ValueError, match="a reading is for words; for a number use loose"):
        Value("a", "1.0", 1.0, reading="about one")


def test_ours_is_shown_with_the_digits_that_have_converged():
    assert Value("", None, 1.2342134, digits=5).display_value == 1.2342 and Value("", None, 7).display_value == 7
    noise = Value("", "none", 3e-14, "%", paper=0.0, resolution=1e-10)
    assert noise.display_value == 1e-10 and noise.below_resolution
    assert not Value("", "none", 3e-9, "%", paper=0.0, resolution=1e-10).below_resolution


def test_a_band_says_where_a_draw_stands():
    band = Band.of(np.arange(1.0, 101.0))
    assert (band.count, band.mean, band.low, band.high) == (100, 50.5, 1.0, 100.0)
    assert band.deviation == pytest.approx(29.0115, abs=1e-4) and band.error_of_mean == pytest.approx(2.90115, abs=1e-5)
    assert band.percentile(25.5) == 25.0 and band.percentile(25.0) == 24.5
    assert str(band) == "50 ± 29 [6, 95]" and str(Band.of([2.6, 2.6])) == "2.600 ± 0.000 [2.600, 2.600]"


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-3.2e-7, 5.1e-7), (1.24, 1.26), (0.0, 5.45e5), (-11.0, 900.0)])
def test_ticks_are_few_and_round(low, high):
    figure = Figure("f", "", "", Axis("across"), Axis("up", low=0.0, high=1.0), [Curve("", [low, high], [0.0, 1.0])])
    names = re.findall(r"text-anchor: middle[^>]*>([^<]*)</text>", draw(figure))
    names = names[: names.index("across")]
    assert 3 <= len(names) <= 8 and len(set(names)) == len(names)
    places = [float(name.replace("\u2212", "-")) for name in names]
    steps = np.diff(places)
    assert steps == pytest.approx(steps[0], rel=1e-6) and f"{steps[0]:.3e}"[0] in "125" and f"{steps[0]:.3e}"[1:5] == ".000"


def test_a_figure_is_drawn_the_same_each_time_and_its_marks_stay_inside():
    curve = Curve("", [0.0, 1.0], [0.0, 1.0])
    figure = Figure(
        "f", "1 < 2", "", Axis("$5 and $6"), Axis("up", low=0.0, high=1.0), [curve], [Mark("in", y=0.5), Mark("out", y=2.0)]
    )
    drawn = draw(figure)
    assert drawn == draw(figure)
    assert 'aria-label="1 &lt; 2"' in drawn and ">$5 and $6<" in drawn and ">in<" in drawn and ">out<" not in drawn


def plane(**parts):
    limits = Axis("x", 0.0, 4.0), Axis("y", -2.0, 0.0)
    return Figure("plane", "A plane", "", *limits, **{"equal": True, **parts})


def test_a_plane_has_one_scale_along_both_axes():
    drawn = draw(plane(curves=[Curve("", [0.0, 4.0], [-2.0, 0.0], "dashed")]))
    [path] = re.findall(r'<path d="M ([\d.]+) ([\d.]+) \nL ([\d.]+) ([\d.]+) \n?"[^>]*stroke-dasharray: (?!none)', drawn)
    x0, y0, x1, y1 = map(float, path)
    assert (x1 - x0) / (y0 - y1) == pytest.approx(2.0, rel=1e-3)
    with pytest.raises(ValueError, match="figure 'f': equal axes need their limits"):
        draw(Figure("f", "", "", Axis("x"), Axis("y", 0.0, 1.0), equal=True))


def test_a_shade_gets_darker_with_its_magnitude_and_has_a_scale():
    values = np.array([[0.0, 0.25, 1.0], [4.0, np.nan, 2.0]])
    ink = plane_drawing._ink(values, 4.0, Shading("v", [], [], values, power=0.5))
    assert ink[..., 3].tolist() == [[0.0, 0.25, 0.5], [1.0, 0.0, pytest.approx(0.5**0.5)]]
    assert ink[..., :3].max() == 0.0
    signed = plane_drawing._ink(np.array([-2.0, 2.0]), 4.0, Shading("v", [], [], values, signed=True))
    assert signed[0, 3] == signed[1, 3] == 0.5 and signed[0, :3].tolist() != signed[1, :3].tolist()
    drawn = draw(plane(shading=Shading("speed, m/s", np.arange(5.0), np.linspace(-2.0, 0.0, 3), np.ones((3, 5)))))
    assert drawn.count("<image") == 2 and ">speed, m/s<" in drawn and ">1<" in drawn and ">0.4<" in drawn


def test_arrows_point_where_vectors_do_and_letters_stand_where_they_are():
    arrows = Arrows("velocity", [1.0, 3.0, 2.0], [-1.0, -1.0, -1.5], [1.0, 0.0, 0.0], [0.0, -4.0, 0.0], longest=1.0, power=0.5)
    drawn = draw(plane(arrows=arrows, letters=[Letter("P", 2.0, -1.0, 1)]))
    shapes = [
        np.array(re.findall(r"[ML] (-?[\d.]+) (-?[\d.]+)", path), dtype=float)
        for path in re.findall(r'd="([^"]+)"[^>]*--c0', drawn)
    ]
    sizes = [np.ptp(shape, axis=0) for shape in shapes]
    # Half as long where the vector is a quarter; none where it is zero.
    assert len(sizes) == 2 and sizes[0][0] > 3.0 * sizes[0][1] and sizes[1][1] > 3.0 * sizes[1][0]
    assert sizes[1][1] == pytest.approx(2.0 * sizes[0][0], rel=0.02)
    assert ">P<" in drawn


def test_the_data_hold_what_lies_in_a_plane(tmp_path):
    shading = Shading("speed", [0.0, 1.0], [0.0, 2.0], [[1.0, 2.0], [3.0, 4.23456]])
    arrows = Arrows("velocity", [0.5], [-0.5], [1e-9], [0.0], longest=1.0)
    figure = plane(shading=shading, arrows=arrows, letters=[Letter("P", 1.0, -1.0)])
    entry = Entry("plane", "1", "Plane", "Text.", lambda context: Findings([], [figure]))
    _, data, page = built(tmp_path, dataclasses.replace(toy(), entries=[entry]))
    [kept] = data["entries"][0]["figures"]
    assert kept["shading"] == {"label": "speed", "x": "0 1", "y": "0 2", "values": "1 2\n3 4.235"}
    assert kept["arrows"] == {"label": "velocity", "x": "0.5", "y": "-0.5", "u": "1e-09", "v": "0"}
    assert kept["letters"] == [{"text": "P", "x": 1.0, "y": -1.0}]
    assert page.count("<image") == 2 and ">velocity<" in page


def test_without_matplotlib_nothing_is_computed(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=r"the atlas needs the package matplotlib.*granular-env\[view\]"):
        atlas.compute(toy(), tmp_path / "out")
    assert not (tmp_path / "out").exists()


# -- failing entries -------------------------------------------------------------------------------------------------


def test_a_failed_entry_is_red_and_the_others_go_on(made):
    _, done, data, page = made
    assert [one.entry.name for one in done.failed] == ["failing", "broken"]
    by_name = {entry["name"]: entry for entry in data["entries"]}
    assert by_name["failing"]["error"] == "GranularError: the piston fell off <b>"
    assert by_name["broken"]["error"].startswith("IndexError")
    assert by_name["struck"]["items"] and by_name["strange"]["items"] and by_name["struck"]["error"] is None
    assert page.count('class="failed"') == 3 and "the piston fell off &lt;b&gt;" in page
    assert "atlas_toys.py" in page  # where the error of nobody's came from


def test_with_processes_it_is_the_same(made, tmp_path):
    assert built(tmp_path, processes=2)[1] == made[2]


def test_the_exit_status_tells(monkeypatch, tmp_path, capsys):
    for fails, status in ((True, 1), (False, 0)):
        monkeypatch.setattr(papers, "paper", lambda name, fails=fails: toy(fails=fails))
        monkeypatch.setattr(atlas, "paper", papers.paper)
        folder = tmp_path / str(status)
        assert main(["atlas", "toy-2000", "--out", str(folder), "--processes", "1"]) == status
        printed = capsys.readouterr().out
        assert f"page: {folder / 'index.html'}" in printed and ("failed: failing: " in printed) == fails
    assert main(["atlas", "toy-2000", "--out", str(tmp_path / "q"), "--processes", "1", "--quiet"]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'q' / 'index.html'}\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nesterenko-1984"], "did you mean 'nesterenko-1983'?"),
        (["nesterenko-1983", "--set", "B=1"], "constants.B: nesterenko-1983 has none of that name"),
        (["nesterenko-1983", "--set", "N=3"], "constants.N: got 3, expected a whole number from 40 to 300"),
        (["nesterenko-1983", "--set", "N=3"], "from 40 to 300; it is grains in"),
        (["nesterenko-1983", "--set", "N=50.5"], "expected a whole number"),
        (["nesterenko-1983", "--set", "A=much"], "constants.A: got 'much', expected a number"),
        (["nesterenko-1983", "--set", "A=nan"], "constants.A: got nan, expected a number"),
        (["nesterenko-1983", "--set", "N=50", "--set", "N=60"], "constant 'N': given twice, as 50 and 60; give it once"),
        (["nesterenko-1983", "--only", "3.4-pistol"], "did you mean '3.4-piston'?"),
        (["nesterenko-1983", "--only", "3.4-piston", "--only", "3.4-piston"], "entries: '3.4-piston' is named 2 times"),
        (["nesterenko-1983", "--processes", "0"], "processes: got 0"),
        (["nesterenko-1983", "--out", "/dev/null/atlas", "--only", "2-continuum"], "cannot be written"),
    ],
)
def test_wrong_arguments_are_named(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["atlas", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said and not said.startswith("\n")
    assert not (tmp_path / "atlas").exists()


def test_a_process_that_dies_is_told(tmp_path):
    code = (
        "import os\nfrom support.atlas_toys import *\nfrom granular_env import atlas\n"
        "from granular_env.components.errors import *\nfrom dying import die\n"
        "if __name__ == '__main__':\n"
        "    paper = toy()\n    paper.entries.append(Entry('dies', '5', 'Dies', 'Text.', die, weight=9.0))\n"
        f"    try:\n        atlas.compute(paper, {str(tmp_path)!r}, processes=2)\n"
        "    except GranularError as error:\n        print(error)\n"
    )
    (tmp_path / "dying.py").write_text("import os\ndef die(context):\n    os._exit(3)\n")
    script = tmp_path / "script.py"
    script.write_text(code)
    import os

    here = os.path.dirname(__file__)
    path = os.pathsep.join([str(tmp_path), here, os.path.dirname(here)])
    ended = subprocess.run(
        [sys.executable, str(script)], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=120
    )
    assert "entry 'dies': its process ended with status 3" in ended.stdout, ended.stderr


# -- constants, data, page, logs ------------------------------------------------------------------------------------


def test_constants_move_the_figures(made, tmp_path):
    _, _, before, _ = made
    changed = built(tmp_path, constants={"k": 1e10, "N": 5}, only=["struck"])
    after, page = changed[1], changed[2]
    assert after["constants"] == {"k": 1e10, "N": 5} and [entry["name"] for entry in after["entries"]] == ["struck"]
    old, new = (data["entries"][0]["figures"][0]["curves"][0] for data in (before, after))
    assert old["x"] == new["x"] and old["y"] != new["y"]
    assert max(new["y"]) == pytest.approx(max(old["y"]), rel=1e-3) and new["y"].index(max(new["y"])) < old["y"].index(
        max(old["y"])
    )
    assert "Not the paper’s constants" in page and "granular-env atlas toy-2000 --out FOLDER --set k=10000000000.0" in page


def test_an_entry_shares_the_run_of_another_and_its_log_replays(made):
    folder, done, data, page = made
    logs = {entry["name"]: entry["logs"] for entry in data["entries"]}
    assert logs["struck"] == logs["again"] and len(logs["struck"]) == 1 and logs["strange"] == []
    assert [path.name for path in (folder / "logs").iterdir()] == data["logs"]
    path = folder / logs["struck"][0]
    assert verify(path).identical
    assert f'href="{logs["struck"][0]}"' in page and f"granular-env replay {logs['struck'][0]} --verify" in page


def test_the_data_holds_every_figure_with_its_data(made):
    _, done, data, _ = made
    figures = {figure["name"]: figure for entry in data["entries"] for figure in entry["figures"]}
    for one in done.done:
        for figure in one.findings.figures:
            for curve, kept in zip(figure.curves, figures[figure.name]["curves"], strict=True):
                x, y = curve.points()
                assert kept["x"] == pytest.approx(x, rel=1e-8)
                assert [value if value is not None else math.nan for value in kept["y"]] == pytest.approx(
                    y, rel=1e-8, nan_ok=True
                )
            assert len(figures[figure.name]["marks"]) == len(figure.marks)
    drawn = next(item for entry in data["entries"] for item in entry["items"] if item["name"] == "a draw")
    assert drawn["values"][0]["band"]["draws"] == [1.0, 2.0, 3.0, 4.0] and drawn["values"][0]["band"]["percentile"] == 50.0


def test_the_same_atlas_has_the_same_bytes(made, tmp_path):
    built(tmp_path)
    for name in ("atlas.json", "index.html"):
        assert (tmp_path / name).read_bytes() == (made[0] / name).read_bytes()


def test_logs_of_an_earlier_atlas_go_and_nothing_else(tmp_path):
    built(tmp_path, only=["struck"])
    first = {path.name for path in (tmp_path / "logs").iterdir()}
    (tmp_path / "logs" / "mine.mcap").write_bytes(b"mine")
    (tmp_path / "precious.mcap").write_bytes(b"mine")
    data = json.loads((tmp_path / "atlas.json").read_text())
    data["logs"] += ["../precious.mcap", "/etc/hosts", 7]
    (tmp_path / "atlas.json").write_text(json.dumps(data))
    built(tmp_path, constants={"N": 6}, only=["struck"])
    left = {path.name for path in (tmp_path / "logs").iterdir()}
    assert "mine.mcap" in left and not first & left and (tmp_path / "precious.mcap").exists()


def test_a_run_that_fails_leaves_nothing_behind(tmp_path):
    context = Context(tmp_path, {})
    thrown = experiment(4, 5e9) | {"start": {"velocity": {"0": 4000.0}}}
    with pytest.raises(StepError):
        context.run(thrown)
    assert list(tmp_path.iterdir()) == [] and context.log_names() == []


def test_text_is_escaped_and_the_network_forbidden(made):
    page = made[3]
    assert "<script" not in page and HOSTILE.partition(" ")[0] not in page
    assert "default-src 'none'; img-src data:; style-src 'unsafe-inline'" in page
    assert not re.search(r"(?:src|href)=[\"']?(?:https?:)?//", page)
    assert page.count("<svg") == 3 and page.count("<tbody>") == 4


def test_without_a_paper_all_are_listed(capsys):
    assert main(["atlas"]) == 0
    said = capsys.readouterr().out
    assert all(re.search(rf"{name}  +{papers.paper(name).title}", said) for name in atlas.names())


def test_unknown_papers(tmp_path):
    assert atlas.names() == ["gato-shie-2010", "nesterenko-1983", "psakhie-2003"]
    with pytest.raises(ParameterError, match="nesterenko-1983"):
        atlas.paper("nesterenko")
    with pytest.raises(GranularError, match="cannot be written"):
        (tmp_path / "file").write_text("")
        atlas.compute(toy(), tmp_path / "file")
