"""A scenario on the command line: options, order of work, interruption, exit status."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any, NoReturn
from warnings import catch_warnings, simplefilter

from bristle_sim.cli.output import (
    csv_text,
    document,
    ending_in_order,
    in_words,
    print_error,
    print_line,
    progress,
    write_text,
)
from bristle_sim.cli.scenario import Columns, Scenario, Values, build_parameters
from bristle_sim.comparison import Report, Unfinished
from bristle_sim.declared import UnusualValueWarning
from bristle_sim.files import checked_target, is_special
from bristle_sim.parameters import Tool
from bristle_sim.tool_file import write_tool
from bristle_sim.units import Range

KINDS = {
    "json": (), "csv": (".csv",), "plot": (".png", ".svg", ".pdf"), "video": (".mp4", ".gif"), "write_tool": (".toml",),
    "report": (".html",),
}  # fmt: skip
"""File suffixes that each option accepts; an empty tuple accepts any."""

ON_STANDARD_OUTPUT = ("json", "csv")  # options whose value - stands for standard output
# Exit statuses; the last is that of a shell after SIGINT.
MISSED = 1
BAD_INPUT = 2
INTERRUPTED = 130


def main(scenario: Scenario, arguments: Sequence[str] | None = None, *, program: str = "") -> int:
    """Run a scenario and return its exit status: 0, 1 (a tolerance missed), 2 (bad input) or 130
    (interrupted).

    ``program`` is the name of the command in messages; by default the name of the script.
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
            work = Work(scenario, options, values, _targets(scenario, options, values), command)
            if options.sweep:
                work.sweep()
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
                status = work.deliver(report, status)
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
    """Return the values of all keys by file and options; warnings are added to ``remarks``."""
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
MOST_ROWS = 1_000_000  # rows of a CSV at equal intervals


def _even_columns(subject: Any, interval: str) -> Columns:
    """Return the motion of a report's subject at equal intervals, typed with a unit or in s.

    Raises:
        ValueError: for an interval that is refused, or a subject without a motion.
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
    """A requested run of a scenario: values of its keys, files to write, and the command that
    repeats it.
    """

    scenario: Scenario
    options: argparse.Namespace
    values: Values
    targets: Mapping[str, Path]
    command: str

    def __post_init__(self) -> None:
        """Refuse an interval of rows without a time series."""
        given = self.options.interval is not None
        if given and (self.options.csv is None or self.options.sweep):
            raise ValueError("--interval: must be given with --csv, and without --sweep")

    def deliver(self, report: Report, status: int) -> int:
        """Write the requested files and print the answer; return the exit status.

        Of an interrupted run only the JSON is written.
        """
        texts = {}
        options = self.options
        if self.scenario.series is not None and options.csv is not None and not status:
            write = self.scenario.formats.get(Path(options.csv).suffix.lower())
            if options.interval is not None:
                text = csv_text(_even_columns(report.subject, options.interval))
            else:
                text = csv_text(self.scenario.series(report)) if write is None else write(report)
            texts["csv"] = text.removesuffix("\n")
        if options.json is not None:
            texts["json"] = document(self.scenario.name, self.values, report, finished=not status)
        for option in sorted(self.targets, key=texts.__contains__):
            target = self.targets[option]
            if status and option != "json":
                continue
            try:
                if option in texts:
                    write_text(target, texts[option])
                else:
                    _write(self, option, target, report)
            except OSError as error:
                raise OSError(
                    f"{_flag(option)} = {str(target)!r}: {error.strerror or error}"
                ) from error
            if option != "json":
                print_error(f"{_flag(option)}: wrote {target}")
        shown = "json" if options.json == "-" else "csv" if options.csv == "-" else ""
        print_line(texts.get(shown) or in_words(report))
        return status or (MISSED if False in map(attrgetter("ok"), report.quantities) else 0)

    def sweep(self) -> None:
        """Run the scenario over one or two keys."""
        from bristle_sim.cli.sweep import run_sweep

        run_sweep(self.scenario, self.options, self.targets)


def _write(work: Work, option: str, target: Path, report: Report) -> None:
    """Write the picture, film, tool or page that an option requests."""
    scenario = work.scenario
    options = work.options
    if option == "plot":
        draw(scenario, report, target)
    elif option == "video" and scenario.film is not None:
        scenario.film(report, **(options.size or {})).write(
            target, **({"fps": options.fps} if options.fps else {})
        )
    elif option == "write_tool":
        write_tool(
            build_parameters(Tool, work.values) if scenario.tool is None else scenario.tool(report),
            target,
        )
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
    """Draw the figure of a report to a file, or its figures to a folder."""
    if scenario.plot is not None:
        from bristle_sim.render.style import save_figure

        save_figure(scenario.plot(report), path)
    else:
        assert scenario.plots is not None
        scenario.plots(report, path)


def _flag(option: str) -> str:
    return f"--{option.replace('_', '-')}"


def _targets(scenario: Scenario, options: argparse.Namespace, values: Values) -> dict[str, Path]:
    """Return the files that the options name, after checks that each can be written and none is
    named twice.

    Several options may name a device such as /dev/null.
    """
    found = dict[str, Path]()
    seen = dict[str, str]()
    of_sweep = (options.workers is not None, options.store is not None, bool(options.quantity))
    if not options.sweep and any(of_sweep):
        raise ValueError("--workers, --store, --quantity: must be given with --sweep")
    if options.json == options.csv == "-":
        raise ValueError("--csv = '-': must be a file where --json is on standard output")
    if options.video is None and (options.size or options.fps):
        raise ValueError("--size, --fps: must be given with --video")
    for name, suffixes in KINDS.items():
        path = getattr(options, name)
        if path is None or (path == "-" and name in ON_STANDARD_OUTPUT):
            continue
        if options.sweep and name in ("video", "report", "write_tool"):
            raise ValueError(f"{_flag(name)}: must be left out with --sweep")
        suffix = Path(path).suffix.lower()
        folder = name == "plot" and scenario.plots is not None and suffix != ".pdf"
        if folder and suffix in suffixes:
            raise ValueError(
                f"--plot = {path!r}: must be a folder, or a file name that ends in .pdf"
            )
        kinds = (*suffixes, *scenario.formats) if name == "csv" else suffixes
        kinds = () if name == "csv" and is_special(Path(path)) else kinds
        found[name] = checked_target(path, kinds, option=_flag(name), folder=folder)
    named = [("--parameters", options.parameters)]
    for key, (declared, _) in scenario.keys().items():
        if declared.unit == "file":
            named.append((key, values[key]))
    for option, path in [*named, *found.items()]:
        if path is not None and not is_special(Path(path)):
            place = os.path.realpath(path)
            shown = _flag(option) if option in KINDS else option
            if place in seen:
                raise ValueError(
                    f"{shown} = {str(path)!r}: must differ from the file of {seen[place]}"
                )
            seen[place] = shown
    return found


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Raise ValueError, which ``main`` reports in one line."""
        unknown = message.removeprefix("unrecognized arguments: ")
        if unknown != message:
            setting = "=" in unknown and not unknown.startswith("-")
            advice = (
                f"did you mean --set {unknown}?"
                if setting
                else f"{self.prog} --help lists the options"
            )
            raise ValueError(f"{message}; {advice}")
        raise ValueError(message)


def _size(text: str) -> dict[str, int]:
    """Return width and height of a picture."""
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if found is None:
        raise argparse.ArgumentTypeError(
            f"{text!r}: must be WIDTHxHEIGHT, such as 1280x720 (in px)"
        )
    return {"width": int(found[1]), "height": int(found[2])}


APPENDED: dict[str, Any] = {"action": "append", "default": []}

OPTIONS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "set": ("KEY=VALUE", "set a key, in SI units or with a unit (27mm); the last value of a key counts", APPENDED),
    "parameters": ("FILE.toml", "read the tool from a file; --set overrides it", {}),
    "json": ("FILE", "write the results as JSON; - for standard output", {}),
    "csv": ("FILE.csv", "write the time series, one row a sample; - for standard output", {}),
    "interval": ("TIME", "evenly spaced rows of the CSV, such as 10us, in place of the samples", {}),
    "plot": ("FILE", "draw a figure (PNG, SVG, PDF)", {}),
    "video": ("FILE", "render a video (MP4, GIF)", {}),
    "size": ("WIDTHxHEIGHT", "size of the video, in px", {"type": _size}),
    "fps": ("NUMBER", "frames per second of the video", {"type": float}),
    "report": ("FILE.html", "write a page with question, answer, figures and parameters", {}),
    "write_tool": ("FILE.toml", "write the tool that was run, or that the scenario found", {}),
    "workers": ("N", "number of processes of a sweep; -1: one for each core", {"type": int}),
    "store": ("FOLDER", "keep finished points of a sweep, and go on from them", {}),
    "quantity": ("NAME", "a quantity that a sweep shows, in place of all that change; repeatable", APPENDED),
    "sweep": ("KEY=FROM:TO:N", "run N equally spaced values of a key; twice for two keys; --csv, --json and --plot then"
              " show all points", APPENDED),
}  # fmt: skip
"""Metavariable, help and further settings of each option."""


def parser_of(
    scenario: Scenario, program: str, *, sweeping: bool = False
) -> argparse.ArgumentParser:
    """Return a parser of the options of a scenario, or of a sweep of it.

    The other options have the value None.
    """
    parser = _Parser(prog=program, description=scenario.question, allow_abbrev=False)
    left_out = set[str]()
    if "hub_speed" not in scenario.keys():  # noqa: SIM118
        left_out |= {"parameters", "write_tool"}
    if scenario.film is None:
        left_out |= {"video", "size", "fps"}
    if scenario.series is None and not sweeping:
        left_out |= {"csv", "interval"}
    if not (scenario.plot or scenario.plots or sweeping):
        left_out.add("plot")
    for name, (metavar, words, how) in OPTIONS.items():
        if name in left_out:
            parser.set_defaults(**{name: None})
        else:
            place = "FOLDER|FILE.pdf" if name == "plot" and scenario.plots else metavar
            parser.add_argument(_flag(name), metavar=place, help=words, **how)
    parser.add_argument("--list-keys", action="store_true", help="list every key and stop")
    for key in scenario.options:
        setting: dict[str, Any] = {"dest": "set", "action": "append", "type": f"{key}={{}}".format}
        parser.add_argument(f"--{key}", metavar="VALUE", help=f"--set {key}=VALUE", **setting)
    return parser
