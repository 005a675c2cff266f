"""Completion of commands, options and names in a shell, made from what the commands declare.

As a command: `nlds-vines completion`.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from importlib import import_module

from nlds_vines.bifurcation.request import Scan
from nlds_vines.cli.command_main import DONE, Command, say
from nlds_vines.cli.commands import COMMANDS
from nlds_vines.cli.parser import Parser
from nlds_vines.model.catalogue import catalogue
from nlds_vines.model.contact_laws import LAWS
from nlds_vines.model.scenes import SCENES
from nlds_vines.model.setting import OneOf, settings_of
from nlds_vines.orbits.records import WANTS
from nlds_vines.orbits.solver_settings import TOLERANCES
from nlds_vines.orbits.starts import POLICIES
from nlds_vines.portrait.request import PANELS, PortraitRequest
from nlds_vines.tuning.request import Search

_EXAMPLES = """\
examples:
  eval "$(nlds-vines completion)"
      for this shell; the same line in ~/.bashrc, for all (in zsh after `autoload -U +X bashcompinit
      && bashcompinit`)
exit status: 0 done; 2 the request is wrong
"""

VALUES: Mapping[str, tuple[str, ...]] = {
    "--system": tuple(catalogue()),
    "--tolerance": tuple(TOLERANCES),
    "--law": tuple(LAWS),
    "--start": POLICIES,
    "--record": WANTS,
    "--panels": tuple(PANELS),
} | {
    said.flag: tuple(said.check.words)
    for owner in (Scan, Search, PortraitRequest)
    for said in settings_of(owner).values()
    if isinstance(said.check, OneOf) and said.has_option
}
"""What may follow an option, where it is one of some words, or several with commas."""

POSITIONAL: Mapping[str, tuple[str, ...]] = {"compile": tuple(SCENES)}
"""What a command takes besides options, where it is no file."""

_SCRIPT = """\
_nlds_vines() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} words= head=
    if [ "$COMP_CWORD" -eq 1 ]; then
        words='{commands} --help --version'
    else
        case "$before" in
{values}
        *)
            case "${{COMP_WORDS[1]}} $word" in
{options}
            esac
            ;;
        esac
    fi
    if [[ $word == *,* ]]; then head=${{word%,*}},; fi
    COMPREPLY=($(compgen -P "$head" -W "$words" -- "${{word##*,}}"))
}}
complete -o default -F _nlds_vines nlds-vines"""


def script() -> str:
    """Return a script for bash that completes the command line; where nothing fits, file names."""
    values = (f"        {name}) words='{' '.join(words)}' ;;" for name, words in VALUES.items())
    return _SCRIPT.format(
        commands=" ".join(COMMANDS), values="\n".join(values), options="\n".join(_cases())
    )


def _cases() -> Iterator[str]:
    """Yield what completes a word of each command: its options, then what else it takes."""
    for name, (module, _) in COMMANDS.items():
        own = [text for text in options_of(module) if text.startswith("--")]
        yield f"            '{name} -'*) words='{' '.join(own)}' ;;"
        if name in POSITIONAL:
            yield f"            '{name} '*) words='{' '.join(POSITIONAL[name])}' ;;"


def options_of(module: str) -> list[str]:
    """Return the options that the command of a module declares."""
    command: Command = import_module(module).main.__self__
    parser = Parser(prog=command.name)
    command.declare(parser)
    return list(parser._option_string_actions)


def _carry_out(options: argparse.Namespace) -> int:
    say(*script().splitlines())
    return DONE


def _declare(parser: Parser) -> None:
    parser.add_argument("shell", nargs="?", default="bash", choices=["bash"], help="[bash]")


COMMAND = Command(
    name="completion",
    description="Print what completes commands and options in a shell.",
    examples=_EXAMPLES,
    declare=_declare,
    carry_out=_carry_out,
)
main = COMMAND.main
