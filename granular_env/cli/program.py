"""The program `granular-env`: its commands, and how each of them ends."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import click
from click.shell_completion import shell_complete

from granular_env.cli import check, completion, contents, events, logs, runs, studies, sweeps, views
from granular_env.cli.command import Command
from granular_env.cli.exit_status import MEANINGS, Status
from granular_env.cli.failures import discard_output, open_missing_streams, report_failure, report_misuse

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
    sweeps.sweep,
    studies.study,
    completion.completion,
)


class Program(click.Group):
    """The group of the commands, in the order of their table."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names."""
        return list(self.commands)


program = Program(
    completion.PROGRAM,
    COMMANDS,
    help="Wave and fracture experiments in granular media: run, record, replay, branch, see.",
    epilog=f"Begin with: granular-env list; granular-env run nesterenko-1983/3.4-piston\n\n{MEANINGS}",
    context_settings={"help_option_names": ["-h", "--help"]},
)
click.version_option(package_name="granular-env", message="%(prog)s %(version)s", help="Print the version.")(program)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: those of the command line; of the process where there are none.

    Returns:
        The exit status, a `Status`.
    """
    open_missing_streams()
    if instruction := os.environ.get(completion.VARIABLE):
        return shell_complete(program, {}, completion.PROGRAM, completion.VARIABLE, instruction)
    given = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    try:
        return _run(given)
    except click.ClickException as misuse:
        return report_misuse(misuse)
    except BrokenPipeError:  # the reader closed the pipe
        discard_output()
        return Status.DONE
    except (Exception, KeyboardInterrupt) as failure:
        return report_failure(next((program.commands[one] for one in given if one in program.commands), None), failure)


def _run(given: list[str]) -> int:
    try:
        with program.make_context(completion.PROGRAM, given) as context:
            status = program.invoke(context)
    except click.exceptions.Exit as end:  # after --help and --version
        status = end.exit_code
    sys.stdout.flush()
    return status
