"""Run a scenario from the command line: options, order of work, table, JSON and CSV, interruption, exit status."""

from __future__ import annotations

import argparse
import csv
import json
import logging
import math
import os
import shlex
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from bristle_sim import __version__
from bristle_sim.cli.ending import ending_in_order
from bristle_sim.cli.scenario import Columns, Scenario, Values, warnings_of
from bristle_sim.comparison import WIDTH, Report, Unfinished, finite, table
from bristle_sim.files import checked_target, complete_or_absent, is_special
from bristle_sim.parameters import PARTS

PICTURES = (".png", ".svg", ".pdf")
VIDEOS = (".mp4", ".gif")

MISSED, BAD_INPUT, INTERRUPTED = 1, 2, 130  # exit statuses; the last is a shell's after SIGINT


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
                say(scenario.key_list())
                return 0
            if options.parameters is not None:
                from_file, warnings = scenario.assignments_from(options.parameters)
                options.set = [*from_file, *options.set]
            values = scenario.values_of(options.set)
            warnings += warnings_of(scenario, options.set, values)
            status = _answer(scenario, options, values, command)
        except (ValueError, OSError) as error:
            line = "; ".join([" ".join(str(error).split()), *warnings])
            tell(f"{program}: error: {line}")
            return BAD_INPUT
        except KeyboardInterrupt:
            status = INTERRUPTED
    for line in warnings:
        tell(f"{program}: warning: {line}")
    if status == INTERRUPTED:
        tell(f"{program}: interrupted")
    return status


def _answer(scenario: Scenario, options: argparse.Namespace, values: Values, command: str) -> int:
    targets = _targets(scenario, options, values)
    try:
        report, status = _run(scenario, values, options.set), 0
    except Unfinished as interruption:
        report, status = interruption.report, INTERRUPTED
    if not status:
        _draw(scenario, report, targets)
        if (page := targets["report"]) is not None:
            from bristle_sim.render.report import write_report

            shown = {name: getattr(scenario, name) for name in ("name", "question", "plot", "plot_is_folder")}
            parameters = [(declared, values[key], default) for key, (declared, default) in scenario.keys().items()]
            write_report(page, report, command=command, parameters=parameters, video=targets["video"], **shown)
            tell(f"--report: wrote {page}")
    text = document(scenario, values, report, finished=not status)
    if (target := targets["json"]) is not None:
        with complete_or_absent(target) as partial:
            partial.write_text(text + "\n", encoding="utf-8")
    say(text if options.json == "-" else in_words(report))
    return status or (MISSED if any(row.ok is False for row in report.quantities) else 0)


def _targets(scenario: Scenario, options: argparse.Namespace, values: Values) -> dict[str, Path | None]:
    """Return the files that the options name, once it is sure that each can be written and none is named twice.

    A device such as /dev/null may serve several options.
    """
    folder = scenario.plot_is_folder and not (options.plot or "").lower().endswith(".pdf")
    kinds = {"plot": PICTURES, "video": VIDEOS, "csv": (), "report": (".html",), "json": ()}
    found: dict[str, Path | None] = {}
    for name, suffixes in kinds.items():
        path = getattr(options, name)
        named = path is not None and (name, path) != ("json", "-")
        whole = name == "plot" and folder
        found[name] = checked_target(path, suffixes, option=f"--{name}", folder=whole) if named else None
    inputs = [(key, values[key]) for key, (declared, _) in scenario.keys().items() if declared.unit == "file"]
    seen: dict[str, str] = {}
    outputs = [(f"--{name}", path) for name, path in found.items()]
    for option, path in [("--parameters", options.parameters), *inputs, *outputs]:
        if path is None or is_special(Path(path)):
            continue
        place = os.path.realpath(path)
        if place in seen:
            raise ValueError(f"{option} = {str(path)!r}: must be another file than that of {seen[place]}")
        seen[place] = option
    return found


def _run(scenario: Scenario, values: Values, assignments: Sequence[str]) -> Report:
    try:
        return scenario.run(values)
    except ArithmeticError as error:
        if not assignments:
            raise
        raise ValueError(f"{', '.join(assignments)}: must be less extreme ({error})") from error


def _draw(scenario: Scenario, report: Report, targets: dict[str, Path | None]) -> None:
    """Write picture, video and time series; the series is computed first, since it may be refused."""
    target = targets["csv"]
    columns = scenario.series(report) if scenario.series is not None and target is not None else {}
    for option, draw in (("plot", scenario.plot), ("video", scenario.video)):
        path = targets[option]
        if draw is not None and path is not None:
            draw(report, path)
            tell(f"--{option}: wrote {path}")
    if target is not None:
        write_csv(target, columns)
        tell(f"--csv: wrote {target}")


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
        (
            "parameters",
            any(kinds[0] in scenario.parts for kinds in PARTS.values()),
            "FILE.toml",
            "read the tool from a file; --set overrides it",
        ),
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


def document(scenario: Scenario, values: Values, report: Report, *, finished: bool = True) -> str:
    """Return the results as JSON, in SI units at full precision; it says so if the work was interrupted."""
    found = {
        "scenario": scenario.name,
        "version": __version__,
        "parameters": dict(values),
        "outcome": report.outcome,
        "quantities": [row.as_dict() for row in report.quantities],
        "phases": list(report.phases),
        "events": [{"name": name, "time": time} for name, time in report.events if math.isfinite(time)],
        "cost": {"wall_s": report.wall_s, "steps": report.steps},
        **report.extra,
        **({} if finished else {"finished": False}),
    }
    return json.dumps(_plain(found), indent=1, allow_nan=False)


def _plain(value: Any) -> Any:
    """Turn values into JSON's own types; a number that is not finite becomes null."""
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "tolist"):  # NumPy's scalars and arrays
        return _plain(value.tolist())
    return finite(value) if isinstance(value, float) else value


def write_csv(path: Path, columns: Columns) -> None:
    """Write a time series at full precision: names and units in the first row, then one row a sample."""
    plain = [_plain(list(column)) for column in columns.values()]
    with complete_or_absent(path) as partial, partial.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*plain, strict=True))


def in_words(report: Report) -> str:
    """Return the table, the outcome where the question is about an impact, and the remarks."""
    lines = [table(report.quantities)]
    if report.outcome is not None:
        phases = f" ({', '.join(report.phases)})" if report.phases else ""
        lines += ["", *_wrapped(f"outcome: {report.outcome}{phases}")]
    elif report.remarks and report.remarks[0]:
        lines.append("")
    for remark in report.remarks:
        lines += _wrapped(remark)
    return "\n".join(lines)


def _wrapped(remark: str) -> list[str]:
    """Wrap a remark into lines that fit; one that is in columns or lines already stays as it is."""
    if len(remark) <= WIDTH or "\n" in remark or "  " in remark.strip():
        return [remark]
    return textwrap.wrap(remark, WIDTH, subsequent_indent="  ")


def say(text: str) -> None:
    """Print on standard output, where a reader that has seen enough, such as ``head``, is no error."""
    try:
        print(text, flush=True)
    except OSError as error:
        # Python flushes once more at exit: what is left must have somewhere to go.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise OSError(f"standard output: {error.strerror}") from None


def tell(text: str) -> None:
    """Print on standard error if there is one; print() would take standard output in its place."""
    if sys.stderr is not None:
        print(text, file=sys.stderr, flush=True)
