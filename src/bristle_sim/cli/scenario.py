"""A scenario: one question, its keys and what is typed for them, and the functions that answer and show it."""

from __future__ import annotations

import dataclasses
import importlib
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_type_hints

from bristle_sim import tool_file
from bristle_sim.comparison import WIDTH, Report
from bristle_sim.parameters import PARTS, Tool
from bristle_sim.units import TYPICAL_UNITS, Choice, Range, conversion, declarations

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Values = Mapping[str, Any]
Columns = Mapping[str, Sequence[Any]]
T = TypeVar("T", bound="DataclassInstance")


@dataclass(frozen=True, slots=True)
class Scenario:
    """One question that a script answers on the command line.

    Attributes:
        name: of the script, without suffix.
        question: in a sentence.
        parts: parameter classes whose declared fields are the script's keys.
        run: answers the question for given key values; may raise ValueError for values that do not fit together.
        plot, video: draw a report to a path; like ``run`` they import what they need themselves, so that help and bad
            input are answered at once and Ctrl-C ends in order even while libraries load.
        series: gives the time series of a report, by name and unit, one entry a sample; None without a motion.
        defaults: key values that differ from the parameter classes' own, each with its source.
        without: keys of the parts that mean nothing to the question.
        highest: upper limits of keys that are lower than in the parameter classes, each with its reason.
        plot_is_folder: ``--plot`` names a folder, or a PDF of several pages, instead of a picture.
        options: keys that also have an option of their own; ``--KEY VALUE`` is short for ``--set KEY=VALUE``.
    """

    name: str
    question: str
    parts: tuple[type, ...]
    run: Callable[[Values], Report]
    plot: Callable[[Report, Path], None] | None = None
    video: Callable[[Report, Path], None] | None = None
    series: Callable[[Report], Columns] | None = None
    defaults: Mapping[str, tuple[Any, str]] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    highest: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    plot_is_folder: bool = False
    options: tuple[str, ...] = ()

    def keys(self) -> dict[str, tuple[Range | Choice, Any]]:
        """Return every key with its declaration and default; the declaration's source is that of this default."""
        found: dict[str, tuple[Range | Choice, Any]] = {}
        for part in self.parts:
            defaults = {each.name: each.default for each in dataclasses.fields(part)}
            found |= {each.key: (each, defaults[name]) for name, each in declarations(part).items()}
        for key, (default, source) in self.defaults.items():
            found[key] = (dataclasses.replace(found[key][0], source=source), default)
        for key, (limit, reason) in self.highest.items():
            declared, default = found[key]
            assert isinstance(declared, Range)
            found[key] = (
                dataclasses.replace(declared, highest=limit, meaning=f"{declared.meaning}; {reason}"),
                default,
            )
        return {key: each for key, each in found.items() if key not in self.without}

    def values_of(self, assignments: Sequence[str]) -> dict[str, Any]:
        """Return every key's value: its default, or the last that the ``KEY=VALUE`` assignments give it.

        Raises:
            ValueError: in one line, for an unknown key, a value that is refused, or a key that another one's value leaves
                without effect.
        """
        keys = self.keys()
        typed = {}
        for assignment in assignments:
            key, equals, text = assignment.partition("=")
            if not equals:
                raise ValueError(f"--set {assignment!r}: must be KEY=VALUE")
            if key not in keys:
                advice = tool_file.likely_key(key, keys, "--list-keys shows all keys")
                raise ValueError(f"--set {assignment!r}: unknown key {key!r}; {advice}")
            typed[key] = keys[key][0].parse(text)
        values = {key: default for key, (_, default) in keys.items()} | typed
        for key, (declared, default) in keys.items():
            if _holds(declared.needs, values):
                continue
            if key in typed and (declared.optional or typed[key] != default):
                raise ValueError(
                    f"{key} = {typed[key]!r}: must be left out unless {declared.needs}, or it has no effect"
                )
            values[key] = None if declared.optional else default
        return values

    def assignments_from(self, path: str) -> tuple[list[str], list[str]]:
        """Return the assignments that a parameter file makes, and a warning for each value that the scenario does not use.

        Raises:
            ValueError: in one line, for a file that cannot be read or is no TOML, an unknown key, a value that is refused, or
                an absent part.
        """
        keys, assignments, idle = self.keys(), [], []
        try:
            typed = tool_file.read_keys(path, keys)
        except OSError as error:
            raise ValueError(f"--parameters = {path!r}: must be a readable file ({error.strerror})") from error
        known = Scenario("", "", (*(kinds[0] for kinds in PARTS.values()), Tool), run=self.run).keys()
        for key, text in typed.items():
            if key in tool_file.MAY_BE_ABSENT:
                if PARTS[key][0] in self.parts:
                    raise ValueError(f"{path}: {key} = false: must be present for {self.name}")
                continue
            try:
                value = (keys if key in keys else known)[key][0].parse(text)
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from error
            if key in keys:
                assignments.append(f"{key}={text}")
            elif value != known[key][1]:
                idle.append(f"{path}: {key} = {text} has no effect on {self.name}")
        return assignments, idle

    def key_list(self) -> str:
        """Return two lines or more for each key: default, unit and range, below them meaning and source; 100 columns wide."""
        cells = [("key", "default", "unit", "range")]
        notes = ["meaning (source of the default)"]
        for key, (declared, default) in self.keys().items():
            shown = "none" if default is None else default if isinstance(default, str) else f"{default:.9g}"
            cells.append((key, shown, declared.unit, declared.allowed))
            only = f"; only with {declared.needs}" if declared.needs else ""
            notes.append(f"{declared.meaning}{only} (default: {declared.source})")
        widths = [max(len(row[column]) for row in cells) for column in range(3)]
        lines = []
        for row, note in zip(cells, notes, strict=True):
            head = "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=False)) + "  "
            lines += textwrap.wrap(row[3], WIDTH, initial_indent=head, subsequent_indent=" " * len(head))
            lines += textwrap.wrap(note, WIDTH, initial_indent="    ", subsequent_indent="    ")
        lines.insert(2, "-" * WIDTH)
        return "\n".join(lines)


def build_tool(values: Values) -> Tool:
    """Build a tool from key values; parts without keys are as by default."""
    gravity = {"gravity": values["gravity"]} if "gravity" in values else {}
    parts: dict[str, Any] = {name: build(kinds[0], values) for name, kinds in PARTS.items()}
    return Tool(**parts, **gravity)


def build(part: type[T], values: Values) -> T:
    """Build a parameter object of the given class from key values."""
    return part(**{name: values[each.key] for name, each in declarations(part).items() if each.key in values})


def _holds(condition: str, values: Values) -> bool:
    """Whether ``KEY = VALUE`` or ``KEY != VALUE`` is true; a key that the scenario does not have imposes nothing."""
    if not condition:
        return True
    key, relation, word = condition.split()
    if key not in values:
        return True
    value = values[key]
    equal = value == word if isinstance(value, str) else value == float(word)
    return equal is (relation == "=")


def warnings_of(scenario: Scenario, assignments: Sequence[str], values: Values) -> list[str]:
    """Return one line for each typed value that is far from its default, with the unit that may have been meant."""
    keys, lines = scenario.keys(), []
    for key, text in dict(each.split("=", 1) for each in assignments).items():
        declared, default = keys[key]
        if not isinstance(declared, Range) or not declared.unusual(values[key], default):
            continue
        unit = "" if declared.unit == "1" else f" {declared.unit}"
        ratio = "" if not default else f" is {values[key] / default:.3g} times the default, {default:.6g}{unit}"
        lines.append(f"{key} = {values[key]:.6g}{unit}{ratio or ' is unusual'}{_likely_unit(declared, text, default)}")
    return lines


def _likely_unit(declared: Range, text: str, default: float | None) -> str:
    """Suggest the unit of a bare number that would bring it within a factor of ten of the default."""
    try:
        number = float(text)
    except ValueError:  # it has a unit already
        return ""
    for unit in TYPICAL_UNITS:
        size = conversion(unit, declared.unit) or 1.0
        if default and size != 1.0 and 0.1 <= abs(number * size / default) <= 10.0:
            return f"; if it was meant in {unit}: {declared.key}='{text.strip()} {unit}'"
    return ""


def study(name: str) -> Callable[[Values], Report]:
    """Return a run: ``module.function`` of this package, each argument built from key values by the type of its parameter."""

    def run(values: Values) -> Report:
        """Build each argument, and answer."""
        answer, given = _named(name), dict[str, Any]()
        for parameter, kind in get_type_hints(answer).items():
            part = next(iter(get_args(kind)), kind)
            if parameter == "with_reference":
                given[parameter] = values["reference"] == "yes"
            elif parameter != "return":
                given[parameter] = build_tool(values) if part is Tool else build(part, values)
        report: Report = answer(**given)
        return report

    return run


def figure(name: str, *attributes: str) -> Callable[[Report, Path], None]:
    """Return a plot of a report's subject, or of attributes of it, by the function of ``bristle_sim.render.NAME`` of that name."""

    def plot(report: Report, path: Path) -> None:
        """Draw the subject, and write the picture."""
        from bristle_sim.render.style import save_figure

        save_figure(_named(f"render.{name}.{name}")(*_shown(report, attributes)), path)

    return plot


def film(name: str, *attributes: str) -> Callable[[Report, Path], None]:
    """Return a video of a report's subject, or of attributes of it, by a film ``module.Class`` of ``bristle_sim.render``."""
    return lambda report, path: _named(f"render.{name}")(*_shown(report, attributes)).write(path)


def _named(name: str) -> Callable[..., Any]:
    module, _, function = name.rpartition(".")
    found: Callable[..., Any] = getattr(importlib.import_module(f"bristle_sim.{module}"), function)
    return found


def _shown(report: Report, attributes: Sequence[str]) -> list[Any]:
    return [getattr(report.subject, each) for each in attributes] or [report.subject]


def figure_of_impact(report: Report, path: Path) -> None:
    """Draw an impact and the families that it belongs to, whose points are simulated for the picture."""
    from bristle_sim.dissertation.impact_families import impact_families
    from bristle_sim.render.impact_figure import impact_figure
    from bristle_sim.render.style import save_figure

    save_figure(impact_figure(report.subject, impact_families(report.subject)), path)


def film_of_impact(report: Report, path: Path) -> None:
    """Film an impact in ultra slow motion, compressed in the printed 50 us unless contact_duration says otherwise."""
    from bristle_sim.render.impact_film import ImpactFilm
    from bristle_sim.studies.timed_contact import with_visible_contact

    ImpactFilm(with_visible_contact(report.subject)).write(path)


def series_of_impact(report: Report) -> dict[str, Any]:
    """Return an impact in time, where its law resolves it."""
    return dict(report.subject.strikes[report.subject.law].contact.columns())


def series_of_contact(report: Report) -> dict[str, Any]:
    """Return a contact resolved in time, or raise ValueError where there is none."""
    if report.subject.contact is None:
        raise ValueError(report.subject.no_contact)
    return dict(report.subject.contact.record.columns())


def series_of_pass(report: Report) -> dict[str, Any]:
    """Return the simulated motion."""
    return dict(report.subject.trajectory.columns())
