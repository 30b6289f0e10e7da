"""Completion in the shell: what may stand in the place of a word, and the command that switches it on."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import click
from click.shell_completion import CompletionItem, get_completion_class

from granular_env.cli.command import command

PROGRAM = "granular-env"
VARIABLE = "_GRANULAR_ENV_COMPLETE"
_SHELLS = ("bash", "zsh", "fish")
# \b: click leaves the lines as they are.
_SWITCHES = """\b
bash, in ~/.bashrc:                eval "$(granular-env completion bash)"
zsh, in ~/.zshrc, after compinit:  eval "$(granular-env completion zsh)"
fish:  granular-env completion fish > ~/.config/fish/completions/granular-env.fish
"""

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem[str]]]


def names(*kinds: str) -> Completer:
    """Complete the names of what comes with the package, of these kinds; files where no name begins so."""

    def complete(ctx: click.Context, param: click.Parameter, begun: str) -> list[CompletionItem[str]]:
        from granular_env.package_contents import overview

        known = overview() | ({"environments": _environments()} if "environments" in kinds else {})
        found = _beginning({name: line for kind in kinds for name, line in known[kind].items()}, begun)
        return found or files(ctx, param, begun)

    return complete


def _environments() -> dict[str, str]:
    from granular_env.domains import environments

    return dict.fromkeys(environments(), "")


def files(ctx: click.Context, param: click.Parameter, begun: str) -> list[CompletionItem[str]]:
    """Let the shell complete files."""
    return [CompletionItem(begun, type="file")]


def folders(ctx: click.Context, param: click.Parameter, begun: str) -> list[CompletionItem[str]]:
    """Let the shell complete folders."""
    return [CompletionItem(begun, type="dir")]


def _beginning(known: Mapping[str, str], begun: str) -> list[CompletionItem[str]]:
    return [CompletionItem(name, help=line) for name, line in known.items() if name.startswith(begun)]


@command("completion", epilog=_SWITCHES)
@click.argument("shell", type=click.Choice(_SHELLS))
@click.pass_context
def completion(ctx: click.Context, shell: str) -> int:
    """Print the script that switches completion on in a shell."""
    kind = get_completion_class(shell)
    assert kind is not None
    print(kind(ctx.find_root().command, {}, PROGRAM, VARIABLE).source())
    return 0
