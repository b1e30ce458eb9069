"""The command ``bristle-sim``, and the command line of every scenario script.

The command lists the scenarios, or runs one of them as its script does: it reads the options, runs
the scenario, writes files, and handles Ctrl-C.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from bristle_sim.cli.options import Content, Parser, deliver, parser_of, targets_of
from bristle_sim.cli.output import (
    csv_text,
    document,
    ending_in_order,
    in_words,
    print_error,
    print_line,
    progress,
)
from bristle_sim.cli.scenario import (
    Columns,
    Scenario,
    Values,
    assigned,
    build_parameters,
    load_scenario,
    main_scenario,
    script_paths,
)
from bristle_sim.comparison import Report, Unfinished
from bristle_sim.declared import UnusualValueWarning
from bristle_sim.parameters import Tool
from bristle_sim.tool_file import write_tool
from bristle_sim.units import likely_key
from bristle_sim.version import __version__, commit

# Exit statuses. A shell reports INTERRUPTED for a command that Ctrl-C has ended.
MISSED = 1
BAD_INPUT = 2
INTERRUPTED = 130

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
    program = f"{PROGRAM} {first}" if first in COMMANDS else PROGRAM
    known = script_paths()
    if "_ARGCOMPLETE" in os.environ:
        with suppress(ImportError):  # without the package argcomplete nothing is completed
            from bristle_sim.cli.completion import complete

            complete(known, COMMANDS)
    try:
        if name in known:
            scenario = load_scenario(known[name])
            return run_scenario(scenario, given[1:], program=f"{PROGRAM} {name}")
        if first in COMMANDS:
            return _run_command(first, given[1:], program)
        if first == "--version":
            print_line(f"{PROGRAM} {__version__}" + (f" (commit {commit()})" if commit() else ""))
        elif first in ("", "-h", "--help"):
            print_line("\n\n".join([overview(), *([HELP] if first else [])]))
        elif name.startswith("-"):
            raise ValueError(
                f"{name}: must come after the name of a scenario; {PROGRAM} alone lists them"
            )
        else:
            advice = likely_key(name, known, f"{PROGRAM} alone lists the scenarios")
            raise ValueError(f"unknown scenario {first!r}; {advice}")
    except (ValueError, OSError) as error:
        print_error(f"{program}: error: {error}")
        return BAD_INPUT
    except KeyboardInterrupt:
        print_error(f"{program}: interrupted")
        return INTERRUPTED
    return 0


def _run_command(name: str, given: Sequence[str], program: str) -> int:
    """Run a command that simulates passes of a tool, for example ``compare``, and return the exit
    status.

    Args:
        name: name of the command.
        given: arguments of the command.
        program: name of the program in messages.
    """
    place = "explore.entry" if name == "explore" else name
    module = import_module(f"bristle_sim.cli.{place}")
    about = COMMANDS[name].partition(":")[0].capitalize()
    with warnings.catch_warnings():
        warnings.simplefilter("once", UnusualValueWarning)
        warnings.showwarning = lambda text, *_: print_error(f"{program}: warning: {text}")
        status: int = module.main(main_scenario(), Parser(program, f"{about}."), given)
    return status


def overview() -> str:
    """Return the usage of ``bristle-sim``, the scenarios with their questions, and the commands.

    The question of a scenario is read from the text of its script, because importing all scripts
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


def run_scenario(
    scenario: Scenario, arguments: Sequence[str] | None = None, *, program: str = ""
) -> int:
    """Run a scenario from the command line and return its exit status.

    The exit status is 0 for success, 1 if a quantity misses its tolerance, 2 for bad input, and 130
    after an interruption.

    Args:
        scenario: the scenario.
        arguments: arguments of the command line; by default those of this process.
        program: name of the program in messages; by default the name of the script.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    command = shlex.join([*(program or f"python scenarios/{scenario.name}.py").split(), *arguments])
    program = program or f"{scenario.name}.py"
    remarks = list[str]()
    with ending_in_order(), progress(program), warnings.catch_warnings():
        # typed values have warnings of their own, in one line each
        warnings.simplefilter("ignore", UnusualValueWarning)
        try:
            parser = parser_of(scenario, program, sweeping="--sweep" in command)
            options = parser.parse_args(arguments)
            if options.list_keys:
                print_line(scenario.key_list())
                return 0
            typed = dict[str, Any]()
            if options.parameters is not None:
                typed, remarks = scenario.typed_in(options.parameters)
            typed |= assigned("--set", options.set)
            values = scenario.values_of(typed)
            remarks += scenario.warnings_of(typed, values)
            targets = targets_of(options, scenario, values)
            if options.sweep:
                from bristle_sim.cli.sweep import run_sweep

                run_sweep(scenario, options, typed, targets)
                status = 0
            else:
                status = _carry_out(scenario, options, values, targets, command)
        except (ValueError, OSError) as error:
            print_error(f"{program}: error: {'; '.join([' '.join(str(error).split()), *remarks])}")
            return BAD_INPUT
        except KeyboardInterrupt:
            status = INTERRUPTED
    for line in remarks:
        print_error(f"{program}: warning: {line}")
    if status == INTERRUPTED:
        print_error(f"{program}: interrupted")
    return status


def _carry_out(
    scenario: Scenario,
    options: argparse.Namespace,
    values: Values,
    targets: Mapping[str, Path],
    command: str,
) -> int:
    """Run a scenario, write the requested files, print the answer, and return the exit status.

    ``targets`` holds the path of each requested file, by option. ``command`` is the command line,
    which the report page shows.

    Raises:
        ValueError: for values that contradict each other or are too extreme.
        OSError: if a file cannot be written.
        KeyboardInterrupt: after an interruption. The results of finished parts are delivered.
    """
    try:
        report = scenario.run(**scenario.built(values))
    except Unfinished as interruption:
        text = document(scenario.name, values, interruption.report, finished=False)
        deliver(options, targets, {"json": text}, in_words(interruption.report))
        raise
    except ArithmeticError as error:
        if not options.set:
            raise
        raise ValueError(f"{', '.join(options.set)}: must be less extreme ({error})") from error
    contents = _contents(scenario, options, values, targets, command, report)
    deliver(options, targets, contents, in_words(report))
    return MISSED * any(each.ok is False for each in report.quantities)


MOST_ROWS = 1_000_000  # largest number of rows of a CSV file with equally spaced times


def _even_columns(subject: Any, step: float) -> Columns:
    """Return the motion of a run at equally spaced times, as columns of a CSV file.

    Args:
        subject: object whose attribute ``trajectory`` is the run.
        step: time between two rows, s.

    Raises:
        ValueError: for too many rows, or a subject without a motion.
    """
    import numpy as np

    run = getattr(subject, "trajectory", None)
    if run is None:
        raise ValueError("--interval: must be left out, this scenario has no motion to interpolate")
    rows = 1 + int((run.time[-1] - run.time[0]) / step)
    if rows > MOST_ROWS:
        raise ValueError(f"--interval = {step:g} s: must give at most {MOST_ROWS} rows, not {rows}")
    instants = np.minimum(run.time[0] + step * np.arange(rows), run.time[-1])
    columns: Columns = run.at(instants).columns()
    return columns


def _contents(
    scenario: Scenario,
    options: argparse.Namespace,
    values: Values,
    targets: Mapping[str, Path],
    command: str,
    report: Report,
) -> dict[str, Content]:
    """Return the contents of the output files by option, in the order in which they are written.

    Figure, film, tool file and report page are functions that write the file. CSV and JSON are
    texts. The film is written before the page, which includes it.
    """

    def film(target: Path) -> None:
        """Write the film of the run."""
        assert scenario.film is not None
        rate = {} if options.fps is None else {"fps": options.fps}
        scenario.film(report, **(options.size or {})).write(target, **rate)

    def tool_file(target: Path) -> None:
        """Write the file of the tool that the scenario found, or of the simulated tool."""
        write_tool(
            scenario.tool(report) if scenario.tool else build_parameters(Tool, values), target
        )

    def page(target: Path) -> None:
        """Write the report page."""
        from bristle_sim.render.report import write_report

        write_report(
            target,
            report,
            name=scenario.name,
            question=scenario.question,
            command=command,
            keys=scenario.keys(),
            values=values,
            plot=partial(draw, scenario) if scenario.plot or scenario.plots else None,
            plot_is_folder=scenario.plots is not None,
            video=targets.get("video"),
        )

    found: dict[str, Content] = {
        "plot": partial(draw, scenario, report),
        "video": film,
        "write-tool": tool_file,
        "report": page,
    }
    if options.csv is not None:
        assert scenario.series is not None
        write = scenario.formats.get(Path(options.csv).suffix.lower())
        if options.interval is not None:
            found["csv"] = csv_text(_even_columns(report.subject, options.interval))
        else:
            found["csv"] = write(report) if write else csv_text(scenario.series(report))
    if options.json is not None:
        found["json"] = document(scenario.name, values, report)
    return found


def draw(scenario: Scenario, report: Report, path: Path) -> None:
    """Draw the figure of a report to a file, or its figures to a folder or a PDF."""
    if scenario.plot is not None:
        from bristle_sim.render.style import save_figure

        save_figure(scenario.plot(report), path)
    else:
        assert scenario.plots is not None
        scenario.plots(report, path)
