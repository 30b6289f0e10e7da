"""Options that several commands share."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial, wraps
from typing import Any

import click
from click.shell_completion import CompletionItem

from granular_env.cli.command import Body
from granular_env.components.errors import Override, ParameterError

Decorator = Callable[[Body], Body]
# For arguments of these types, click itself completes file names in the shell.
FILE, FOLDER = click.Path(), click.Path(file_okay=False)
Overrides = tuple[Override, ...]


class ShippedName(click.ParamType):
    """The type of an argument that is a file or the name of a shipped item of given kinds; the shell completes both."""

    name = "name"

    def __init__(self, *kinds: str) -> None:
        self.kinds = kinds

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem[str]]:
        """Return the completions: shipped names, or files if no name matches."""
        from granular_env.package_contents import shipped_overview

        known = shipped_overview()
        names = {name: line for kind in self.kinds for name, line in known[kind].items() if name.startswith(incomplete)}
        found = [CompletionItem(name, help=line) for name, line in names.items()]
        return found or [CompletionItem(incomplete, type="file")]


ANY_KIND = ShippedName("components", "experiments", "plans of sweeps", "studies")


class QuantityType(click.ParamType):
    """The type of an option with a unit: a number in SI, or a text such as 100us or "3 mm"; the value is a float in SI."""

    def __init__(self, unit: str) -> None:
        self.name = self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the value in SI."""
        from granular_env.components.support.quantities import parse_quantity

        try:
            return parse_quantity(str(value), self.unit)
        except ParameterError as error:
            self.fail(str(error), param, ctx)


TIME = QuantityType("s")


def _parse_overrides(ctx: click.Context, param: click.Parameter, texts: Sequence[str]) -> Overrides:
    if ctx.resilient_parsing or not texts:
        return ()
    from granular_env.documents import parse_assignments

    return parse_assignments(texts)


def _load_components(ctx: click.Context, param: click.Parameter, names: Sequence[str]) -> dict[str, Any]:
    if ctx.resilient_parsing or not names:
        return {}
    from granular_env.components.catalogue import component_class

    return {name: component_class(name) for name in names}


def _silence_compiler(ctx: click.Context, param: click.Parameter, quiet: bool) -> bool:
    if quiet:
        os.environ.setdefault("GRANULAR_ENV_QUIET", "1")
    return quiet


# Decorators that add an option to a command; the second text is the name of the command's argument.
set_option = partial(click.option, "--set", "overrides", metavar="KEY=VALUE", multiple=True, callback=_parse_overrides)
json_option = partial(click.option, "--json", "as_json", is_flag=True, help="Print the result as JSON.")
overwrite_option = partial(click.option, "--overwrite", "overwrite", is_flag=True)
allow_large_option = partial(
    click.option, "--allow-large", "allow_large", is_flag=True, help="Lift the limits on sizes that a log may declare."
)
format_option = partial(
    click.option, "--format", "file_format", type=click.Choice(["png", "svg", "pdf"]), default="png", help="Format of figures."
)
component_option = partial(
    click.option, "--component", "components", metavar="NAME", multiple=True, callback=_load_components,
    help="Allow the component NAME of another installed package; a log alone never loads such code.",
)  # fmt: skip


def output_options(body: Body) -> Body:
    """Add the options --quiet and --json to a command."""
    text = "No progress bar; print only the path of the result."
    return click.option("--quiet", is_flag=True, callback=_silence_compiler, help=text)(json_option()(body))


def exclusive_options(*names: str) -> Decorator:
    """Return a decorator of a command that refuses a command line with more than one of the given options."""

    def decorate(body: Body) -> Body:
        @wraps(body)
        def call(**values: Any) -> int:
            flags = {one.name: one.opts[0] for one in click.get_current_context().command.params}
            given = [flags[name] for name in names if values[name] is not None and values[name] is not False]
            if len(given) > 1:
                raise click.UsageError(f"{given[0]} and {given[1]} exclude each other; give one of them.")
            return body(**values)

        return call

    return decorate
