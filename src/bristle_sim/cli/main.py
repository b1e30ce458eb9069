"""Run a scenario from the command line: options, order of work, interruption, exit status."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, NoReturn
from warnings import catch_warnings, simplefilter

from bristle_sim.cli.ending import ending_in_order
from bristle_sim.cli.output import csv_text, document, in_words, progress, say, tell, write_text
from bristle_sim.cli.scenario import Scenario, Values, tool_of
from bristle_sim.comparison import Report, Unfinished
from bristle_sim.files import checked_target, is_special
from bristle_sim.tool_file import write_tool
from bristle_sim.units import UnusualValueWarning

KINDS = {
    "json": (), "csv": (".csv",), "plot": (".png", ".svg", ".pdf"), "video": (".mp4", ".gif"), "write_tool": (".toml",),
    "report": (".html",),
}  # fmt: skip
"""Suffixes of the files that an option may name, none admits any."""

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
            options = parser_of(scenario, program, sweeping="--sweep" in command).parse_args(arguments)
            if options.list_keys:
                say(scenario.key_list())
                return 0
            if options.parameters is not None:
                from_file, remarks = scenario.assignments_from(options.parameters)
                options.set = [*from_file, *options.set]
            for key in () if options.sweep else {"workers", "store"} & scenario.keys().keys():
                if (given := getattr(options, key)) is not None:
                    options.set.append(f"{key}={given}")
                    setattr(options, key, None)
            values = scenario.values_of(options.set)
            remarks += scenario.warnings_of(options.set, values)
            status = _swept(scenario, options) if options.sweep else _answer(scenario, options, values, command)
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
    targets, status = _targets(scenario, options, values), 0
    try:
        report = scenario.answer(values)
    except Unfinished as interruption:
        report, status = interruption.report, INTERRUPTED
        targets = {"json": targets["json"]}
    except ArithmeticError as error:
        if not options.set:
            raise
        raise ValueError(f"{', '.join(options.set)}: must be less extreme ({error})") from error
    # The time series comes first, since it may be refused.
    texts = {"csv": "", "json": ""}
    if options.json is not None:
        texts["json"] = document(scenario.name, values, report, finished=not status)
    if scenario.series is not None and options.csv is not None and not status:
        texts["csv"] = csv_text(scenario.series(report)).removesuffix("\n")
    for option in sorted(targets, key=texts.__contains__):
        if (target := targets[option]) is not None:
            try:
                if option in texts:
                    write_text(target, texts[option])
                else:
                    _write(option, target, scenario, report, values, options, command, targets["video"])
            except OSError as error:
                raise OSError(f"{_flag(option)} = {str(target)!r}: {error.strerror or error}") from error
            if option != "json":
                tell(f"{_flag(option)}: wrote {target}")
    shown = next((option for option in texts if getattr(options, option) == "-"), None)
    say(in_words(report) if shown is None else texts[shown])
    return status or (MISSED if any(row.ok is False for row in report.quantities) else 0)


def _swept(scenario: Scenario, options: argparse.Namespace) -> int:
    """Run the scenario over one or two keys."""
    try:
        from bristle_sim.cli.sweep import run_sweep

        return run_sweep(scenario, options)
    except ImportError as error:
        raise ValueError(f"--sweep needs the extra sweep: pip install bristle-sim[sweep] ({error})") from error


def _write(
    option: str,
    target: Path,
    scenario: Scenario,
    report: Report,
    values: Values,
    options: argparse.Namespace,
    command: str,
    video: Path | None,
) -> None:
    """Write the picture, film, tool or page that an option requests."""
    if option == "plot":
        _draw(scenario, report, target)
    elif option == "video" and scenario.film is not None:
        scenario.film(report, **(options.size or {})).write(target, **({"fps": options.fps} if options.fps else {}))
    elif option == "write_tool":
        write_tool(tool_of(values) if scenario.tool is None else scenario.tool(report), target)
    elif option == "report":
        from bristle_sim.render.report import write_report

        write_report(
            target,
            report,
            name=scenario.name,
            question=scenario.question,
            command=command,
            parameters=[(declared, values[key], default) for key, (declared, default) in scenario.keys().items()],
            plot=partial(_draw, scenario) if scenario.plot or scenario.plots else None,
            plot_is_folder=scenario.plots is not None,
            video=video,
        )


def _draw(scenario: Scenario, report: Report, path: Path) -> None:
    """Draw the report's figure to a file, or its figures to a folder."""
    if scenario.plot is not None:
        from bristle_sim.render.style import save_figure

        save_figure(scenario.plot(report), path)
    elif scenario.plots is not None:
        scenario.plots(report, path)


def _flag(option: str) -> str:
    return f"--{option.replace('_', '-')}"


def _targets(scenario: Scenario, options: argparse.Namespace, values: Values) -> dict[str, Path | None]:
    """Return the files that the options name, once it is sure that each can be written and none is named twice.

    A device such as /dev/null may serve several options.
    """
    found: dict[str, Path | None] = dict.fromkeys(KINDS)
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


def parser_of(scenario: Scenario, program: str, *, sweeping: bool = False) -> _Parser:
    """Return a parser of the options that the scenario has, or that a sweep of it has; others are as if left out."""
    parser = _Parser(prog=program, description=scenario.question, allow_abbrev=False)
    has_tool, pictures = "hub_speed" in scenario.keys(), scenario.plot or scenario.plots  # noqa: SIM118
    where, rows = "FOLDER|FILE.pdf" if scenario.plots else "FILE", "write the time series, one row a sample"
    options: tuple[tuple[str, Any, str, str, Any], ...] = (
        (
            "set",
            True,
            "KEY=VALUE",
            "override a parameter, in SI units or with a unit (27mm); the last of a key counts",
            [],
        ),
        ("parameters", has_tool, "FILE.toml", "read the tool from a file; --set overrides it", str),
        ("json", True, "FILE", "write the results as JSON; - for standard output", str),
        ("csv", scenario.series or sweeping, "FILE.csv", f"{rows}; - for standard output", str),
        ("plot", pictures or sweeping, where, "draw a figure (png, svg, pdf)", str),
        ("video", scenario.film, "FILE", "render a video (mp4, gif)", str),
        ("size", scenario.film, "WIDTHxHEIGHT", "of the video, in px", _size),
        ("fps", scenario.film, "NUMBER", "pictures a second of the video", float),
        ("report", True, "FILE.html", "write a page with question, answer, figures and parameters", str),
        ("write_tool", has_tool, "FILE.toml", "write the tool that was run, or found", str),
        ("workers", True, "N", "processes of a sweep; -1: one a core", int),
        ("store", True, "FOLDER", "keep finished points of a sweep, and go on from them", str),
        ("sweep", True, "KEY=FROM:TO:N", SWEEP_HELP, []),
    )
    for name, offered, metavar, words, kind in options:
        if offered:
            how: dict[str, Any] = {"type": kind} if callable(kind) else {"action": "append", "default": kind}
            parser.add_argument(_flag(name), metavar=metavar, help=words, **how)
        else:
            parser.set_defaults(**{name: None})
    parser.add_argument("--list-keys", action="store_true", help="list every key and stop")
    for key in scenario.options:
        setting: dict[str, Any] = {"dest": "set", "action": "append", "type": f"{key}={{}}".format}
        parser.add_argument(f"--{key}", metavar="VALUE", help=f"--set {key}=VALUE", **setting)
    return parser


SWEEP_HELP = (
    "the quantities over one key, or two by two options, in N steps; with --csv, --json and --plot of the table"
)


def _size(text: str) -> dict[str, int]:
    """Return width and height of a picture."""
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"{text!r}: must be WIDTHxHEIGHT, such as 1280x720 (in px)")
    return {"width": int(found[1]), "height": int(found[2])}
