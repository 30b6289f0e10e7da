"""The command line: parses, calls, prints. What the commands do is in `commands`, imported once it is known which one."""

from __future__ import annotations

import argparse
import os
import sys
import textwrap
from collections.abc import Sequence

from granular_env.components.errors import GranularError, Override, Term, nearest, shortened
from granular_env.terminal import printable

_ERROR, _FAULT, _INTERRUPTED = 2, 70, 130
_STATUSES = (
    "exit status: 0 done; 1 a verification found a difference, a file is not whole, or a task, an entry or a trial failed; "
    "2 an error, told in one message; 3 a verification of a log that is incomplete or holds no step; 70 a fault of "
    "granular-env itself; 130 ended by Ctrl-C"
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns:
        The exit status, as in `_STATUSES`.
    """
    _open_missing_streams()
    given = list(sys.argv[1:] if arguments is None else arguments)
    parser = _parser()
    if not given:
        parser.print_help()
        return 0
    parsed = _parse(parser, given)
    if getattr(parsed, "quiet", False):
        os.environ.setdefault("GRANULAR_ENV_QUIET", "1")
    try:
        from granular_env.commands import COMMANDS

        status = COMMANDS[parsed.command](parsed)
        sys.stdout.flush()
        return status
    except GranularError as error:
        _tell(parsed.command, "\n".join([error.text(command_words), *getattr(error, "__notes__", ())]))
        return _ERROR
    except MemoryError:
        _tell(parsed.command, "it asks for more memory than there is; ask for less")
        return _ERROR
    except KeyboardInterrupt:
        _tell(parsed.command, "interrupted")
        return _INTERRUPTED
    except BrokenPipeError:
        # The reader closed the pipe; discard what Python would flush at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # of the system: a full disk behind standard output, too many open files, a folder that is gone
        where = f"{error.filename!r}: " if error.filename is not None else ""
        _tell(parsed.command, f"{where}the system refused it: {error.strerror or error}")
        _discard_output()
        return _ERROR
    except Exception:
        import traceback

        traceback.print_exc()
        _tell(parsed.command, "this is a fault of granular-env, not of what you gave; please report it with the lines above")
        return _FAULT


def _parse(parser: argparse.ArgumentParser, given: list[str]) -> argparse.Namespace:
    """Parse arguments; a mistyped command is answered with the nearest, an unknown option with its command's usage."""
    commands = next(action for action in parser._actions if isinstance(action, argparse._SubParsersAction)).choices
    command = next((one for one in given if not one.startswith("-")), None)
    if command is not None and command not in commands:
        parser.error(f"there is no command {shortened(command)}; {nearest(command, commands)}")
    parsed, unknown = parser.parse_known_args(given)
    if unknown:
        own = commands[parsed.command]
        options = [option for action in own._actions for option in action.option_strings]
        close = nearest(unknown[0], options) if unknown[0].startswith("-") else ""
        own.error(f"unrecognized arguments: {' '.join(unknown)}" + (f"; {close}" if close.startswith("did you") else ""))
    return parsed


def _tell(command: str, message: str) -> None:
    lines = [printable(line) for line in message.split("\n")]
    print(f"granular-env {command}: " + "\n".join(lines), file=sys.stderr)


def _open_missing_streams() -> None:
    """Give programs that were begun with closed streams ones that lead nowhere, so that no file takes their place."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free number: this one
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


def _discard_output() -> None:
    """Throw away what Python would flush at exit, where standard output cannot be written."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _Version(argparse.Action):
    """Prints the version, looked up only now."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import version

        print(f"granular-env {version('granular-env')}")
        parser.exit()


def command_words(term: Term) -> str:
    """Return an option or an override as it is given on the command line."""
    if isinstance(term, Override):
        return f"--set {shortened(term.text, 60)}"
    option = f"--{term.name.replace('_', '-')}"
    return option if term.value is True else f"{option} {term.value}"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="granular-env",
        description="Wave experiments in granular media: run, record, replay, branch, see.",
        epilog=f"Begin with: granular-env list; granular-env run nesterenko-1983/3.4-piston\n\n{textwrap.fill(_STATUSES, 78)}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _experiment_commands(commands)
    _log_commands(commands)
    _atlas_command(commands)
    _sweep_command(commands)
    _study_command(commands)
    return parser


def _experiment_commands(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    listing = commands.add_parser("list", help="the components, experiments, plans and studies that come with the package")
    listing.add_argument("--json", action="store_true", help="for programs")

    describe = commands.add_parser("describe", help="a component's variables, or the file of an experiment, a plan or a study")
    describe.add_argument("name", metavar="NAME", help="a name of `granular-env list`, or a TOML file")
    describe.add_argument("--json", action="store_true", help="for programs")
    _set_option(describe, "a component's parameter, such as grains=5: shapes and inputs depend on them")

    new = commands.add_parser("new", help="write a file to start from: of an experiment, a plan of a sweep or a study")
    new.add_argument(
        "template",
        metavar="TEMPLATE",
        help="an experiment, plan or study to copy, a log whose experiment to write, or a component for all its parameters",
    )
    new.add_argument("-o", "--out", metavar="FILE", help="the TOML file to write (default: print it)")
    new.add_argument("--force", action="store_true", help="replace the file if it exists")

    run = commands.add_parser("run", help="run an experiment and record it")
    run.add_argument("experiment", metavar="EXPERIMENT", help="a name of `granular-env list`, or a TOML file")
    _set_option(run, "override any key, such as component.grains=500 or start.velocity.0=3")
    where = run.add_mutually_exclusive_group()
    where.add_argument("--log", metavar="PATH", help="where to record it (default: a new file in logs/)")
    where.add_argument("--no-log", action="store_true", help="record nothing")
    run.add_argument("--overwrite", action="store_true", help="replace the log if it exists")
    run.add_argument(
        "--hash-every", metavar="N", type=int, help="hash the state every N ticks; 1 lets a verification name the tick"
    )
    run.add_argument("--live", action="store_true", help="show the run in rerun while it goes on")
    run.add_argument(
        "--pace",
        metavar="SECONDS",
        type=float,
        help="with --live: how long the run takes to watch (default: 10; 0: no longer than needed)",
    )
    _output_options(run, "log")

    check = commands.add_parser("check", help="validate the file of an experiment, plan or study, or a log, without running it")
    check.add_argument("file", metavar="FILE", help="a TOML file, a name of `granular-env list`, or a log")
    check.add_argument("--json", action="store_true", help="for programs")
    _set_option(check, "as in run")
    _large_option(check)


def _log_commands(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    replay = commands.add_parser(
        "replay",
        help="run a log again",
        epilog="Exit status with --verify: 0 identical; 1 different; 2 it is no log, or cannot be run again; 3 incomplete, "
        "since the log was not closed (what it holds agrees), or nothing was compared, since it holds no step.",
    )
    replay.add_argument("log", metavar="LOG")
    replay.add_argument("--verify", action="store_true", help="compare every hash, frame and snapshot bit for bit")
    replay.add_argument("--json", action="store_true", help="no progress bar; print the result for programs")

    branch = commands.add_parser("branch", help="go on from any instant of a log, with other inputs or the same")
    branch.add_argument("log", metavar="LOG")
    branch.add_argument("--at", metavar="T", type=float, required=True, help="where to leave the log [s]")
    _set_option(branch, "an input from there on, such as input.left_force=100; the others go on as in the log")
    branch.add_argument("--until", metavar="T", type=float, help="where to end [s] (default: where the log ends)")
    branch.add_argument("--log", metavar="PATH", dest="out", help="where to record it (default: a new file in logs/)")
    branch.add_argument("--overwrite", action="store_true", help="replace the branch's log if it exists")
    branch.add_argument("--quiet", action="store_true", help="no progress bar; print only the log's path")

    recover = commands.add_parser("recover", help="make a whole log of one whose program was killed")
    recover.add_argument("log", metavar="LOG")
    recover.add_argument("-o", "--out", metavar="OUT", required=True, help="the log to write")
    recover.add_argument("--overwrite", action="store_true", help="replace OUT if it exists")

    view = commands.add_parser("view", help="look at a log in rerun")
    view.add_argument("log", metavar="LOG")
    how = view.add_mutually_exclusive_group()
    how.add_argument("--web", action="store_true", help="in the browser, served on this machine only")
    how.add_argument("--save", metavar="RRD", help="write a file for rerun instead")
    how.add_argument("--screenshot", metavar="PNG", help="write a picture instead; needs no screen")
    how.add_argument("--foxglove-layout", metavar="JSON", help="write a layout for Foxglove instead, to import there")
    view.add_argument(
        "--exaggerate", metavar="F", type=float, help="draw displacements F times larger (default: so that they are seen)"
    )

    report = commands.add_parser("report", help="write a page with figures of a log")
    report.add_argument("log", metavar="LOG")
    report.add_argument("-o", "--out", metavar="FOLDER", help="where to write it (default: beside the log, by its name)")
    report.add_argument("--variables", metavar="NAME", nargs="+", help="recorded outputs to show (default: all)")
    report.add_argument("--grains", metavar="I", nargs="+", type=int, help="whose histories (default: up to five)")
    report.add_argument("--times", metavar="T", nargs="+", type=float, help="instants of the profiles [s] (default: four)")

    for command in (replay, branch, recover, view, report):
        _large_option(command)


def _large_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--allow-large", action="store_true", help="lift the caps on sizes that a log may declare")


def _atlas_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    atlas = commands.add_parser("atlas", help="compute a paper's figures and numbers anew, on one page beside the printed ones")
    atlas.add_argument("paper", metavar="PAPER", help="such as nesterenko-1983")
    atlas.add_argument("-o", "--out", metavar="FOLDER", help="where to write it (default: atlas/PAPER)")
    _set_option(atlas, "a constant of the paper, such as A=6.391e12 or N=50; the page says what was changed")
    atlas.add_argument("--only", metavar="ENTRY", action="append", default=[], help="compute this entry, not all of them")
    atlas.add_argument("--processes", metavar="N", type=int, default=2, help="how many entries at a time (default: 2)")
    atlas.add_argument("--quiet", action="store_true", help="no progress bar; print only the page's path")


def _sweep_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    sweep = commands.add_parser("sweep", help="run an experiment at many values of its keys, into one table")
    sweep.add_argument("plan", metavar="PLAN", help="a plan of `granular-env list`, or a TOML file")
    sweep.add_argument("-o", "--out", metavar="FOLDER", help="where results are kept (default: sweeps/ and the plan's name)")
    sweep.add_argument(
        "--engine", choices=("processes", "serial", "ray"), default="processes", help="where tasks run (default: processes)"
    )
    sweep.add_argument("--address", metavar="HOST:PORT", help="a Ray cluster (default: one of our own, on this machine)")
    sweep.add_argument("--workers", metavar="N", type=int, help="how many tasks at a time (default: one for each core)")
    _set_option(sweep, "a key of the experiment, for every task, such as component.grains=500")
    sweep.add_argument("--allow-large", action="store_true", help="lift the cap on the number of tasks")
    _output_options(sweep, "table")


def _study_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    study = commands.add_parser("study", help="let methods search for the best drive of a task, and compare them")
    study.add_argument("study", metavar="STUDY", nargs="?", help="a name of `granular-env study --list`, or a TOML file")
    study.add_argument("--list", action="store_true", help="the studies that come with the package, and the tasks")
    study.add_argument("-o", "--out", metavar="FOLDER", help="where its results go (default: studies/NAME)")
    _set_option(study, "override any key, such as budget=100000, task.grains=30 or method.0.population=8")
    study.add_argument("--only", metavar="METHOD", action="append", default=[], help="run only this method (may be repeated)")
    study.add_argument("--overwrite", action="store_true", help="start anew where the folder has results already")
    study.add_argument("--quiet", action="store_true", help="no progress bar; print only the page's path")


def _output_options(parser: argparse.ArgumentParser, product: str) -> None:
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--quiet", action="store_true", help=f"no progress bar; print only the {product}'s path")
    how.add_argument("--json", action="store_true", help="no progress bar; print the result for programs")


def _set_option(parser: argparse.ArgumentParser, text: str) -> None:
    parser.add_argument("--set", metavar="KEY=VALUE", dest="overrides", action="append", default=[], help=text)


if __name__ == "__main__":
    sys.exit(main())
