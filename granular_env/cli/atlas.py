"""A paper's figures and numbers, computed anew: `atlas`."""

from __future__ import annotations

from typing import Any

import click

from granular_env.cli.command import Status, command
from granular_env.cli.options import FOLDER, Overrides, quiet_option, set_option
from granular_env.components.errors import ParameterError, one_line
from granular_env.terminal_text import columns, wrap_text


@command("atlas")
@click.argument("paper", required=False, help="Such as nesterenko-1983; without it, list them.")
@click.option("-o", "--out", metavar="FOLDER", type=FOLDER, help="Where to write it (default: atlas/PAPER).")
@set_option("A constant of the paper, such as A=6.391e12 or N=50; the page says what was changed.")
@click.option("--only", metavar="ENTRY", multiple=True, help="Compute this entry, not all of them (may be repeated).")
@click.option("--processes", metavar="N", type=int, default=2, help="How many entries at a time (default: 2).")
@quiet_option("page")
def atlas(paper: str | None, out: str | None, overrides: Overrides, only: tuple[str, ...], processes: int, quiet: bool) -> int:
    """Compute a paper's figures and numbers anew, on one page beside the printed ones."""
    from granular_env.atlas import run_atlas
    from granular_env.atlas.console import closing

    if paper is None:
        _list_papers()
        return Status.DONE
    constants = _constants(overrides)
    if constants and not quiet:
        _print_cost(paper, constants, only)
    done = run_atlas(paper, out, overrides=constants, only=only, processes=processes, progress=not quiet)
    print(done.page if quiet else closing(done))
    return Status.DIFFERENT if done.failed else Status.DONE


def _print_cost(name: str, constants: dict[str, Any], only: tuple[str, ...]) -> None:
    """Print what the page, or these entries of it, takes with these constants, where the paper knows."""
    from granular_env.atlas import chosen, paper
    from granular_env.atlas.constant_overrides import constant_values

    found = paper(name)
    if found.cost is not None:
        entries = [entry.name for entry in chosen(found, only)]
        print(wrap_text(found.cost(constant_values(found, constants), entries)), flush=True)


def _list_papers() -> None:
    """Print the names and titles of the papers that have an atlas."""
    from granular_env.atlas import names, paper

    print(columns((name, paper(name).title) for name in names()))
    print(wrap_text("granular-env atlas PAPER computes one."))


def _constants(overrides: Overrides) -> dict[str, Any]:
    """Return the constants of a paper that --set gives, name -> value, each once."""
    constants: dict[str, Any] = {}
    for override in overrides:
        name, value = ".".join(override.key), override.value
        if name in constants:
            raise ParameterError(
                f"constant {name!r}: given twice, as {one_line(constants[name])} and {one_line(value)}", hint="give it once"
            )
        constants[name] = value
    return constants
