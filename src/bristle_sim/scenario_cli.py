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
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

from bristle_sim.comparison import Report, finite, table
from bristle_sim.files import complete_or_absent
from bristle_sim.quantity import Choice, Range

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["Scenario", "build", "main"]

Values = Mapping[str, Any]
T = TypeVar("T", bound="DataclassInstance")

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
        plot_is_folder: ``--plot`` names a folder, or a PDF of several pages, instead of a picture.
        options: keys that also have an option of their own; ``--KEY VALUE`` is short for ``--set KEY=VALUE``.
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
    options: tuple[str, ...] = ()

    def keys(self) -> dict[str, tuple[Range | Choice, Any]]:
        """Every key with its declaration and default."""
        found: dict[str, tuple[Range | Choice, Any]] = {}
        for part in self.parts:
            for each in dataclasses.fields(part):
                declared = each.metadata.get("declaration")
                if declared is not None and declared.key not in self.without:
                    found[declared.key] = (declared, self.defaults.get(declared.key, each.default))
        return found


def build(part: type[T], values: Values) -> T:
    """A parameter object of the given class from key values."""
    arguments = {}
    for each in dataclasses.fields(part):
        declared = each.metadata.get("declaration")
        if declared is not None and declared.key in values:
            arguments[each.name] = values[declared.key]
    return part(**arguments)


def main(scenario: Scenario, arguments: Sequence[str] | None = None) -> int:
    """Run a scenario from the command line and return its exit status: 0, 1 (a tolerance missed) or 2 (bad input)."""
    parser = _parser(scenario)
    try:
        return _answer(scenario, parser.parse_args(arguments))
    except (ValueError, OSError) as error:
        line = " ".join(str(error).split())
        print(f"{parser.prog}: error: {line}", file=sys.stderr)
        return 2


def _answer(scenario: Scenario, options: argparse.Namespace) -> int:
    if options.list_keys:
        _say(_key_list(scenario))
        return 0
    values = _values(scenario, options.set)
    several_pages = (options.plot or "").lower().endswith(".pdf")
    plot = _target("--plot", options.plot, PICTURES, folder=scenario.plot_is_folder and not several_pages)
    video = _target("--video", options.video, VIDEOS)
    json_file = None if options.json in (None, "-") else _target("--json", options.json)
    report = _run(scenario, values, options.set)
    _draw(scenario, report, plot, video)
    document = json.dumps(_plain(_document(scenario, values, report)), indent=1, allow_nan=False)
    if json_file is not None:
        with complete_or_absent(json_file) as partial:
            partial.write_text(document + "\n", encoding="utf-8")
    _say(document if options.json == "-" else _words(report))
    return 1 if any(row.ok is False for row in report.quantities) else 0


def _run(scenario: Scenario, values: Values, settings: Sequence[str]) -> Report:
    try:
        return scenario.run(values)
    except ArithmeticError as error:
        if not settings:
            raise
        raise ValueError(f"{', '.join(settings)}: less extreme values are allowed ({error})") from error


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Leave it to ``main`` to say so in one line."""
        raise ValueError(message)


def _parser(scenario: Scenario) -> _Parser:
    parser = _Parser(prog=f"{scenario.name}.py", description=scenario.question, allow_abbrev=False)
    parser.add_argument(
        "--set", metavar="KEY=VALUE", action="append", default=[], help="override a parameter; the last of a key counts"
    )
    parser.add_argument("--json", metavar="FILE", help="write the results as JSON; - for standard output")
    if scenario.plot is not None:
        what = "FOLDER|FILE.pdf" if scenario.plot_is_folder else "FILE"
        parser.add_argument("--plot", metavar=what, help="draw a figure (png, svg, pdf)")
    else:
        parser.set_defaults(plot=None)
    if scenario.video is not None:
        parser.add_argument("--video", metavar="FILE", help="render a video (mp4, gif)")
    else:
        parser.set_defaults(video=None)
    parser.add_argument("--list-keys", action="store_true", help="list every key and stop")
    for key in scenario.options:
        parser.add_argument(
            f"--{key}",
            dest="set",
            metavar="VALUE",
            action="append",
            type=f"{key}={{}}".format,
            help=f"--set {key}=VALUE",
        )
    return parser


def _values(scenario: Scenario, settings: Sequence[str]) -> dict[str, Any]:
    keys = scenario.keys()
    values = {key: default for key, (_, default) in keys.items()}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise ValueError(f"--set {setting!r}: KEY=VALUE is allowed")
        if key not in keys:
            raise ValueError(f"--set {setting!r}: unknown key {key!r}; allowed are {', '.join(keys)}")
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


def _target(
    option: str, name: str | None, suffixes: tuple[str, ...] | None = None, *, folder: bool = False
) -> Path | None:
    """The file (or folder) an option names, checked before anything is computed; no suffixes allow any."""
    if name is None:
        return None
    path = Path(name)
    if suffixes is not None and not folder and path.suffix.lower() not in suffixes:
        raise ValueError(f"{option} = {name!r}: a file name that ends in {', '.join(suffixes)} is allowed")
    if path.is_dir() != folder and path.exists():
        raise ValueError(f"{option} = {name!r}: {'a folder' if folder else 'a file, not a folder,'} is allowed")
    parent = path if folder and path.is_dir() else path.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise ValueError(f"{option} = {name!r}: a path in an existing, writable folder is allowed")
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


def _plain(value: Any) -> Any:
    """The same in JSON's own types; a number that is not finite becomes null."""
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "tolist"):  # NumPy's scalars and arrays
        return _plain(value.tolist())
    return finite(value) if isinstance(value, float) else value


def _words(report: Report) -> str:
    phases = f" ({', '.join(report.phases)})" if report.phases else ""
    return "\n".join([table(report.quantities), "", f"outcome: {report.outcome}{phases}", *report.remarks])


def _say(text: str) -> None:
    """Print on standard output, where a reader that has seen enough, such as ``head``, is no error."""
    try:
        print(text, flush=True)
    except OSError as error:
        # Python flushes once more at exit: what is left must have somewhere to go.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise OSError(f"standard output: {error.strerror}") from None


def _draw(scenario: Scenario, report: Report, plot: Path | None, video: Path | None) -> None:
    for name, draw, path in (("--plot", scenario.plot, plot), ("--video", scenario.video, video)):
        if draw is not None and path is not None:
            draw(report, path)
            print(f"{name}: wrote {path}", file=sys.stderr)
