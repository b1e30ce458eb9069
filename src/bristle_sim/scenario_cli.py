"""The command line that every scenario script shares: keys, table, JSON, picture, video and exit status."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from bristle_sim.comparison import Report, table
from bristle_sim.quantity import Choice, Quantity

__all__ = ["Scenario", "build", "main"]

Values = Mapping[str, Any]
T = TypeVar("T")

PICTURES = (".png", ".svg", ".pdf")
VIDEOS = (".mp4", ".gif")


@dataclass(frozen=True, slots=True)
class Scenario:
    """One question, asked from the command line.

    Attributes:
        name: of the script, without suffix.
        question: what it asks and compares.
        parts: parameter classes whose declared fields are the script's keys.
        run: answers the question for given key values; may raise ValueError for values that do not fit together.
        plot, video: draw a report to a path; they import what they need themselves.
        defaults: key values that differ from the parameter classes' own.
        without: keys of the parts that mean nothing to the question.
        plot_is_folder: ``--plot`` names a folder instead of a picture.
    """

    name: str
    question: str
    parts: tuple[type, ...]
    run: Callable[[Values], Report]
    plot: Callable[[Report, Path], None] | None = None
    video: Callable[[Report, Path], None] | None = None
    defaults: Mapping[str, Any] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    plot_is_folder: bool = False

    def keys(self) -> dict[str, tuple[Quantity | Choice, Any]]:
        """Every key with its declaration and default."""
        found: dict[str, tuple[Quantity | Choice, Any]] = {}
        for part in self.parts:
            for each in dataclasses.fields(part):
                declared = each.metadata.get("declaration")
                if declared is not None and declared.key not in self.without:
                    found[declared.key] = (declared, self.defaults.get(declared.key, each.default))
        return found


def build(part: type[T], values: Values) -> T:
    """A parameter object of the given class from key values."""
    arguments = {}
    for each in dataclasses.fields(part):  # type: ignore[arg-type]
        declared = each.metadata.get("declaration")
        if declared is not None and declared.key in values:
            arguments[each.name] = values[declared.key]
    return part(**arguments)


def main(scenario: Scenario, arguments: Sequence[str] | None = None) -> int:
    """Run a scenario from the command line and return its exit status: 0, 1 (a tolerance missed) or 2 (bad input)."""
    parser = _parser(scenario)
    options = parser.parse_args(arguments)
    if options.list_keys:
        print(_key_list(scenario))
        return 0
    try:
        values = _values(scenario, options.set)
        plot = _target("--plot", options.plot, PICTURES, folder=scenario.plot_is_folder)
        video = _target("--video", options.video, VIDEOS)
        json_file = None if options.json in (None, "-") else _target("--json", options.json, (".json",))
        report = scenario.run(values)
    except ValueError as error:
        parser.error(str(error))
    if options.json is not None:
        text = json.dumps(_document(scenario, values, report), indent=1, allow_nan=False)
        if json_file is None:
            print(text)
        else:
            _write(json_file, text + "\n")
    if options.json != "-":
        _print_report(report)
    try:
        _draw(scenario, report, plot, video)
    except (ValueError, OSError) as error:
        parser.error(str(error))
    return 1 if any(row.ok is False for row in report.quantities) else 0


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Bad input is one line on standard error and exit status 2."""
        line = " ".join(message.split())
        print(f"{self.prog}: error: {line}", file=sys.stderr)
        raise SystemExit(2)


def _parser(scenario: Scenario) -> _Parser:
    parser = _Parser(prog=f"{scenario.name}.py", description=scenario.question, allow_abbrev=False)
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], help="override a parameter")
    parser.add_argument("--json", metavar="FILE", help="write the results as JSON; - for standard output")
    if scenario.plot is not None:
        what = "FOLDER" if scenario.plot_is_folder else "FILE"
        parser.add_argument("--plot", metavar=what, help="draw a figure (png, svg, pdf)")
    else:
        parser.set_defaults(plot=None)
    if scenario.video is not None:
        parser.add_argument("--video", metavar="FILE", help="render a video (mp4, gif)")
    else:
        parser.set_defaults(video=None)
    parser.add_argument("--list-keys", action="store_true", help="list every key and stop")
    return parser


def _values(scenario: Scenario, settings: Sequence[str]) -> dict[str, Any]:
    keys = scenario.keys()
    values = {key: default for key, (_, default) in keys.items()}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise ValueError(f"--set {setting}: KEY=VALUE is allowed")
        if key not in keys:
            raise ValueError(f"--set {setting}: unknown key {key!r}; allowed are {', '.join(keys)}")
        values[key] = keys[key][0].parse(text)
    return values


def _key_list(scenario: Scenario) -> str:
    lines = []
    for key, (declared, default) in scenario.keys().items():
        shown = "none" if default is None else default if isinstance(default, str) else f"{default:.9g}"
        lines.append((key, declared.unit, shown, declared.allowed, declared.source))
    lines.insert(0, ("key", "unit", "default", "allowed", "source"))
    widths = [max(len(line[column]) for line in lines) for column in range(4)]
    return "\n".join(
        "  ".join([*(cell.ljust(width) for cell, width in zip(line, widths, strict=False)), line[4]]) for line in lines
    )


def _target(option: str, name: str | None, suffixes: tuple[str, ...], *, folder: bool = False) -> Path | None:
    """The file (or folder) an option names, checked before anything is computed."""
    if name is None:
        return None
    path = Path(name)
    if not folder and path.suffix.lower() not in suffixes:
        raise ValueError(f"{option} = {name}: a file name that ends in {', '.join(suffixes)} is allowed")
    if path.is_dir() != folder and path.exists():
        raise ValueError(f"{option} = {name}: {'a folder' if folder else 'a file, not a folder,'} is allowed")
    parent = path if folder and path.is_dir() else path.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise ValueError(f"{option} = {name}: a path in an existing, writable folder is allowed")
    return path


def _document(scenario: Scenario, values: Values, report: Report) -> dict[str, Any]:
    return {
        "scenario": scenario.name,
        "parameters": dict(values),
        "outcome": report.outcome,
        "quantities": [row.as_dict() for row in report.quantities],
        "phases": list(report.phases),
        "events": [{"name": name, "time": time} for name, time in report.events if math.isfinite(time)],
        "cost": {"wall_s": report.wall_s, "steps": report.steps},
        **report.extra,
    }


def _print_report(report: Report) -> None:
    print(table(report.quantities))
    print(f"\noutcome: {report.outcome}" + (f" ({', '.join(report.phases)})" if report.phases else ""))
    for remark in report.remarks:
        print(remark)


def _write(path: Path, text: str) -> None:
    partial = path.with_name(path.name + ".part")
    try:
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _draw(scenario: Scenario, report: Report, plot: Path | None, video: Path | None) -> None:
    for name, draw, path in (("--plot", scenario.plot, plot), ("--video", scenario.video, video)):
        if draw is not None and path is not None:
            draw(report, path)
            print(f"{name}: wrote {path}", file=sys.stderr)
