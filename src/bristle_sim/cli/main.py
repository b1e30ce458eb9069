"""A scenario on the command line: reads options, runs the scenario, writes files, handles Ctrl-C."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from warnings import catch_warnings, simplefilter

from bristle_sim.cli.options import Content, deliver, parser_of, targets_of
from bristle_sim.cli.output import (
    csv_text,
    document,
    ending_in_order,
    in_words,
    print_error,
    print_line,
    progress,
)
from bristle_sim.cli.scenario import Columns, Scenario, Values, build_parameters
from bristle_sim.comparison import Report, Unfinished
from bristle_sim.declared import Range, UnusualValueWarning
from bristle_sim.parameters import Tool
from bristle_sim.tool_file import write_tool

# Exit statuses. A shell reports INTERRUPTED for a command that Ctrl-C has ended.
MISSED = 1
BAD_INPUT = 2
INTERRUPTED = 130


def main(scenario: Scenario, arguments: Sequence[str] | None = None, *, program: str = "") -> int:
    """Run a scenario from the command line and return its exit status.

    The exit status is 0, or 1 if a quantity misses its tolerance, 2 for bad input, and 130 after an
    interruption. ``program`` is the name of the command in messages; by default the name of the
    script.
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    remarks = list[str]()
    status = 0
    command = shlex.join([*(program or f"python scenarios/{scenario.name}.py").split(), *arguments])
    program = program or f"{scenario.name}.py"
    with ending_in_order(), progress(program), catch_warnings():
        simplefilter(
            "ignore", UnusualValueWarning
        )  # typed values have warnings of their own, in one line each
        try:
            options = parser_of(scenario, program, sweeping="--sweep" in command).parse_args(
                arguments
            )
            if options.list_keys:
                print_line(scenario.key_list())
                return 0
            values = _values(scenario, options, remarks)
            targets = targets_of(scenario, options, values)
            if options.sweep:
                from bristle_sim.cli.sweep import run_sweep

                run_sweep(scenario, options, targets)
            else:
                try:
                    report = scenario.report(values)
                except Unfinished as interruption:
                    report = interruption.report
                    status = INTERRUPTED
                except ArithmeticError as error:
                    if not options.set:
                        raise
                    raise ValueError(
                        f"{', '.join(options.set)}: must be less extreme ({error})"
                    ) from error
                finished = not status
                contents = {}
                if finished:
                    contents = _contents(scenario, options, values, targets, command, report)
                    status = MISSED * any(each.ok is False for each in report.quantities)
                if options.json is not None:
                    contents["json"] = document(scenario.name, values, report, finished=finished)
                deliver(options, targets, contents, in_words(report))
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


def _values(scenario: Scenario, options: argparse.Namespace, remarks: list[str]) -> Values:
    """Return the values of all parameters, from the tool's file and the options.

    Warnings, one line each, are added to the list ``remarks``.
    """
    if options.parameters is not None:
        from_file, idle = scenario.assignments_from(options.parameters)
        options.set = [*from_file, *options.set]
        remarks += idle
    values = scenario.values_of(options.set)
    remarks += scenario.warnings_of(options.set, values)
    return values


INTERVAL = Range("interval", "s", 0.0, 1.0, False)
MOST_ROWS = 1_000_000  # largest number of rows of a CSV file with equally spaced times


def _even_columns(subject: Any, interval: str) -> Columns:
    """Return the motion of a run at equally spaced times, as columns of a CSV file.

    ``subject`` holds the run as ``trajectory``. ``interval`` is the typed time between two rows,
    with a unit or in s.

    Raises:
        ValueError: for a refused interval, or a subject without a motion.
    """
    import numpy as np

    run = getattr(subject, "trajectory", None)
    step = INTERVAL.parse(interval)
    if run is None:
        raise ValueError("--interval: must be left out, this scenario has no motion to interpolate")
    rows = 1 + int((run.time[-1] - run.time[0]) / step)
    if rows > MOST_ROWS:
        raise ValueError(
            f"--interval = {interval!r}: must give at most {MOST_ROWS} rows, not {rows}"
        )
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
    """Return the functions that write figure, film, tool file and report page, and the text of the
    CSV file, by option.

    They are in the order of writing, since the page shows the film.
    """

    def film(target: Path) -> None:
        """Write the film of the run."""
        assert scenario.film is not None
        rate = {} if options.fps is None else {"fps": options.fps}
        scenario.film(report, **(options.size or {})).write(target, **rate)

    def tool_file(target: Path) -> None:
        """Write the file of the tool that was run or found."""
        found = build_parameters(Tool, values) if scenario.tool is None else scenario.tool(report)
        write_tool(found, target)

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

    plot = partial(draw, scenario, report)
    found: dict[str, Content] = {
        "plot": plot,
        "video": film,
        "write_tool": tool_file,
        "report": page,
    }
    if options.csv is not None:
        assert scenario.series is not None
        write = scenario.formats.get(Path(options.csv).suffix.lower())
        if options.interval is not None:
            found["csv"] = csv_text(_even_columns(report.subject, options.interval))
        else:
            found["csv"] = write(report) if write else csv_text(scenario.series(report))
    return found


def draw(scenario: Scenario, report: Report, path: Path) -> None:
    """Draw the figure of a report to a file, or its several figures to a folder or PDF."""
    if scenario.plot is not None:
        from bristle_sim.render.style import save_figure

        save_figure(scenario.plot(report), path)
    else:
        assert scenario.plots is not None
        scenario.plots(report, path)
