"""Shell completion of scenarios, options and parameter names.

It needs the package argcomplete, an optional dependency.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

import argcomplete

from bristle_sim.cli.options import parser_of
from bristle_sim.cli.scenario import load_scenario


def complete(scripts: Mapping[str, Path], commands: Iterable[str]) -> None:
    """Print the possible completions of a partly typed command line for the shell, and exit.

    If the value of a parameter is one of several words, ``--set`` has one completion for each word.
    ``--sweep`` has none for this parameter.

    Args:
        scripts: the scripts of all scenarios, by name.
        commands: the names of all commands.
    """
    typed = os.environ.get("COMP_LINE", "").split()
    if len(typed) > 1 and typed[1] in scripts:
        scenario = load_scenario(scripts[typed[1]])
        parser = parser_of(scenario, scenario.name, sweeping=True)
        for action in parser._actions:
            if action.dest in ("set", "sweep"):
                words = {
                    f"{key}={option}": ""
                    for key, declared in scenario.keys().items()
                    for option in getattr(declared, "options", ("",))
                    if not option or action.dest == "set"
                }
                action.completer = argcomplete.ChoicesCompleter(words)  # type: ignore[attr-defined]
        parser.add_argument("scenario", choices=[*scripts, *commands])
    else:
        parser = argparse.ArgumentParser()
        parser.add_argument("scenario", choices=[*scripts, *commands])
        parser.add_argument("tools", nargs="*")  # files of a command
    argcomplete.autocomplete(parser, exit_method=sys.exit)
