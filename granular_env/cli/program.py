"""The program `granular-env`: its commands and its entry point."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click
from click.shell_completion import shell_complete

from granular_env.cli import check, compare, contents, events, export, logs, runs, studies, sweeps, views
from granular_env.cli.command import EXIT_STATUS, Command, Status
from granular_env.cli.failures import discard_output, report_failure, report_misuse

PROGRAM = "granular-env"
# click's shell completion sets this variable; `_GRANULAR_ENV_COMPLETE=bash_source granular-env` prints its script.
VARIABLE = "_GRANULAR_ENV_COMPLETE"
COMMANDS: tuple[Command, ...] = (
    contents.list_shipped,
    contents.describe,
    contents.new,
    runs.run,
    check.check,
    logs.replay,
    logs.branch,
    logs.recover,
    events.events,
    views.view,
    views.report,
    export.export,
    compare.compare,
    sweeps.sweep,
    studies.study,
)


class Program(click.Group):
    """The group of all commands; the help lists them in the order in which the table of this module does."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands, in the order of the help."""
        return list(self.commands)


program = Program(
    PROGRAM,
    COMMANDS,
    help="Wave and fracture experiments in granular media: run, record, replay, branch, view.",
    epilog=f"Begin with: granular-env list; granular-env run nesterenko-1983/3.4-piston\n\n{EXIT_STATUS}",
    context_settings={"help_option_names": ["-h", "--help"]},
)
click.version_option(package_name="granular-env", message="%(prog)s %(version)s", help="Print the version.")(program)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, by default that of the process's arguments, and return its exit status, a `Status`."""
    if instruction := os.environ.get(VARIABLE):
        return shell_complete(program, {}, PROGRAM, VARIABLE, instruction)
    given = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    try:
        return _run_command(given)
    except click.ClickException as misuse:
        return report_misuse(misuse)
    except BrokenPipeError:  # the reader closed the pipe
        discard_output()
        return Status.DONE
    except (Exception, KeyboardInterrupt) as failure:
        return report_failure(next((program.commands[one] for one in given if one in program.commands), None), failure)


def _run_command(arguments: list[str]) -> int:
    try:
        with program.make_context(PROGRAM, arguments) as context:
            status = program.invoke(context)
    except click.exceptions.Exit as end:  # after --help and --version
        status = end.exit_code
    sys.stdout.flush()
    return status
