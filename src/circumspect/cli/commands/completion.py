"""`circumspect completion SHELL`."""

from __future__ import annotations

import contextlib
import io
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args, get_origin, get_type_hints

import tyro

from circumspect.cli.model_flag import NAMES

# The script of tyro completes commands, flags and their values. The additions below complete files
# for words that are no flags, names of classifiers and planners after their flags, and the
# arguments of commands such as `data fetch`.
BASH = """
_circumspect() {
  local cur="${COMP_WORDS[COMP_CWORD]}" own="" reply=() word
  _tyro_circumspect
  case "${COMP_WORDS[1]}" in
@OWN@
  esac
  for word in "${COMPREPLY[@]}"; do
    # A file may have a command's name.
    [[ -n "$word" && ( $COMP_CWORD == 1 || ! -e "$word" ) ]] || continue
    [[ "$cur" == -* || "$word" != -* ]] && reply+=("$word")
  done
  (( COMP_CWORD == 2 )) && reply+=($(compgen -W "$own" -- "$cur"))
  case "${COMP_WORDS[COMP_CWORD-1]}" in
@VALUES@
  esac
  COMPREPLY=("${reply[@]}")
  # Nothing of ours: bash completes files itself, and knows folders from files.
  (( COMP_CWORD > 1 && ${#COMPREPLY[@]} == 0 )) && compopt -o default 2>/dev/null
  return 0
}
complete -F _circumspect circumspect
"""
ZSH = """
case "${words[CURRENT-1]}" in
@VALUES@
esac
if (( CURRENT > 2 )) && [[ "$PREFIX" != -* && "${words[CURRENT-1]}" != --* ]]; then
  (( CURRENT == 3 )) && case "${words[2]}" in
@OWN@
  esac
  _files
fi
"""
FISH = """
function _circumspect_words
    count (commandline -opc)
end
function _circumspect_takes_a_file
    test (_circumspect_words) -ge 2
    and not string match --quiet -- '--*' (commandline -opc)[-1]
end
complete --command circumspect --force-files --condition _circumspect_takes_a_file
@VALUES@
@OWN@
"""
VALUES = {"--model": NAMES, "--planner": ("normals", "circle", "confidence")}
"""Known names after a flag that also accepts a file or MODULE:NAME."""
OWN = {
    "bash": (
        BASH,
        '    {0}) own="{1}" ;;',
        '    {0}) reply=($(compgen -W "{1}" -- "$cur")) ;;',
    ),
    "zsh": (ZSH, "    {0}) compadd -- {1} ;;", "  {0}) compadd -- {1}; _files; return ;;"),
    "fish": (
        FISH,
        "complete --command circumspect --arguments '{1}' "
        "--condition '__fish_seen_subcommand_from {0}; and test (_circumspect_words) -eq 2'",
        "complete --command circumspect --force-files --arguments '{1}' "
        "--condition 'string match --quiet -- {0} (commandline -opc)[-1]'",
    ),
}


@dataclass(frozen=True)
class Completion:
    """Print a script with which your shell completes commands, flags and files.

    $ circumspect completion bash >> ~/.bash_completion
    $ circumspect completion zsh > ~/.zfunc/_circumspect
    $ circumspect completion fish > ~/.config/fish/completions/circumspect.fish
    $ source <(circumspect completion bash)

    The first three lines work in new shells, the last one in the current bash.

    zsh needs in ~/.zshrc: fpath+=~/.zfunc; autoload -Uz compinit; compinit
    """

    shell: tyro.conf.Positional[Literal["bash", "zsh", "fish"]]
    """Your shell."""

    def run(self) -> int:
        """Print the script."""
        print(script(self.shell), end="")  # noqa: T201
        return 0


def script(shell: str) -> str:
    """The completion script for a shell.

    Args:
        shell: "bash", "zsh" or "fish".
    """
    from circumspect.cli.flags import parse_any

    commands = _commands()
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.suppress(SystemExit):
        parse_any(commands, "circumspect", ["--tyro-print-completion", shell])
    extra, line, value_line = OWN[shell]
    own = [(name, " ".join(_own_words(kind))) for name, (kind, _) in commands.items()]
    lines = "\n".join(line.format(name, words) for name, words in own if words)
    values = "\n".join(value_line.format(flag, " ".join(names)) for flag, names in VALUES.items())
    extra = extra.replace("@OWN@", lines).replace("@VALUES@", values)
    return output.getvalue().rstrip() + "\n" + extra


def _commands() -> dict[str, tuple[Any, str]]:
    """Name of each command to its class and summary."""
    from circumspect.cli.main import command, installed_commands

    return {name: (command(name), summary) for name, summary in installed_commands().items()}


def _own_words(kind: Any) -> tuple[str, ...]:
    """The known values of the first argument of a command, if there are any."""
    from circumspect.cli.commands.models import Models
    from circumspect.cli.commands.scan import Scan
    from circumspect.furniture import CATEGORIES

    if kind is Scan:
        return CATEGORIES
    if kind is Models:
        return NAMES
    first = get_type_hints(kind)[fields(kind)[0].name]
    return get_args(first) if get_origin(first) is Literal else ()
