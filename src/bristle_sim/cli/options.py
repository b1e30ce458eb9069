"""The command-line options of scenarios and commands, and the checks of the files they name."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from bristle_sim.cli.output import print_error, print_line, write_text
from bristle_sim.cli.scenario import Scenario, Values
from bristle_sim.declared import Range
from bristle_sim.files import checked_target, is_special

SUFFIXES = {
    "json": (), "csv": (".csv",), "plot": (".png", ".svg", ".pdf"), "video": (".mp4", ".gif"), "write-tool": (".toml",),
    "report": (".html",),
}  # fmt: skip
"""Permitted suffixes of the output file, by option; an empty tuple permits any suffix."""

NEEDED = {
    "fps": "video", "interval": "csv", "quantity": "sweep", "size": "video", "store": "sweep", "workers": "sweep",
}  # fmt: skip
"""Options that have an effect only together with another option, and the name of the latter."""

ON_STANDARD_OUTPUT = ("json", "csv")  # options for which the value - means standard output


Content = str | Callable[[Path], object]
"""Content of a file: its text, or a function that writes the file."""


def deliver(
    options: argparse.Namespace,
    targets: Mapping[str, Path],
    contents: Mapping[str, Content],
    answer: str,
) -> None:
    """Write the requested output files in the order of ``contents``, and print the answer.

    A text whose option is ``-`` is printed instead of the answer. An option without a file is
    skipped. Standard error lists the files except the JSON file.

    Args:
        options: the parsed options.
        targets: the files by option.
        contents: the contents by option.
        answer: text of the answer.

    Raises:
        OSError: if a file cannot be written; the message names option and file.
    """
    for option, made in contents.items():
        target = targets.get(option)
        if target is None:
            if isinstance(made, str) and getattr(options, option) == "-":
                answer = made
            continue
        try:
            if isinstance(made, str):
                write_text(target, made)
            else:
                made(target)
        except OSError as error:
            raise OSError(f"--{option} = {str(target)!r}: {error.strerror or error}") from error
        if option != "json":
            print_error(f"--{option}: wrote {target}")
    print_line(answer)


def targets_of(options: argparse.Namespace, scenario: Scenario, values: Values) -> dict[str, Path]:
    """Check the output files that the options name, and return them by option.

    Each file must be writable, and no file may be named twice, except a device such as /dev/null.

    Args:
        options: the parsed options. An option that was not given is absent or None.
        scenario: the scenario that is run.
        values: values of the scenario's parameters, by key.

    Raises:
        ValueError: for a file that cannot be written or has a wrong suffix, or for options that
            contradict each other. The message has one line.
        OSError: if standard output is closed.
    """
    if sys.stdout is None:
        raise OSError("standard output: must be open")
    given = {name: value for name, value in vars(options).items() if value not in (None, [])}
    for name, other in NEEDED.items():
        if name in given and other not in given:
            raise ValueError(f"--{name}: must be given with --{other}")
    for name in ("interval", "report", "video", "write-tool"):
        if {name, "sweep"} <= given.keys():
            raise ValueError(f"--{name}: must be left out with --sweep")
    if given.get("json") == given.get("csv") == "-":
        raise ValueError("--csv = '-': must be a file where --json is on standard output")
    named = {"--parameters": given.get("parameters")}
    files = [key for key, declared in scenario.keys().items() if declared.unit == "file"]
    named |= {key: values[key] for key in files}
    found = {
        name: _checked(name, given[name], scenario)
        for name in SUFFIXES
        if name in given and not (given[name] == "-" and name in ON_STANDARD_OUTPUT)
    }
    seen = dict[str, str]()
    for option, path in [*named.items(), *((f"--{name}", path) for name, path in found.items())]:
        if path is not None and not is_special(Path(path)):
            place = os.path.realpath(path)
            if place in seen:
                raise ValueError(
                    f"{option} = {str(path)!r}: must differ from the file of {seen[place]}"
                )
            seen[place] = option
    return found


def _checked(name: str, path: str, scenario: Scenario) -> Path:
    """Check that an option's file can be written, and return its path.

    Args:
        name: name of the option.
        path: typed path.
        scenario: the scenario that is run. ``--csv`` also accepts the suffixes of the scenario's
            own formats. ``--plot`` needs a folder or a PDF if the scenario draws several figures.
    """
    suffixes = SUFFIXES[name]
    suffix = Path(path).suffix.lower()
    folder = scenario.plots is not None and name == "plot" and suffix != ".pdf"
    if folder and suffix in suffixes:
        raise ValueError(f"--plot = {path!r}: must be a folder, or a file name that ends in .pdf")
    if name == "csv":
        suffixes = () if is_special(Path(path)) else (*suffixes, *scenario.formats)
    return checked_target(path, suffixes, option=f"--{name}", folder=folder)


class Parser(argparse.ArgumentParser):
    """Command-line parser that raises ValueError for bad input, with a message of one line."""

    def __init__(self, program: str, description: str) -> None:
        super().__init__(prog=program, description=description, allow_abbrev=False)
        # A number with a unit, such as -1us, is a value and not an option.
        self._negative_number_matcher = re.compile(r"-[.\d]")

    def error(self, message: str) -> NoReturn:
        """Raise ValueError with the message, and with advice on an unknown option."""
        unknown = message.removeprefix("unrecognized arguments: ")
        if unknown == message:  # a refused value, whose message begins with option and value
            raise ValueError(re.sub(r"^argument (--\S+): (?=\1 = )", "", message))
        setting = "=" in unknown and not unknown.startswith("-")
        advice = (
            f"did you mean --set {unknown}?" if setting else f"{self.prog} --help lists the options"
        )
        raise ValueError(f"{message}; {advice}")


def value_of(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """Return a function that does what ``read`` does, but raises argparse's error for a bad value.

    ``read`` reads the value of an option from a text. For a bad value it raises ValueError, with a
    message that begins with the option's name without dashes.
    """

    def reading(text: str) -> Any:
        """Return the value, or raise the exception whose message argparse prints."""
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"--{error}") from error

    return reading


def _size(text: str) -> dict[str, int]:
    """Return ``width`` and ``height`` (px) of a picture from a text such as 1280x720."""
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if found is None:
        raise ValueError(f"size = {text!r}: must be WIDTHxHEIGHT, such as 1280x720 (in px)")
    width = int(found[1])
    height = int(found[2])
    if not (64 <= width <= 8192 and 48 <= height <= 8192):
        raise ValueError(f"size = {text!r}: must be 64 to 8192 wide and 48 to 8192 high (in px)")
    return {"width": width, "height": height}


def _workers(text: str) -> int:
    """Return a number of processes, or -1 for one process on each core."""
    if (
        not re.fullmatch(r"-1|\d{1,4}", text)
        or not -1 <= int(text) <= MOST_WORKERS
        or not int(text)
    ):
        rule = (
            f"must be a whole number from 1 to {MOST_WORKERS}, or -1 for one process on each core"
        )
        raise ValueError(f"workers = {text!r}: {rule}")
    return int(text)


def _positive(key: str, unit: str, most: float) -> Callable[[str], float]:
    """Return the function that reads a number above 0 and up to ``most``, with or without a unit.

    ``key`` is the name of the option, and ``unit`` that of a number without a unit.
    """
    return value_of(Range(key, unit, 0.0, most, lowest_allowed=False).parse)


MOST_WORKERS = 1024  # Largest number of processes: more than a computer has cores

APPENDED: dict[str, Any] = {"action": "append", "default": []}

OPTIONS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "set": ("KEY=VALUE", "set a key, in SI units or with a unit (27mm); the last value of a key counts", APPENDED),
    "parameters": ("FILE.toml", "read the tool from a file; --set overrides it", {}),
    "json": ("FILE", "write the results as JSON; - for standard output", {}),
    "csv": ("FILE.csv", "write the time series, one row a sample; - for standard output", {}),
    "interval": ("TIME", "evenly spaced rows of the CSV, such as 10us, in place of the samples", {"type": _positive("interval", "s", 1.0)}),
    "plot": ("FILE", "draw the figure (PNG, SVG, PDF); for several figures a folder or a PDF", {}),
    "video": ("FILE", "render a video (MP4, GIF)", {}),
    "size": ("WIDTHxHEIGHT", "size of the video, in px", {"type": value_of(_size)}),
    "fps": ("NUMBER", "frames per second of the video", {"type": _positive("fps", "1/s", 1e6)}),
    "report": ("FILE.html", "write a page with question, answer, figures and parameters", {}),
    "write-tool": ("FILE.toml", "write the tool that was run, or that the scenario found", {}),
    "workers": ("N", "number of processes of a sweep; -1: one for each core", {"type": value_of(_workers)}),
    "store": ("FOLDER", "keep finished points of a sweep, and continue from them", {}),
    "quantity": ("NAME", "a quantity that a sweep shows, in place of all that change; repeatable", APPENDED),
    "sweep": ("KEY=FROM:TO:N", "run N equally spaced values of a key; twice for two keys; --csv, --json and --plot then"
              " show all points", APPENDED),
}  # fmt: skip
"""Placeholder of the value, help text, and further settings of argparse, for each option."""


def add_options(parser: argparse.ArgumentParser, *names: str) -> None:
    """Add the options with the given names, which :data:`OPTIONS` describes, to a parser."""
    for name in names:
        metavar, words, how = OPTIONS[name]
        parser.add_argument(f"--{name}", dest=name, metavar=metavar, help=words, **how)


def parser_of(
    scenario: Scenario, program: str, *, sweeping: bool = False
) -> argparse.ArgumentParser:
    """Return the command-line parser of a scenario.

    An option that has no effect on the scenario is left out of the parser, and has the value None.
    ``sweeping`` states whether the command line requests a sweep.
    """
    parser = Parser(program, scenario.question)
    left_out = {*scenario.options}
    if "hub_speed" not in scenario.keys():  # noqa: SIM118
        left_out |= {"parameters", "write-tool"}
    if scenario.film is None:
        left_out |= {"video", "size", "fps"}
    if scenario.series is None and not sweeping:
        left_out |= {"csv", "interval"}
    if not (scenario.plot or scenario.plots or sweeping):
        left_out.add("plot")
    parser.set_defaults(**dict.fromkeys(left_out))
    add_options(parser, *(name for name in OPTIONS if name not in left_out))
    parser.add_argument("--list-keys", action="store_true", help="list every key and stop")
    for key in scenario.options:
        setting: dict[str, Any] = {"dest": "set", "action": "append", "type": f"{key}={{}}".format}
        parser.add_argument(f"--{key}", metavar="VALUE", help=f"--set {key}=VALUE", **setting)
    return parser
