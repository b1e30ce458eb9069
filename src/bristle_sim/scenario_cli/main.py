"""Run a scenario from the command line: options, order of work, interruption, exit status."""

from __future__ import annotations

import argparse
import logging
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from bristle_sim.comparison import Report, Unfinished
from bristle_sim.files import checked_target
from bristle_sim.scenario_cli import output
from bristle_sim.scenario_cli.ending import ending_in_order
from bristle_sim.scenario_cli.keys import key_list, settings_from, takes_tool, values_of, warnings_of
from bristle_sim.scenario_cli.scenario import Scenario, Values

PICTURES = (".png", ".svg", ".pdf")
VIDEOS = (".mp4", ".gif")

MISSED, BAD_INPUT, INTERRUPTED = 1, 2, 130
"""Exit statuses; the last is that of a shell whose command was ended by SIGINT."""


def main(scenario: Scenario, arguments: Sequence[str] | None = None, *, program: str = "") -> int:
    """Run a scenario and return its exit status: 0, 1 (a tolerance missed), 2 (bad input) or 130 (interrupted).

    ``program`` is the name of the command in messages; by default the script's.
    """
    arguments, warnings = sys.argv[1:] if arguments is None else arguments, list[str]()
    command = shlex.join([*(program or f"python scenarios/{scenario.name}.py").split(), *arguments])
    program = program or f"{scenario.name}.py"
    with ending_in_order(), _progress_on_a_terminal(program):
        try:
            if sys.stdout is None:
                raise OSError("standard output: must be open")
            options = _parser(scenario, program).parse_args(arguments)
            if options.list_keys:
                output.say(key_list(scenario))
                return 0
            if options.parameters is not None:
                from_file, warnings = settings_from(scenario, options.parameters)
                options.set = [*from_file, *options.set]
            values = values_of(scenario, options.set)
            warnings += warnings_of(scenario, options.set, values)
            status = _answer(scenario, options, values, command)
        except (ValueError, OSError) as error:
            line = "; ".join([" ".join(str(error).split()), *warnings])
            output.tell(f"{program}: error: {line}")
            return BAD_INPUT
        except KeyboardInterrupt:
            status = INTERRUPTED
    for line in warnings:
        output.tell(f"{program}: warning: {line}")
    if status == INTERRUPTED:
        output.tell(f"{program}: interrupted")
    return status


def _answer(scenario: Scenario, options: argparse.Namespace, values: Values, command: str) -> int:
    pages = (options.plot or "").lower().endswith(".pdf")
    targets = {
        "--plot": _target(options, "plot", PICTURES, folder=scenario.plot_is_folder and not pages),
        "--video": _target(options, "video", VIDEOS),
        "--csv": _target(options, "csv"),
        "--report": _target(options, "report", (".html",)),
        "--json": None if options.json == "-" else _target(options, "json"),
    }
    inputs = [(key, values[key]) for key, (declared, _) in scenario.keys().items() if declared.unit == "file"]
    output.require_different([("--parameters", options.parameters), *inputs, *targets.items()])
    try:
        report, status = _run(scenario, values, options.set), 0
    except Unfinished as interruption:
        report, status = interruption.report, INTERRUPTED
    if not status:
        _draw(scenario, report, targets)
        if (page := targets["--report"]) is not None:
            from bristle_sim.render.report import write_report

            shown = {name: getattr(scenario, name) for name in ("name", "question", "plot", "plot_is_folder")}
            parameters = [(declared, values[key], default) for key, (declared, default) in scenario.keys().items()]
            write_report(page, report, command=command, parameters=parameters, video=targets["--video"], **shown)
            output.tell(f"--report: wrote {page}")
    text = output.document(scenario, values, report, finished=not status)
    if targets["--json"] is not None:
        output.write_json(targets["--json"], text)
    output.say(text if options.json == "-" else output.in_words(report))
    return status or (MISSED if any(row.ok is False for row in report.quantities) else 0)


def _target(
    options: argparse.Namespace, name: str, suffixes: Sequence[str] = (), *, folder: bool = False
) -> Path | None:
    path = getattr(options, name)
    return None if path is None else checked_target(path, suffixes, option=f"--{name}", folder=folder)


def _run(scenario: Scenario, values: Values, settings: Sequence[str]) -> Report:
    try:
        return scenario.run(values)
    except ArithmeticError as error:
        if not settings:
            raise
        raise ValueError(f"{', '.join(settings)}: must be less extreme ({error})") from error


def _draw(scenario: Scenario, report: Report, targets: dict[str, Path | None]) -> None:
    """Write picture, video and time series; the series is computed first, since it may be refused."""
    table = targets["--csv"]
    columns = scenario.series(report) if scenario.series is not None and table is not None else {}
    for option, draw in (("--plot", scenario.plot), ("--video", scenario.video)):
        path = targets[option]
        if draw is not None and path is not None:
            draw(report, path)
            output.tell(f"{option}: wrote {path}")
    if table is not None:
        output.write_csv(table, columns)
        output.tell(f"--csv: wrote {table}")


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Raise, so that ``main`` reports it in one line."""
        unknown = message.removeprefix("unrecognized arguments: ")
        if unknown != message:
            setting = "=" in unknown and not unknown.startswith("-")
            advice = f"did you mean --set {unknown}?" if setting else f"{self.prog} --help lists the options"
            raise ValueError(f"{message}; {advice}")
        raise ValueError(message)


def _parser(scenario: Scenario, program: str) -> _Parser:
    """Return a parser of the options that the scenario has; those it has not are as if left out."""
    parser = _Parser(prog=program, description=scenario.question, allow_abbrev=False)
    words = "override a parameter, in SI units or with a unit (27mm); the last of a key counts"
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help=words)
    where = "FOLDER|FILE.pdf" if scenario.plot_is_folder else "FILE"
    for name, offered, what, words in (
        ("parameters", takes_tool(scenario), "FILE.toml", "read the tool from a file; --set overrides it"),
        ("json", True, "FILE", "write the results as JSON; - for standard output"),
        ("csv", scenario.series, "FILE", "write the time series, one row a sample"),
        ("plot", scenario.plot, where, "draw a figure (png, svg, pdf)"),
        ("video", scenario.video, "FILE", "render a video (mp4, gif)"),
        ("report", True, "FILE.html", "write a page with question, answer, figures and parameters"),
    ):
        if offered:
            parser.add_argument(f"--{name}", metavar=what, help=words)
        else:
            parser.set_defaults(**{name: None})
    parser.add_argument("--list-keys", action="store_true", help="list every key and stop")
    for key in scenario.options:
        setting: dict[str, Any] = {"dest": "set", "action": "append", "type": f"{key}={{}}".format}
        parser.add_argument(f"--{key}", metavar="VALUE", help=f"--set {key}=VALUE", **setting)
    return parser


@contextmanager
def _progress_on_a_terminal(program: str) -> Iterator[None]:
    """Show what the package logs of its progress in one line of standard error, if that is a terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield
        return
    log, shown = logging.getLogger("bristle_sim"), logging.StreamHandler(sys.stderr)
    shown.terminator = ""
    shown.setFormatter(logging.Formatter(f"\r\x1b[K{program}: %(message)s"))
    level = log.level
    log.addHandler(shown)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(shown)
        log.setLevel(level)
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)
