"""Declarations of parameters: default, unit, range, meaning and source in one place.

A declaration checks every value of its parameter, whether it comes from Python, a file or the
command line. It also documents the parameter in its class and in a script's list of parameters.
"""

import dataclasses
import functools
import inspect
import math
import textwrap
import warnings
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass
from numbers import Real
from pathlib import Path
from typing import Any

from bristle_sim.readable import plain_number
from bristle_sim.units import (
    GROUPED,
    TYPED,
    conversion,
    display_unit,
    likely_key,
    likely_unit,
    meant_unit,
    scaled,
    shown,
)

FAR = 100.0  # largest ratio of a usual value to its default, or of the default to the value


@dataclass(frozen=True, slots=True)
class Declaration:
    """Declaration of a parameter: its key, unit, default, meaning and source.

    Attributes:
        key: name of the parameter on the command line and in messages.
        unit: unit of a number, "1" for a pure number; otherwise the kind of the text: ``word``,
            ``file``, ``folder`` or ``column``.
        source: source of the default.
        default: default value.
        meaning: meaning of the value, in words.
        optional: whether the value may be None.
        needs: condition on another key for this key to act, such as ``contact = compliant``.
        listed: whether the parameter can be set on the command line.
    """

    key: str
    unit: str = "word"
    _: KW_ONLY
    source: str = ""
    default: Any = None
    meaning: str = ""
    optional: bool = False
    needs: str = ""
    listed: bool = True

    @property
    def allowed(self) -> str:
        """The permitted values in words, for messages and listings."""
        texts = {
            "file": "a readable file",
            "folder": "the name of a folder",
            "column": "the heading of a column, or its number from 1 on",
        }
        return texts[self.unit]

    @property
    def displayed_range(self) -> str:
        """The permitted values in words, in the customary unit, for listings."""
        return self.allowed

    def displayed(self, value: Any) -> str:
        """Return a value as text; a number has five digits and its customary unit, as in ``27 mm``."""
        return "none" if value is None else str(value)

    def read(self, given: Any) -> Any:
        """Check a given object, and return it as a value of this parameter.

        If the parameter is optional, None is returned for None and for the text ``none``.
        """
        absent = given is None or (isinstance(given, str) and given.strip() == "none")
        return None if absent and self.optional else self.parse(given)

    def check(self, value: Any) -> Any:
        """Check that a value is a permitted text, and return it.

        Raises:
            ValueError: if the value is empty or not a text, or names a file that cannot be read.
        """
        if isinstance(value, str) and value.strip():
            with suppress(OSError, ValueError):  # a name too long, a null character
                if self.unit != "file" or Path(value).is_file():
                    return str(value)
        raise ValueError(f"{self.key} = {shown(value)}: must be {self.allowed}")

    parse = check

    def unusual(self, _value: Any, _given: Any) -> str:
        """Return a warning if a value is unusual; empty for a usual value, and for every text."""
        return ""


@dataclass(frozen=True, slots=True)
class Choice(Declaration):
    """Declaration of a parameter whose value is one of a few words, its ``options``."""

    options: tuple[str, ...] = ()

    @property
    def allowed(self) -> str:
        """The permitted words, for messages and listings."""
        return " | ".join(self.options)

    def check(self, value: Any) -> str:
        """Check that a value is one of the permitted words, and return it.

        Raises:
            ValueError: for any other value; the message names key, value and permitted words.
        """
        if not isinstance(value, str) or value not in self.options:
            advice = likely_key(shown(value), self.options, "")
            hint = f"; {advice}" if advice else ""
            raise ValueError(f"{self.key} = {shown(value)}: must be one of {self.allowed}{hint}")
        return str(value)

    parse = check


@dataclass(frozen=True, slots=True)
class Range(Declaration):
    """Declaration of a parameter that is a real or whole number.

    Attributes:
        lowest, highest: ends of the range.
        lowest_allowed: whether the range includes its lower end.
        usual: range of magnitudes without a warning; by default 1/100 to 100 times the default.
        whole: whether the number must be whole; the value is then an int.
    """

    lowest: float = -math.inf
    highest: float = math.inf
    lowest_allowed: bool = True
    _: KW_ONLY
    usual: tuple[float, float] | None = None
    whole: bool = False

    @property
    def allowed(self) -> str:
        """The range in words, for messages and listings."""
        if self.whole:
            return f"whole number from {self.lowest:.0f} to {self.highest:.0f}"
        sign = "<=" if self.lowest_allowed else "<"
        return f"{self.lowest:g} {sign} {self.key} <= {self.highest:g}"

    @property
    def displayed_range(self) -> str:
        """The range in the customary unit, for listings."""
        if self.whole:
            return self.allowed
        low, high = (plain_number(end / self.display[1], 5) for end in (self.lowest, self.highest))
        return f"{low} {'<=' if self.lowest_allowed else '<'} {self.key} <= {high}"

    @property
    def display(self) -> tuple[str, float]:
        """Customary unit, such as mm, and its size in the declared unit; "" for a pure number."""
        return display_unit(self.key, self.unit)

    def displayed(self, value: Any) -> str:
        """Return a number as text with five digits in its customary unit, for example ``27 mm``."""
        if value is None or self.whole:
            return "none" if value is None else str(value)
        unit, size = self.display
        return f"{plain_number(value / size, 5)} {unit}".rstrip()

    def parse(self, text: Any) -> float:
        """Return the value of a typed number in the declared unit, after a check of its range.

        A number with a unit, such as ``27mm``, is converted; a number without a unit is in the
        declared unit. A value that is not a text is checked without conversion.

        Raises:
            ValueError: if the number is not decimal, or its dimension or value is not permitted.
        """
        if not isinstance(text, str):
            return self.check(text)
        typed = TYPED.fullmatch(text.strip())
        if typed is None:
            meant = text.strip().replace(",", "" if GROUPED.match(text.strip()) else ".")
            likely = TYPED.fullmatch(meant)  # a comma for thousands, or a decimal one
            raise self.refusal(text, f"; did you mean {meant}?" if likely else "")
        number = float(typed["number"])
        if unit := typed["unit"]:
            factor = conversion(unit, self.unit)
            if factor is None:
                why = f", to which {unit} cannot be converted{likely_unit(unit, self.unit)}"
                raise self.refusal(text, why)
            number = scaled(number, factor)
        return self.check(number, text)

    def check(self, value: Any, typed: str | None = None) -> float:
        """Return a value in the range, as a float (0 for -0), or as an int if it must be whole.

        Args:
            value: value in the declared unit.
            typed: text from which the value was read; the message then shows this text.

        Raises:
            ValueError: for anything but a number in the range; the message names key and range.
        """
        try:
            real = not isinstance(value, bool) and isinstance(value, Real)
            number = float(value) if real else math.nan
        except (OverflowError, TypeError):  # too large an integer, or a duration of NumPy
            number = math.nan
        if self.holds(number):
            return int(number) if self.whole else number + 0.0
        # A number without unit may have been meant in the customary unit, for example 27 in mm.
        unit, size = self.display
        bare = f"{number:g}" if typed is None else typed.strip()
        fits = bare[-1].isdigit() and size < 1.0 and self.holds(scaled(number, size))
        refused = value if math.isnan(number) else number
        if self.whole and number.is_integer():
            refused = int(number)
        raise self.refusal(typed or refused, f"; did you mean {bare} {unit}?" if fits else "")

    def holds(self, number: Any) -> Any:
        """Return whether each number of an array is in the range, and is whole if it must be."""
        above = number >= self.lowest if self.lowest_allowed else number > self.lowest
        whole = number % 1.0 == 0.0 if self.whole else True
        return above & (number <= self.highest) & (abs(number) < math.inf) & whole

    def refusal(self, value: Any, why: str = "") -> ValueError:
        """Return the ValueError for a refused value; ``why`` ends its message."""
        unit = "dimensionless" if self.unit == "1" else f"in {self.unit}"
        rule = self.allowed if self.whole else f"finite number with {self.allowed}"
        return ValueError(
            f"{self.key} = {shown(value)}: must be a {rule} ({unit}{' '.join(why.split())})"
        )

    def unusual(self, value: Any, given: Any) -> str:
        """Return a warning if a value is unusual, with the unit that may be meant; otherwise empty.

        Args:
            value: value in the declared unit.
            given: value as it was typed or passed.
        """
        default = abs(self.default or 0.0)
        least, most = self.usual or (default / FAR, default * FAR)
        # A value at either end, up to rounding, is unusual. Zero is not: it switches an effect off.
        if not value or not most or least * (1.0 + 1e-12) < abs(value) < most * (1.0 - 1e-12):
            return ""
        unit = "" if self.unit == "1" else f" {self.unit}"
        ratio = " is unusual"
        if default:
            ratio = f" is {value / self.default:.3g} times the default, {self.default:.6g}{unit}"
        text = given if isinstance(given, str) else f"{float(given):g}"
        meant = meant_unit(text, self.unit, self.default or math.sqrt(least * most))
        hint = f"; if it was meant in {meant}: {self.key}='{text.strip()} {meant}'" if meant else ""
        return f"{self.key} = {value:.6g}{unit}{ratio}{hint}"


@functools.cache
def declarations(kind: Any) -> dict[str, Any]:
    """Return the declarations of a parameter class by field name."""
    return {
        each.name: each.metadata["declaration"]
        for each in dataclasses.fields(kind)
        if each.metadata
    }


class Computed(float):
    """Number in a field that was not set, computed from other fields of the same object.

    ``dataclasses.replace`` computes the number anew, and a tool file omits it.
    """

    __slots__ = ()


class UnusualValueWarning(UserWarning):
    """Warns that a parameter is so far from its default that it may be in the wrong unit."""


class UnknownFieldError(TypeError, ValueError):
    """Raised for a keyword argument that is not a field of the parameter class."""


class Declared:
    """Base class of frozen parameter dataclasses, whose declared fields are checked on creation.

    Unusual values cause a warning. The docstring of a subclass lists key, meaning, unit, range,
    default and source of each declared field.
    """

    __slots__ = ()

    def __init_subclass__(cls) -> None:
        """Append a description of each declared field to the docstring of the subclass.

        This happens before the dataclass decorator replaces the fields by their defaults.
        """
        own = {
            name: each for name, each in vars(cls).items() if isinstance(each, dataclasses.Field)
        }
        if not own:  # the decorator creates the class a second time, for its slots
            return
        lines = [inspect.cleandoc(cls.__doc__ or ""), "", "Attributes:"]
        for name, each in {**getattr(cls, "__dataclass_fields__", {}), **own}.items():
            if (declared := each.metadata.get("declaration")) is not None:
                key = "" if name == declared.key else f" Key {declared.key}."
                unit = "" if declared.unit in ("1", "word") else f", {declared.unit}"
                default = (
                    each.default if isinstance(each.default, str | None) else f"{each.default:.9g}"
                )
                words = f"{name}: {declared.meaning}{unit}.{key} Must be {declared.allowed}. Default {default} ({declared.source})."
                lines += textwrap.wrap(
                    words, 100, initial_indent="    ", subsequent_indent="        "
                )
        cls.__doc__ = "\n".join(lines)

    def __new__(cls, *_: Any, **given: Any) -> Any:
        """Refuse a keyword argument that is not a field, and suggest the most similar field."""
        known = [each.name for each in dataclasses.fields(cls)]  # type: ignore[arg-type]
        for name in given:
            if name not in known:
                raise UnknownFieldError(
                    f"{cls.__name__}: unknown field {name!r}; {likely_key(name, known)}"
                )
        return super().__new__(cls)

    def __post_init__(self) -> None:
        """Check every declared field, and replace its value by the checked value.

        A text such as "27 mm" becomes a number; an unusual value causes a warning.

        Raises:
            ValueError: for a value that its declaration refuses.
        """
        kind: Any = type(self)
        for name, declared in declarations(kind).items():
            given = getattr(self, name)
            value = declared.read(given)
            object.__setattr__(self, name, value)
            if value != declared.default and (line := declared.unusual(value, given)):
                warnings.warn(line, UnusualValueWarning, stacklevel=3)
