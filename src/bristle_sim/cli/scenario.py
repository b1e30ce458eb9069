"""A scenario: a question, the parameters of its simulation, and the functions that show the answer."""

from __future__ import annotations

import dataclasses
import runpy
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_type_hints

from bristle_sim.comparison import Report
from bristle_sim.declared import Declaration, Range, declarations
from bristle_sim.parameters import CONTACT_KEYS, KEYS, PARTS, SHAPE_KEYS, Tool
from bristle_sim.readable import WIDTH, aligned
from bristle_sim.tool_file import MAY_BE_ABSENT, read_keys
from bristle_sim.units import likely_key

Values = Mapping[str, Any]
Columns = Mapping[str, Any]
Picture = Any  # a figure of matplotlib
Film = Any  # a film of bristle_sim.render


@dataclass(frozen=True, slots=True)
class Scenario:
    """One question that a script answers on the command line.

    A parameter is set by its key, a name such as ``hub_speed``. The functions of a scenario import
    their modules only when they are called. Help and messages on bad input therefore appear at
    once, and Ctrl-C is handled even while libraries load.

    Attributes:
        name: name of the script, without suffix.
        question: the question in a sentence.
        run: function that answers the question. Its arguments are parameter objects. The declared
            fields of their classes are the script's keys; for a Tool, the fields of all its parts.
            The function may raise ValueError for values that contradict each other.
        plot: function that returns the figure of a report.
        plots: function that draws several figures of a report into a folder or on the pages of a
            PDF.
        film: function that returns the film of a report; it accepts ``width`` and ``height``, px.
        series: function that returns the time series of a report: columns by name and unit, with
            one entry for each sample. None for a scenario without a motion.
        formats: functions that return the time series as text in formats other than CSV. The key is
            the suffix that a file name after ``--csv`` must have for this format.
        tool: function that returns the tool that the scenario found; None if the scenario only
            simulates the given tool.
        defaults: default values that differ from those of the parameter classes, by key, each with
            its source.
        without: keys that the script does not accept, because they have no effect on the answer.
        highest: upper limits below those of the parameter classes, by key, each with its reason.
        in_arrays: whether the quantities are those of a pass, so that a sweep may compute all
            points at once in arrays.
        options: keys with an option of their own; ``--KEY VALUE`` is short for ``--set KEY=VALUE``.
    """

    name: str
    question: str
    run: Callable[..., Report]
    plot: Callable[[Report], Picture] | None = None
    plots: Callable[[Report, Path], None] | None = None
    film: Callable[..., Film] | None = None
    series: Callable[[Report], Columns] | None = None
    formats: Mapping[str, Callable[[Report], str]] = field(default_factory=dict)
    tool: Callable[[Report], Tool] | None = None
    defaults: Mapping[str, tuple[Any, str]] = field(default_factory=dict)
    without: tuple[str, ...] = ()
    highest: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    in_arrays: bool = False
    options: tuple[str, ...] = ()

    @property
    def parts(self) -> tuple[type, ...]:
        """Parameter classes whose declared fields are the scenario's parameters."""
        parts = list[type]()
        for name, kind in get_type_hints(self.run).items():
            if name != "return":
                parts += [kinds[0] for kinds in PARTS.values()] if kind is Tool else []
                parts.append(kind)
        return tuple(parts)

    def keys(self) -> dict[str, Declaration]:
        """Return the declaration of every parameter, by key.

        A key is the name of a parameter on the command line. The declaration states the default of
        this scenario, and its source.
        """
        found = {
            each.key: each
            for part in self.parts
            for each in declarations(part).values()
            if each.listed and each.key not in self.without
        }
        for key, (default, source) in self.defaults.items():
            found[key] = dataclasses.replace(found[key], source=source, default=default)
        for key, (limit, reason) in self.highest.items():
            words = f"{found[key].meaning}; {reason}"
            found[key] = dataclasses.replace(found[key], highest=limit, meaning=words)
        return found

    def values_of(self, typed: Values) -> dict[str, Any]:
        """Return the value of every parameter, by key.

        Args:
            typed: texts or numbers in SI units, by key. The text ``none`` stands for the absence of
                an optional parameter.

        Returns:
            The values. A parameter that is not set has its default.

        Raises:
            ValueError: for an unknown key, a refused value, or a key that has no effect because of
                another key's value. The message has one line.
        """
        keys = self.keys()
        for key, given in typed.items():
            if key not in keys:
                advice = likely_key(key, keys, "--list-keys shows all keys")
                raise ValueError(f"--set {f'{key}={given}'!r}: unknown key {key!r}; {advice}")
        read = {key: keys[key].read(given) for key, given in typed.items()}
        values = {key: declared.default for key, declared in keys.items()} | read
        for key, declared in keys.items():
            other, relation, wanted = declared.needs.split() or ("", "", "")
            if other not in keys or (keys[other].read(wanted) == values[other]) is (
                relation == "="
            ):
                continue
            unset = None if declared.optional else declared.default
            if read.get(key) not in (None, unset):
                words = f"must be left out unless {declared.needs}, or it has no effect"
                raise ValueError(f"{key} = {read[key]!r}: {words}")
            values[key] = unset
        return values

    def warnings_of(self, typed: Values, values: Values) -> list[str]:
        """Return a warning for each unusual value among those that were typed.

        If the number may have been meant in another unit, the warning names this unit.
        """
        keys = self.keys()
        found = [keys[key].unusual(values[key], given) for key, given in typed.items()]
        return [*filter(None, found)]

    def typed_in(self, path: str, option: str = "--parameters") -> tuple[dict[str, Any], list[str]]:
        """Read a tool's file for this scenario.

        A value in the file that equals the default tool's is ignored if it describes the wire's
        shape or the law of impact. The scenario then uses its own default, for example a bent wire.

        Args:
            path: name of the file.
            option: name of the option in messages.

        Returns:
            The values in the file, as texts or numbers by key.
            One warning for each value in the file that has no effect on the scenario.

        Raises:
            ValueError: for a file that cannot be read or is not TOML, an unknown key, a refused
                value, or an absent part. The message has one line.
        """
        keys = self.keys()
        typed = dict[str, Any]()
        idle = list[str]()
        try:
            written = read_keys(path, keys)
        except OSError as error:
            raise ValueError(
                f"{option} = {path!r}: must be a readable file ({error.strerror})"
            ) from error
        for key, given in written.items():
            if key in MAY_BE_ABSENT:
                if PARTS[key][0] in self.parts:
                    raise ValueError(f"{path}: {key} = false: must be present for {self.name}")
                continue
            try:
                value = (KEYS | keys)[key].read(given)
            except ValueError as error:
                raise ValueError(f"{path}: {error}") from error
            if key in (*SHAPE_KEYS, *CONTACT_KEYS) and value == KEYS[key].default:
                continue  # for the tool's default the scenario keeps its own wire and law
            if key in keys:
                typed[key] = given
            elif value != KEYS[key].default:
                idle.append(f"{path}: {key} = {given} has no effect on {self.name}")
        return typed, idle

    def built(self, values: Values) -> dict[str, Any]:
        """Return the arguments of ``run``, built from the given parameter values."""
        kinds = get_type_hints(self.run).items()
        return {name: build_parameters(kind, values) for name, kind in kinds if name != "return"}

    def key_list(self) -> str:
        """Return the text that describes every parameter, 100 columns wide.

        Each parameter has its key, default, unit and range, and below them its meaning and the
        source of the default.
        """
        heads = [["key", "default", "unit"]]
        texts = [("range", "meaning (source of the default)")]
        for key, declared in self.keys().items():
            unit = "" if declared.unit == "word" else declared.unit
            if isinstance(declared, Range):
                unit = declared.display[0]
            default = declared.displayed(declared.default).removesuffix(f" {unit}")
            heads.append([key, default, unit])
            only = f"; only with {declared.needs}" if declared.needs else ""
            note = f"{declared.meaning}{only} (default: {declared.source})"
            texts.append((declared.displayed_range, note))
        columns = aligned(heads, range(3))
        indent = 2 + max(map(len, columns))
        lines = []
        for head, (allowed, note) in zip(columns, texts, strict=True):
            first = head.ljust(indent)
            lines += textwrap.wrap(
                allowed, WIDTH, initial_indent=first, subsequent_indent=" " * indent
            )
            lines += textwrap.wrap(note, WIDTH, initial_indent="    ", subsequent_indent="    ")
        lines.insert(2, "-" * WIDTH)
        return "\n".join(lines)


def assigned(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Split texts ``KEY=VALUE``, and return the values by key; the last value of a key counts.

    ``option`` is the option's name, for the message of the error that a text without = raises.
    """
    for text in texts:
        if "=" not in text:
            raise ValueError(f"{option} {text!r}: must be KEY=VALUE")
    return dict(text.split("=", 1) for text in texts)


def build_parameters(kind: Any, values: Values) -> Any:
    """Return an object of a parameter class, built from values by key.

    A parameter without a value has its default.

    Args:
        kind: parameter class, or Tool.
        values: values by key.
    """
    given = {
        name: values[declared.key]
        for name, declared in declarations(kind).items()
        if declared.key in values
    }
    for name, kinds in PARTS.items() if kind is Tool else ():
        given[name] = build_parameters(kinds[0], values)
    return kind(**given)


def script_paths() -> dict[str, Path]:
    """Return the paths of the scenarios' scripts by name.

    An installed package has the scripts in ``bristle_sim/scenarios``. A work tree has them in
    ``scenarios/`` beside ``src``.
    """
    package = Path(__file__).parents[1]
    folder = package / "scenarios"
    if not folder.is_dir():
        folder = package.parents[1] / "scenarios"
    return {path.stem: path for path in sorted(folder.glob("*.py"))}


def load_scenario(path: Path) -> Scenario:
    """Execute the script at a path, and return its scenario."""
    scenario = runpy.run_path(str(path), run_name=f"bristle_sim.scenarios.{path.stem}")["SCENARIO"]
    assert isinstance(scenario, Scenario)
    return scenario


def main_scenario() -> Scenario:
    """Return the scenario that simulates a whole pass; commands such as ``compare`` use it."""
    return load_scenario(script_paths()["cue_and_impact"])
