"""The command ``bristle-sim``: lists the scenarios, or runs one of them as its script does."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module

from bristle_sim.cli.main import BAD_INPUT, INTERRUPTED
from bristle_sim.cli.main import main as run
from bristle_sim.cli.options import Parser
from bristle_sim.cli.output import print_error, print_line
from bristle_sim.cli.scenario import load_scenario, main_scenario, script_paths
from bristle_sim.declared import UnusualValueWarning
from bristle_sim.units import likely_key
from bristle_sim.version import __version__, commit

PROGRAM = "bristle-sim"

COMMANDS = {
    "compare": "compare the passes of two tools: A.toml B.toml [--report FILE.html]",
    "design": "find the tool that gives this: --want QUANTITY=VALUE... --vary KEY=FROM:TO... [--write-tool FILE.toml]",
    "limits": "find where the outcome of a pass changes: KEY=FROM:TO [--set KEY=VALUE]... [--json FILE|-]",
    "explore": "turn a tool's knobs in the browser and see its pass: [FILE.toml] [--port N]",
}
"""Commands besides the scenarios, each with its help text."""

HELP = f"""for example
  {PROGRAM} cue_and_impact --set hub_speed=3000rpm --set bristle_length=25mm --report pass.html
{PROGRAM} SCENARIO --help lists a scenario's options, {PROGRAM} SCENARIO --list-keys its keys with units and ranges"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the scenario or command that the first argument names, and return the exit status.

    Without arguments, list all scenarios and commands.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    first = given[0] if given else ""
    name = first.removesuffix(".py")
    known = script_paths()
    if "_ARGCOMPLETE" in os.environ:
        with suppress(ImportError):  # without the package argcomplete nothing is completed
            from bristle_sim.cli.completion import complete

            complete(known, COMMANDS)
    try:
        if first == "--version":
            print_line(f"{PROGRAM} {__version__}" + (f" (commit {commit()})" if commit() else ""))
        elif first in ("", "-h", "--help"):
            print_line("\n\n".join([overview(), *([HELP] if first else [])]))
        elif first in COMMANDS:
            return _command(first, given[1:])
        elif name in known:
            return run(load_scenario(known[name]), given[1:], program=f"{PROGRAM} {name}")
        elif name.startswith("-"):
            raise ValueError(
                f"{name}: must come after the name of a scenario; {PROGRAM} alone lists them"
            )
        else:
            advice = likely_key(name, known, f"{PROGRAM} alone lists the scenarios")
            raise ValueError(f"unknown scenario {first!r}; {advice}")
    except (ValueError, OSError) as error:
        print_error(f"{PROGRAM}: error: {error}")
        return BAD_INPUT
    return 0


def _command(name: str, given: Sequence[str]) -> int:
    """Run a command that simulates the whole pass, for example ``compare``; return the exit status."""
    place = "explore.entry" if name == "explore" else name
    module = import_module(f"bristle_sim.cli.{place}")
    about = COMMANDS[name].partition(":")[0]
    program = f"{PROGRAM} {name}"
    parser = Parser(prog=program, description=f"{about.capitalize()}.", allow_abbrev=False)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("once", UnusualValueWarning)
            warnings.showwarning = lambda text, *_: print_error(f"{program}: warning: {text}")
            status: int = module.main(main_scenario(), parser, given)
            return status
    except (ValueError, OSError) as error:
        print_error(f"{program}: error: {error}")
        return BAD_INPUT
    except KeyboardInterrupt:
        print_error(f"{program}: ended")
        return INTERRUPTED


def overview() -> str:
    """Return the text that lists the scenarios with their questions, the commands, and the usage.

    The question of a scenario is read from the text of its script, since the import of every script
    would take seconds.
    """
    known = script_paths()
    texts = {name: path.read_text(encoding="utf-8") for name, path in known.items()}
    questions = {
        name: found[1]
        for name, text in texts.items()
        if (found := re.search(r'question="(.*)",', text))
    }
    width = max(map(len, known), default=0)
    lines = [f"  {name:{width}}  {words}" for name, words in questions.items()]
    lines += ["", *(f"  {name:{width}}  {words}" for name, words in COMMANDS.items())]
    usage = f"usage: {PROGRAM} SCENARIO [--set KEY=VALUE]... [--report FILE.html]"
    return "\n".join([f"{usage}; {PROGRAM} --help says more", "", *lines])
