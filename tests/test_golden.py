"""Golden logs are replayed bit for bit, and their runs end in the states pinned here. See `golden_logs.py`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy._core._multiarray_umath import __cpu_features__  # type: ignore[attr-defined]
from support import final_states
from support.chain_tools import run_python
from support.golden_logs import CASES, FOLDER, final_hash, log_path, play_case

import granular_env as ge

FINAL = {
    "piston": "2654590cfb390a76a768d6b26fab1240",
    "two-grains": "14b50ac30748a36bdb01b915072252eb",
    "two-grains-leapfrog": "52838ae174cb9ffd1552a0e8085c18f5",
    "wall-striker": "25c7c928e1c26c4ca1e72672c5f7fd0a",
    "gaps": "90e1dc47177727ae1ad6f6060c08616b",
    "pressed-dimer": "7ddb86b72d10ff61919797e0f1cb2610",
    "random-right-piston": "ca13b1c61a99c873172aed27c4448535",
    "hamming": "ed710df8976c37e5ccfe14b13513281a",
    "rk4": "06270df3f976f946e8de36448ce53d84",
    "kuwabara-kono": "e4d243353cee1fb5c74be472487af35d",
    "viscous-column": "a9f44998e1efc9baf50c473bbe932a6f",
    "elastic-plastic": "33792a8c85ba2af8b295b5d069aab56b",
    "power": "e05ec65993a8af1e17026af1035475eb",
    "oscillator": "96e94df6bb99efd59687d5fbcda22117",
    "discs": "cb3fe30fd4c2f5e38df322fe2583269b",
    "grid-edges": "8a53afaf1c5ba65be0c4dbd126f69da2",
    "grid-yielding": "d7e8e0958b368d24c3d9f1771f843aae",
    "automata-linked": "0523da719ca0600e1e9b7f90fb066c90",
    "automata-cracking": "1032e6c4e799b25c7a203d43e6538d6c",
    "coupled-inclusion": "ff532ff7d80310bcc0b31085e869e388",
    "coupled-layers": "69d27622dcfff695c95ccbd80dad2759",
    "coupled-cracking": "7301e89e925bdc43d51a7e6cd1b766ed",
    "detonation-bursting": "175cc246e01d9c2a8347f8cd0551494e",
    "detonation-nozzle": "e0f3cb915297ba962ace23026ee195c8",
    "shell-bulging": "1dd0b9d0d040bd42ac15f9f9c6c383ee",
    "shell-cracking": "0279062a5b0025ac38df33b9c7631518",
    "tube-burning": "7e1c9c89ccf5a0812f7e2daf3009bda9",
}


def test_every_log_is_pinned_and_small() -> None:
    assert set(FINAL) == set(CASES)
    logs = sorted(FOLDER.glob("*.mcap"))
    assert {path.stem for path in logs} == set(CASES)
    # On average: each new component adds one or two logs. A log also contains all scalar outputs.
    assert sum(path.stat().st_size for path in logs) < 64_000 * len(logs)


@pytest.mark.parametrize("name", CASES)
def test_a_fresh_run_ends_in_the_pinned_state(name: str) -> None:
    assert final_hash(play_case(name)) == FINAL[name]


@pytest.mark.parametrize("name", CASES)
@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_a_golden_log_replays_bit_for_bit(name: str) -> None:
    result = ge.verify(log_path(name))
    assert result.identical, result.message
    assert result.calls > 0 and result.hashes > 0


# OpenBLAS's choices for Intel and AMD processors with AVX2, and with AVX-512, which the processor must support.
@pytest.mark.parametrize("kernels", ["Haswell", "Zen", "SkylakeX"])
def test_golden_logs_are_verified_with_every_choice_of_linear_algebra(kernels: str) -> None:
    if not __cpu_features__["AVX512F" if kernels == "SkylakeX" else "AVX2"]:
        pytest.skip(f"this CPU cannot run the kernels for {kernels}")
    paths = [str(log_path(name)) for name in CASES]
    code = f"import granular_env as ge\nprint([path for path in {paths} if not ge.verify(path).identical])"
    assert run_python(code, OPENBLAS_CORETYPE=kernels) == "[]\n"


@pytest.mark.parametrize("name", CASES)
def test_a_golden_log_holds_the_run(name: str) -> None:
    """The last frame is the final state of the run."""
    component, log = play_case(name), ge.open_log(log_path(name))
    assert log.complete
    names = [name for name, variable in component.variables.items() if variable.state]
    recorded = [name for name in names if name in log.variables]
    assert len(recorded) >= 2
    for variable in recorded:
        _, values = log.series(variable)
        assert np.asarray(values[-1]).tobytes() == np.asarray(component.get(variable)).tobytes()


@pytest.mark.filterwarnings("ignore::granular_env.components.errors.GranularWarning")
def test_a_table_of_final_states_tells_another_state(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [
        "\t".join(row) for name in ("oscillator/pushed", "discs/broken-row") for row in final_states.final_state(name, 0.01)
    ]
    for name in ("before", "after"):
        (tmp_path / name).write_text("\n".join(["\t".join(final_states.COLUMNS), *rows]))
    assert final_states.compare_tables(tmp_path / "before", tmp_path / "after")
    assert capsys.readouterr().out.endswith("4 of 4 rows the same, 0 new\n")
    (tmp_path / "after").write_text("\n".join([rows[0], *rows[:3], rows[3][:-1]]))
    assert not final_states.compare_tables(tmp_path / "before", tmp_path / "after")
    assert "discs/broken-row\tvelocity\t1000\tDIFFERS" in capsys.readouterr().out
