"""Mutated files of experiments, plans and studies: any content raises only GranularError, and none hangs."""

import random
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from granular_env.components import catalogue
from granular_env.components.component import Component
from granular_env.components.errors import GranularError, GranularWarning
from granular_env.control.study import load_study
from granular_env.documents import find_file
from granular_env.experiments import load_experiment
from granular_env.experiments.preparation import prepare_experiment
from granular_env.package_contents import shipped_files
from granular_env.sweep import load_plan

VALUES = [
    "nan", "-inf", "1e400", "-1", "0", "1e-300", "9" * 400, '""', '"x"', "true", "[]", "{}", "[[1], [2, 3]]", "[nan]",
    "1979-05-27",
    "{ 0 = 1.0 }", '{ a = "b" }', '"\\u0000"', "07:32:00", "[1, 'a']", '"../../x.csv"', "2.5", "0x10", "[1e-6, 2e-6]", "-0.0",
    "[[1.0, nan]]", "[[[]]]", "[[1], 2]", '{ "3,1" = 2.0 }', "{ 0 = [1, 2], 1 = 3 }", '{ "-1,-1" = [1.0] }', '{ "9,9" = 1 }',
    "[[0, 1], [2, 3]]", '"velocity[3,1]"', '"max |velocity[-1,0]|"', '"final linked[4,4]"', "[[true, false]]", '{ 1.5 = 1 }',
]  # fmt: skip
LINES = [
    "[start]",
    "[input.left_force]",
    "left_force = [1.0, 2.0]",
    "[grid]",
    "[samples]",
    "[[method]]",
    "[[stop]]",
    "[record]",
    "[component]",
    "seed = 1",
    'profile = "table"',
    'variable = "velocity[3,1]"',
    'variable = "force[0]"',
    "gap = 1e-5",
]
FOLDER = find_file("measured/hammer", "experiment", "experiments").parent


@pytest.fixture(scope="module", autouse=True)
def one_of_each() -> Iterator[None]:
    """Cache components by their parameters, which most mutations do not change.

    The cache is somewhat larger than the number of shipped experiments.
    """
    build, built = catalogue.make, dict[tuple[str, str], Component]()

    def make(name: str, **parameters: Any) -> Component:
        key = name, repr(parameters)
        built[key] = built.pop(key, None) or build(name, **parameters)
        if len(built) > 60:
            del built[next(iter(built))]
        return built[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(catalogue, "make", make)
        yield


def mutated(text: str, random: random.Random) -> str:
    lines = text.splitlines()
    for _ in range(random.randint(1, 3)):
        place = random.randrange(len(lines))
        kind = random.randrange(8)
        if kind == 0:
            del lines[place]
        elif kind == 1:
            lines.insert(place, random.choice([*LINES, *lines]))
        elif kind in (2, 3) and "=" in lines[place]:
            lines[place] = lines[place].partition("=")[0] + "= " + random.choice(VALUES)
        elif kind == 4:
            other = random.randrange(len(lines))
            lines[place], lines[other] = lines[other], lines[place]
        elif kind == 5 and lines[place]:
            at = random.randrange(len(lines[place]))
            lines[place] = (
                lines[place][:at] + chr(random.choice([0, 9, 34, 61, 91, 93, 233, 0x1F600, 46, 45])) + lines[place][at + 1 :]
            )
        elif kind == 6:
            lines[place] = lines[place].replace("=", " =", 1) + random.choice([" ]", " }", '"', "", " = 3"])
        elif kind == 7 and lines[place]:
            lines = [*lines[:place], lines[place][: random.randrange(len(lines[place]))]]
        lines = lines or [""]
    return "\n".join(lines)


def is_small(experiment) -> bool:
    """Return whether the experiment builds within milliseconds; a mutation may validly request millions of grains."""
    given = experiment.component.parameters
    shell = given.get("shell")
    body = shell.get("body") if isinstance(shell, dict) else given.get("body")
    counts = [body.get(name) for name in ("along", "around")] if isinstance(body, dict) else []
    return (
        all(count is None or (isinstance(count, int) and count <= 48) for count in counts)
        and given.get("grains", 1) <= 1000
        and given.get("rows", 1) * given.get("columns", 1) <= 400
    )


def try_experiment(path: Path) -> None:
    experiment = load_experiment(path)
    if is_small(experiment):
        prepare_experiment(experiment)


# Kind of document -> kind of shipped items, and the function that reads a file.
KINDS = {
    "experiment": ("experiments", try_experiment),
    "plan": ("plans of sweeps", load_plan),
    "study": ("studies", load_study),
}


def try_mutations(path: Path, seed: int, count: int, kind: str = "experiment", only: str = "") -> int:
    """Read `count` mutations of shipped files, and prepare experiments; return the number of refusals.

    `only` selects files that contain this text.
    """
    shelf, read = KINDS[kind]
    texts = [text for file in shipped_files(shelf).values() if only in (text := file.read_text())]
    source = random.Random(seed)
    refused = 0
    for _ in range(count):
        text = mutated(source.choice(texts), source)
        path.write_text(text, encoding="utf-8", errors="replace")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", GranularWarning)
                read(path)
        except GranularError as error:
            assert str(error) and all(str(fault) for fault in error.faults)
            refused += 1
        except Exception as error:
            raise AssertionError(f"{type(error).__name__} came out of this file:\n{text}") from error
    return refused


def test_mutated_files_give_errors_of_the_family_only(tmp_path):
    (tmp_path / "hammer.csv").write_bytes((FOLDER / "hammer.csv").read_bytes())
    refused = try_mutations(tmp_path / "x.toml", seed=1, count=300)
    assert 120 < refused < 300  # most mutations break a file, some do not


@pytest.mark.parametrize("kind", ["plan", "study"])
def test_mutated_plans_and_studies_give_errors_of_the_family_only(tmp_path, kind):
    assert 100 < try_mutations(tmp_path / "x.toml", seed=3, count=500, kind=kind) < 500


# Documents in the plane: array inputs, rows of start values, indices of several axes.
ARRAYS = {"experiment": "pattern = [[", "plan": "discs/broken-row", "study": "splitting"}


@pytest.mark.parametrize("kind", ARRAYS)
def test_mutated_documents_with_arrays_give_errors_of_the_family_only(tmp_path, kind):
    assert 30 < try_mutations(tmp_path / "x.toml", seed=5, count=200, kind=kind, only=ARRAYS[kind]) < 200


@pytest.mark.slow
def test_twenty_thousand_mutated_files(tmp_path):
    (tmp_path / "hammer.csv").write_bytes((FOLDER / "hammer.csv").read_bytes())
    assert try_mutations(tmp_path / "x.toml", seed=2, count=20_000) > 8_000
