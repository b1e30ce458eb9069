"""Run a scenario from the command line: options, order of work, interruption, exit status."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn
from warnings import catch_warnings, simplefilter

from bristle_sim.cli.ending import ending_in_order
from bristle_sim.cli.output import csv_text, document, in_words, progress, say, tell
from bristle_sim.cli.scenario import Scenario, Values, tool_of
from bristle_sim.comparison import Report, Unfinished
from bristle_sim.files import checked_target, complete_or_absent, is_special
from bristle_sim.tool_file import write_tool
from bristle_sim.units import UnusualValueWarning

KINDS = {
    "json": (), "csv": (".csv",), "plot": (".png", ".svg", ".pdf"), "video": (".mp4", ".gif"), "report": (".html",),
    "write_tool": (".toml",),
}  # fmt: skip
"""Suffixes of the files that an option may name; none admits any."""

ON_STANDARD_OUTPUT = ("json", "csv")  # options that take - for it

MISSED, BAD_INPUT, INTERRUPTED = 1, 2, 130  # exit statuses; the last is a shell's after SIGINT


def main(scenario: Scenario, arguments: Sequence[str] | None = None, *, program: str = "") -> int:
    """Run a scenario and return its exit status: 0, 1 (a tolerance missed), 2 (bad input) or 130 (interrupted).

    ``program`` is the name of the command in messages; by default the script's.
    """
    arguments, remarks = sys.argv[1:] if arguments is None else arguments, list[str]()
    command = shlex.join([*(program or f"python scenarios/{scenario.name}.py").split(), *arguments])
    program = program or f"{scenario.name}.py"
    with ending_in_order(), progress(program), catch_warnings():
        simplefilter("ignore", UnusualValueWarning)  # those of typed values are printed in one line each
        try:
            if sys.stdout is None:
                raise OSError("standard output: must be open")
            options = _parser(
                scenario, program, sweeping=any(each.startswith("--sweep") for each in arguments)
            ).parse_args(arguments)
            if options.list_keys:
                say(scenario.key_list())
                return 0
            if options.parameters is not None:
                from_file, remarks = scenario.assignments_from(options.parameters)
                options.set = [*from_file, *options.set]
            values = scenario.values_of(options.set)
            remarks += scenario.warnings_of(options.set, values)
            status = _answer(scenario, options, values, command) if not options.sweep else _swept(scenario, options)
        except (ValueError, OSError) as error:
            line = "; ".join([" ".join(str(error).split()), *remarks])
            tell(f"{program}: error: {line}")
            return BAD_INPUT
        except KeyboardInterrupt:
            status = INTERRUPTED
    for line in remarks:
        tell(f"{program}: warning: {line}")
    if status == INTERRUPTED:
        tell(f"{program}: interrupted")
    return status


def _answer(scenario: Scenario, options: argparse.Namespace, values: Values, command: str) -> int:
    """Run the scenario, write the requested files, print the answer; return the exit status."""
    targets = _targets(scenario, options, values)
    try:
        report, status = _run(scenario, values, options.set), 0
    except Unfinished as interruption:
        report, status = interruption.report, INTERRUPTED
    text = document(scenario.name, values, report, finished=not status)
    series = "" if status else _write_files(scenario, report, values, targets, options, command)
    if (target := targets["json"]) is not None:
        _written("json", target, lambda: _write_text(target, text + "\n"))
    say(text if options.json == "-" else series if options.csv == "-" else in_words(report))
    return status or (MISSED if any(row.ok is False for row in report.quantities) else 0)


def _swept(scenario: Scenario, options: argparse.Namespace) -> int:
    """Run the scenario over one or two keys."""
    try:
        from bristle_sim.cli.sweep import run_sweep

        return run_sweep(scenario, options)
    except ImportError as error:
        raise ValueError(f"--sweep needs the extra sweep: pip install bristle-sim[sweep] ({error})") from error


def _run(scenario: Scenario, values: Values, assignments: Sequence[str]) -> Report:
    try:
        return scenario.answer(values)
    except ArithmeticError as error:
        if not assignments:
            raise
        raise ValueError(f"{', '.join(assignments)}: must be less extreme ({error})") from error


def _write_files(
    scenario: Scenario,
    report: Report,
    values: Values,
    targets: dict[str, Path | None],
    options: argparse.Namespace,
    command: str,
) -> str:
    """Write all files but the JSON; return the time series, which is computed first, since it may be refused."""
    series = csv_text(scenario.series(report)) if scenario.series is not None and options.csv is not None else ""

    def make_page(path: Path) -> None:
        from bristle_sim.render.report import write_report

        write_report(
            path,
            report,
            name=scenario.name,
            question=scenario.question,
            command=command,
            parameters=[(declared, values[key], default) for key, (declared, default) in scenario.keys().items()],
            plot=_draw(scenario),
            plot_is_folder=scenario.plots is not None,
            video=targets["video"],
        )

    def make_film(path: Path) -> None:
        if scenario.film is not None:
            scenario.film(report, **(options.size or {})).write(path, **({"fps": options.fps} if options.fps else {}))

    def make_plot(path: Path) -> None:
        if (draw := _draw(scenario)) is not None:
            draw(report, path)

    def make_tool(path: Path) -> None:
        write_tool(tool_of(values) if scenario.tool is None else scenario.tool(report), path)

    makers: dict[str, Callable[[Path], None]] = {
        "plot": make_plot,
        "video": make_film,
        "csv": lambda path: _write_text(path, series),
        "write_tool": make_tool,
        "report": make_page,
    }
    for option, make in makers.items():
        if (target := targets[option]) is not None:
            _written(option, target, lambda make=make, target=target: make(target))  # type: ignore[misc]
            tell(f"{_flag(option)}: wrote {target}")
    return series.removesuffix("\n")


def _draw(scenario: Scenario) -> Callable[[Report, Path], None] | None:
    """Return the function that draws a report's figure, or figures, to a path."""
    if (plot := scenario.plot) is None:
        return scenario.plots

    def draw(report: Report, path: Path) -> None:
        from bristle_sim.render.style import save_figure

        save_figure(plot(report), path)

    return draw


def _written(option: str, target: Path, write: Callable[[], None]) -> None:
    """Write a file; an error names option and file."""
    try:
        write()
    except OSError as error:
        raise OSError(f"{_flag(option)} = {str(target)!r}: {error.strerror or error}") from error


def _write_text(target: Path, text: str) -> None:
    with complete_or_absent(target) as partial:
        partial.write_text(text, encoding="utf-8", newline="")


def _flag(option: str) -> str:
    return f"--{option.replace('_', '-')}"


def _targets(scenario: Scenario, options: argparse.Namespace, values: Values) -> dict[str, Path | None]:
    """Return the files that the options name, once it is sure that each can be written and none is named twice.

    A device such as /dev/null may serve several options.
    """
    found = dict.fromkeys(KINDS, None) | dict[str, Path | None]()
    if options.workers is not None or options.store is not None:
        raise ValueError("--workers, --store: must be given with --sweep")
    if options.json == options.csv == "-":
        raise ValueError("--csv = '-': must be a file where --json is on standard output")
    if options.video is None and (options.size or options.fps):
        raise ValueError("--size, --fps: must be given with --video")
    for name, suffixes in KINDS.items():
        path = getattr(options, name)
        if path is None or (path == "-" and name in ON_STANDARD_OUTPUT):
            continue
        suffix = Path(path).suffix.lower()
        folder = name == "plot" and scenario.plots is not None and suffix != ".pdf"
        if folder and suffix in suffixes:
            raise ValueError(f"--plot = {path!r}: must be a folder, or a file name that ends in .pdf")
        any_kind = suffixes if name != "csv" or not is_special(Path(path)) else ()
        found[name] = checked_target(path, any_kind, option=_flag(name), folder=folder)
    inputs = [(key, values[key]) for key, (declared, _) in scenario.keys().items() if declared.unit == "file"]
    seen: dict[str, str] = {}
    outputs = [(_flag(name), path) for name, path in found.items()]
    for option, named in [("--parameters", options.parameters), *inputs, *outputs]:
        if named is None or is_special(Path(named)):
            continue
        place = os.path.realpath(named)
        if place in seen:
            raise ValueError(f"{option} = {str(named)!r}: must be another file than that of {seen[place]}")
        seen[place] = option
    return found


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Raise, so that ``main`` reports it in one line."""
        unknown = message.removeprefix("unrecognized arguments: ")
        if unknown != message:
            setting = "=" in unknown and not unknown.startswith("-")
            advice = f"did you mean --set {unknown}?" if setting else f"{self.prog} --help lists the options"
            raise ValueError(f"{message}; {advice}")
        raise ValueError(message)


def _parser(scenario: Scenario, program: str, *, sweeping: bool = False) -> _Parser:
    """Return a parser of the options that the scenario has, or that a sweep of it has; others are as if left out."""
    parser = _Parser(prog=program, description=scenario.question, allow_abbrev=False)
    words = "override a parameter, in SI units or with a unit (27mm); the last of a key counts"
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help=words)
    has_tool, pictures = "hub_speed" in scenario.keys(), scenario.plot or scenario.plots  # noqa: SIM118
    where = "FOLDER|FILE.pdf" if scenario.plots else "FILE"
    options: tuple[tuple[str, Any, str, str, Any], ...] = (
        ("parameters", has_tool, "FILE.toml", "read the tool from a file; --set overrides it", str),
        ("json", True, "FILE", "write the results as JSON; - for standard output", str),
        (
            "csv",
            scenario.series or sweeping,
            "FILE.csv",
            "write the time series, one row a sample; - for standard output",
            str,
        ),
        ("plot", pictures or sweeping, where, "draw a figure (png, svg, pdf)", str),
        ("video", scenario.film, "FILE", "render a video (mp4, gif)", str),
        ("size", scenario.film, "WIDTHxHEIGHT", "of the video, in px", _size),
        ("fps", scenario.film, "NUMBER", "pictures a second of the video", float),
        ("report", True, "FILE.html", "write a page with question, answer, figures and parameters", str),
        ("write_tool", has_tool, "FILE.toml", "write the tool that was run, or found", str),
        ("workers", True, "N", "processes of a sweep; -1: one a core", int),
        ("store", True, "FOLDER", "keep finished points of a sweep, and go on from them", str),
    )
    for name, offered, what, words, kind in options:
        if offered:
            parser.add_argument(_flag(name), metavar=what, help=words, type=kind)
        else:
            parser.set_defaults(**{name: None})
    words = "the quantities over one key, or two by two options, in N steps; with --csv, --json and --plot of the table"
    parser.add_argument("--sweep", metavar="KEY=FROM:TO:N", action="append", default=[], help=words)
    parser.add_argument("--list-keys", action="store_true", help="list every key and stop")
    for key in scenario.options:
        setting: dict[str, Any] = {"dest": "set", "action": "append", "type": f"{key}={{}}".format}
        parser.add_argument(f"--{key}", metavar="VALUE", help=f"--set {key}=VALUE", **setting)
    return parser


def _size(text: str) -> dict[str, int]:
    """Return width and height of a picture."""
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"{text!r}: must be WIDTHxHEIGHT, such as 1280x720 (in px)")
    return {"width": int(found[1]), "height": int(found[2])}
