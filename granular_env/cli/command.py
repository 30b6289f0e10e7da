"""Commands of the program: their help, and how their arguments are read."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import click

from granular_env.package_contents import first_sentence

Body = Callable[..., int]


class Command(click.Command):
    """A command: the list of commands shows the first sentence of its docstring, whole."""

    def get_short_help_str(self, limit: int = 45) -> str:
        """Return the first sentence of the help."""
        return first_sentence(self.help or "")

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse; an option whose value is missing does not take the next option for it."""
        options = {name: one for one in self.get_params(ctx) if isinstance(one, click.Option) for name in one.opts}
        before = args[: args.index("--")] if "--" in args else args
        for given, following in itertools.zip_longest(before, before[1:]):
            if given in options and not options[given].is_flag and (following is None or following in options):
                if not ctx.resilient_parsing:
                    raise click.BadOptionUsage(given, f"Option {given!r} requires an argument.", ctx)
        return super().parse_args(ctx, args)


def command(name: str, **attributes: Any) -> Callable[[Body], Command]:
    """Make a command of a function, whose docstring is the help."""
    return click.command(name, cls=Command, **attributes)
