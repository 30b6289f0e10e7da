"""Gymnasium knows the environments, whichever is imported first, and nobody pays for it who does not use it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from granular_env.domains import environments

ROOT = Path(__file__).resolve().parent.parent


def run(script: str) -> str:
    """What a script prints in a fresh process."""
    done = subprocess.run([sys.executable, "-W", "error", "-c", script], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


MAKE = "env = gymnasium.make('granular_env/Protection-v1', grains=4); print(env.spec.id, type(env.unwrapped).__name__)"
IMPORTS = {
    "ours first": "import granular_env, gymnasium",
    "gymnasium first": "import gymnasium, granular_env",
    "a part of gymnasium first": "import gymnasium.spaces, granular_env, gymnasium",
    "ours twice": "import granular_env; granular_env.envs.registration.register_when_imported(); import gymnasium",
    "ours again later": "import granular_env, gymnasium; granular_env.envs.registration.register_when_imported()",
}


@pytest.mark.parametrize("imports", IMPORTS.values(), ids=IMPORTS)
def test_any_order_of_imports_will_do(imports: str) -> None:
    assert run(f"{imports}; {MAKE}") == "granular_env/Protection-v1 ChainEnv"


def test_gymnasium_imports_us_by_name() -> None:
    script = "import gymnasium; print(gymnasium.make('granular_env:granular_env/Piston-v1', grains=4).unwrapped.task.name)"
    assert run(script) == "piston"


def test_gymnasiums_own_word_for_registration_works() -> None:
    script = """
import gymnasium, granular_env
gymnasium.register_envs(granular_env)
print(gymnasium.make("granular_env/Absorption-v1", grains=8).unwrapped.task.name)
"""
    assert run(script) == "absorption"


def test_importing_us_imports_no_gymnasium() -> None:
    assert run("import sys, granular_env, granular_env.envs; print('gymnasium' in sys.modules)") == "False"


def test_gymnasium_is_imported_as_ever() -> None:
    """Nothing stays behind: the finder has gone, the loader is its own again."""
    script = """
import sys, granular_env, gymnasium
import gymnasium.envs.registration as registration
print([finder for finder in sys.meta_path if "granular" in type(finder).__module__])
print(vars(registration.__spec__.loader).keys() & {"exec_module"})
print(registration.__spec__.loader is registration.__loader__, sorted(n for n in registration.registry if "granular" in n))
"""
    assert run(script) == f"[]\nset()\nTrue {sorted(environments())}"


def test_a_missing_gymnasium_is_missed_only_when_it_is_needed() -> None:
    script = """
import sys
sys.modules["gymnasium"] = None
import granular_env, granular_env.envs
try:
    from granular_env.domains.chain.tasks.piston import make_piston
except ImportError as error:
    print(type(error).__name__)
"""
    assert run(script) == "ModuleNotFoundError"
