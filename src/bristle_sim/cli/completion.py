"""Completion in the shell of scenarios, options and parameter names.

It needs the package argcomplete, an optional dependency.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable

import argcomplete

from bristle_sim.cli.options import parser_of
from bristle_sim.cli.scenario import Scenario
from bristle_sim.units import Choice


def complete(scenario: Scenario | None, names: Iterable[str]) -> None:
    """Print the possible completions of a partly typed command line for the shell, and exit.

    Args:
        scenario: the typed scenario; None if no scenario is typed yet.
        names: the names of all scenarios and commands.
    """
    parser = (
        argparse.ArgumentParser()
        if scenario is None
        else parser_of(scenario, scenario.name, sweeping=True)
    )
    for action in parser._actions:
        if scenario is not None and action.dest in ("set", "sweep"):
            words = dict.fromkeys(_assignments(scenario, sweeping=action.dest == "sweep"), "")
            action.completer = argcomplete.ChoicesCompleter(words)  # type: ignore[attr-defined]
    parser.add_argument("scenario", choices=[*names])
    if scenario is None:
        parser.add_argument("tools", nargs="*")  # files of a command
    argcomplete.autocomplete(parser, exit_method=sys.exit)


def _assignments(scenario: Scenario, *, sweeping: bool) -> list[str]:
    """Return completions for ``--set`` or ``--sweep``: each parameter name with ``=``.

    For ``--set``, a parameter that takes a word has one completion for each word. Such a parameter
    cannot be swept.
    """
    found = []
    for key, (declared, _) in scenario.keys().items():
        options = declared.options if isinstance(declared, Choice) else ("",)
        found += [] if sweeping and options != ("",) else [f"{key}={option}" for option in options]
    return found
