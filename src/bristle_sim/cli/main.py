"""A scenario on the command line: reads options, runs the scenario, writes files, handles Ctrl-C."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any
from warnings import catch_warnings, simplefilter

from bristle_sim.cli.options import Content, parser_of, targets_of, write_files
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
from bristle_sim.declared import UnusualValueWarning
from bristle_sim.parameters import Tool
from bristle_sim.tool_file import write_tool
from bristle_sim.units import Range

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
            if sys.stdout is None:
                raise OSError("standard output: must be open")
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
                    report = scenario.answer(values)
                except Unfinished as interruption:
                    report = interruption.report
                    status = INTERRUPTED
                except ArithmeticError as error:
                    if not options.set:
                        raise
                    raise ValueError(
                        f"{', '.join(options.set)}: must be less extreme ({error})"
                    ) from error
                work = Work(scenario, options, values, targets, command)
                work.deliver(report, finished=not status)
                if not status and False in map(attrgetter("ok"), report.quantities):
                    status = MISSED
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
    for key in () if options.sweep else {"workers", "store"} & scenario.keys().keys():
        if (given := getattr(options, key)) is not None:
            options.set = [*options.set, f"{key}={given}"]
            setattr(options, key, None)
    values = scenario.values_of(options.set)
    remarks += scenario.warnings_of(options.set, values)
    return values


INTERVAL = Range("interval", "s", 0.0, 1.0, False, "")
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


@dataclass
class Work:
    """A request to run a scenario: the parameter values, the files to write, and the command line."""

    scenario: Scenario
    options: argparse.Namespace
    values: Values
    targets: Mapping[str, Path]
    command: str

    def deliver(self, report: Report, *, finished: bool) -> None:
        """Write the requested files and print the answer.

        After an interruption, only the JSON file is written.
        """
        options = self.options
        texts: dict[str, str] = {}
        if finished and options.csv is not None:
            texts["csv"] = self._csv(report).removesuffix("\n")
        if options.json is not None:
            texts["json"] = document(self.scenario.name, self.values, report, finished=finished)
        # In order: the page shows the film.
        drawn = [name for name in self.targets if finished and name not in ("json", "csv")]
        contents: dict[str, Content] = dict.fromkeys(drawn, partial(_write, self, report))
        write_files(self.targets, contents | texts)
        shown = next((text for name, text in texts.items() if getattr(options, name) == "-"), "")
        print_line(shown or in_words(report))

    def _csv(self, report: Report) -> str:
        """Return the text of the file that ``--csv`` requests, in the format of its suffix."""
        scenario = self.scenario
        assert scenario.series is not None
        write = scenario.formats.get(Path(self.options.csv).suffix.lower())
        if self.options.interval is not None:
            return csv_text(_even_columns(report.subject, self.options.interval))
        return csv_text(scenario.series(report)) if write is None else write(report)


def _write(work: Work, report: Report, option: str, target: Path) -> None:
    """Write the figure, film, tool file or report page that an option requests."""
    scenario = work.scenario
    options = work.options
    if option == "plot":
        draw(scenario, report, target)
    elif option == "video" and scenario.film is not None:
        rate = {} if options.fps is None else {"fps": options.fps}
        scenario.film(report, **(options.size or {})).write(target, **rate)
    elif option == "write_tool":
        found = (
            build_parameters(Tool, work.values) if scenario.tool is None else scenario.tool(report)
        )
        write_tool(found, target)
    else:
        from bristle_sim.render.report import write_report

        write_report(
            target,
            report,
            name=scenario.name,
            question=scenario.question,
            command=work.command,
            parameters=scenario.parameter_rows(work.values),
            plot=partial(draw, scenario) if scenario.plot or scenario.plots else None,
            plot_is_folder=scenario.plots is not None,
            video=work.targets.get("video"),
        )


def draw(scenario: Scenario, report: Report, path: Path) -> None:
    """Draw the figure of a report to a file, or its several figures to a folder or PDF."""
    if scenario.plot is not None:
        from bristle_sim.render.style import save_figure

        save_figure(scenario.plot(report), path)
    else:
        assert scenario.plots is not None
        scenario.plots(report, path)
