"""Declared, checked fields for frozen parameter objects.

A physical parameter is declared once, with its meaning, default, unit, range and source. The declaration validates every
value that enters a parameter object and is what the scenario scripts list and parse.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import math
import re
import reprlib
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from typing import Any

from bristle_sim.glossary import KEYS, Key

ANY = (0.0, math.inf)
"""Sizes that are usual for a number whose default does not tell which others are likely, such as an accuracy."""

FAR = 100.0  # a value this many times its default, or less than the default by this factor, is unusual


@dataclass(frozen=True, slots=True)
class Range:
    """A real number, or a whole one, with a unit and the range it must be in.

    Attributes:
        key: its name on the command line and in messages.
        unit: of the number; "1" for pure numbers.
        lowest, highest, lowest_allowed: the range; whether it includes its lower end.
        source: of the default.
        optional: whether the value may be None.
        meaning: what it is, in a few words.
        usual: smallest and largest size that draws no warning; None for those within a factor of 100 of the default.
        needs: a condition on another key without which this one has no effect, such as ``contact = compliant``.
        whole: whether it must be a whole number, which is then kept as an int.
        mistaken: a value that is likely a mistake, and why.
    """

    key: str
    unit: str
    lowest: float
    highest: float
    lowest_allowed: bool
    source: str
    optional: bool = False
    meaning: str = ""
    usual: tuple[float, float] | None = None
    needs: str = ""
    whole: bool = False
    mistaken: tuple[float, str] | None = None

    @property
    def allowed(self) -> str:
        """Say the range in words, for messages and listings."""
        if self.whole:
            return f"whole number from {self.lowest:.0f} to {self.highest:.0f}"
        return f"{self.lowest:g} {'<=' if self.lowest_allowed else '<'} {self.key} <= {self.highest:g}"

    def parse(self, text: str) -> float:
        """Turn a typed decimal number, with a unit (``27mm``) or in the declared one, into a checked value.

        Raises ValueError in one line, for what is no number, of another dimension, or out of range.
        """
        typed = TYPED.fullmatch(text.strip())
        number = math.nan if typed is None else float(typed["number"])
        if typed is not None and typed["unit"]:
            factor = conversion(typed["unit"], self.unit)
            if factor is None:
                why = f", to which {typed['unit']} cannot be converted{_likely_unit(typed['unit'], self.unit)}"
                raise self.refusal(text, why)
            number *= factor
        return self._checked(number, text)

    def check(self, value: Any) -> float:
        """Return the value as a float, or raise ValueError naming key, value, range and unit."""
        if isinstance(value, bool) or not isinstance(value, Real):
            raise self.refusal(value)
        try:
            number = float(value)
        except OverflowError:
            number = -math.inf if value < 0 else math.inf
        return self._checked(number, number)

    def _checked(self, number: float, given: Any) -> float:
        """Return a number that is in range, without a negative zero."""
        above = number >= self.lowest if self.lowest_allowed else number > self.lowest
        if not (above and number <= self.highest and math.isfinite(number) and (not self.whole or number.is_integer())):
            raise self.refusal(given)
        return int(number) if self.whole else number + 0.0

    def refusal(self, value: Any, why: str = "") -> ValueError:
        """Return what to raise for a value that is refused."""
        unit = "dimensionless" if self.unit == "1" else f"in {self.unit}"
        rule = self.allowed if self.whole else f"finite number with {self.allowed}"
        return ValueError(f"{self.key} = {shown(value)}: must be a {rule} ({unit}{why})")

    def unusual(self, value: float, default: float | None) -> bool:
        """Tell whether a value is so far from the default, or from what is usual, that its unit may be mistaken."""
        if self.usual is None and not default:
            return False
        least, most = self.usual or (abs(default or 0.0) / FAR, abs(default or 0.0) * FAR)
        return value != 0.0 and not least * (1.0 + 1e-12) < abs(value) < most * (1.0 - 1e-12)  # but for rounding


_UNIT = r"[A-Za-z%\u00b0\u00b5\u03bc]+(?:(?:\^|\*\*)-?\d|[\u00b2\u00b3])?"

TYPED = re.compile(
    rf"(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>{_UNIT}(?:\s*[*/\u00b7 ]\s*{_UNIT})*)?",
    re.ASCII,
)
"""A decimal number and perhaps a product of powers of units. Python's float() takes more: grouped digits, those of other
scripts, which nobody types on purpose here."""


TYPICAL_UNITS = (
    *("m", "mm", "um", "cm", "inch", "metre", "millimetre", "micrometre", "kg", "g", "mg", "gram", "s", "ms", "us", "second"),
    *("rad/s", "rpm", "deg/s", "rad", "deg", "degree", "N m/rad", "N m/deg", "N", "mN", "kN", "Hz", "kHz", "m/s", "m/s^2"),
    *("Pa", "kPa", "MPa", "GPa", "N/mm^2", "N/m", "N/V", "N/mV", "percent"),
)  # fmt: skip
"""Units that a mistyped one is compared with."""


def conversion(unit: str, to: str) -> float | None:
    """Return the factor that converts a number from one unit to another; None where there is none.

    An angle is a dimension of its own here: 250 Hz are not 250 rad/s, nor N m the same as N m/rad.
    """
    try:
        factor = float(_registry().Quantity(1.0, unit).to(to.replace(" ", "*")).magnitude)
    except Exception:  # pint passes on whatever its parser meets: TokenError, ZeroDivisionError, AssertionError, ...
        return None
    return factor if math.isfinite(factor) and factor > 0.0 else None


def _likely_unit(unit: str, to: str) -> str:
    """Advise the unit with the most similar name of those that can be converted, where nothing is called so."""
    if conversion(unit, unit) is not None:
        return ""
    fitting = [name for name in TYPICAL_UNITS if conversion(name, to) is not None]
    likely = difflib.get_close_matches(unit, fitting, n=1)
    return f"; did you mean {likely[0]}?" if likely else ""


@functools.cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(filename=None)
    registry.load_definitions(Path(pint.__file__).with_name("default_en.txt"))
    registry.define("radian = [plane_angle] = rad")
    return registry


MISTAKEN = 0.02  # a value this close to a likely mistake, relative, is taken for it


def unusual_value(declared: Any, default: Any, value: Any, text: str = "") -> str:
    """Return a line that says why a value is unusual, with the unit that may have been meant; empty where it is usual.

    ``text`` is the value as typed; a bare number may have been meant in another unit.
    """
    if not isinstance(declared, Range) or value is None:
        return ""
    unit = "" if declared.unit == "1" else f" {declared.unit}"
    named = f"{declared.key} = {value:.6g}{unit}"
    if declared.mistaken is not None and math.isclose(value, declared.mistaken[0], rel_tol=MISTAKEN):
        return f"{named} is {declared.mistaken[1]}"
    if not declared.unusual(value, default):
        return ""
    ratio = f" is {value / default:.3g} times the default, {default:.6g}{unit}" if default else " is unusual"
    return f"{named}{ratio}{_meant_unit(declared, text or repr(value), default)}"


def _meant_unit(declared: Range, text: str, default: float | None) -> str:
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


@dataclass(frozen=True, slots=True)
class Choice:
    """A declared word out of a few."""

    key: str
    options: tuple[str, ...]
    source: str
    unit: str = "word"
    optional: bool = False
    meaning: str = ""
    needs: str = ""

    @property
    def allowed(self) -> str:
        """List the words, for messages and listings."""
        return " | ".join(self.options)

    def check(self, value: Any) -> str:
        """Return the word, or raise ValueError naming key, value and the words it must be one of."""
        if not isinstance(value, str) or value not in self.options:
            raise ValueError(f"{self.key} = {shown(value)}: must be one of {self.allowed}")
        return str(value)

    parse = check


LONGEST_SHOWN = 100  # characters of a value in a message


def shown(value: Any) -> str:
    """Write any value in one short line, for messages."""
    try:
        text = reprlib.repr(value)
    except ValueError:  # a whole number of thousands of digits, which Python does not write out
        text = f"<{type(value).__name__}>"
    line = " ".join(each.strip() for each in text.splitlines())
    return line if len(line) <= LONGEST_SHOWN else f"{line[:LONGEST_SHOWN]}..."


def quantity(
    default: float | None,
    key: str,
    unit: str = "",
    *,
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
    source: str,
    meaning: str = "",
    usual: tuple[float, float] | None = None,
    needs: str = "",
    whole: bool = False,
    mistaken: tuple[float, str] | None = None,
) -> Any:
    """Declare a dataclass field that holds a real number; ``above`` excludes its bound, ``at_least`` includes it.

    A default of None makes the parameter optional. ``meaning``, ``usual``, ``needs``, ``whole`` and ``mistaken`` are those of
    :class:`Range`; unit, meaning and range are the glossary's unless given.
    """
    if above is not None and at_least is not None:
        raise ValueError(f"{key}: declare one of above and at_least")
    known = KEYS.get(key, Key())
    lowest = next(each for each in (above, at_least, known.lowest) if each is not None)
    highest = known.highest if at_most is None else at_most
    allowed = above is None and (known.lowest_allowed or at_least is not None)
    words = (source, default is None, meaning or known.meaning, usual, needs, whole, mistaken)
    return _declared(default, Range(key, unit or known.unit, lowest, highest, allowed, *words))


count = functools.partial(quantity, unit="1", usual=ANY, whole=True)
"""Declare a dataclass field that holds a whole number between two bounds, which it may have."""


def choice(default: str, key: str, options: tuple[str, ...], *, source: str, meaning: str = "") -> Any:
    """Declare a dataclass field that holds one word out of a few."""
    return _declared(default, Choice(key, options, source, meaning=meaning or KEYS.get(key, Key()).meaning))


def _declared(default: Any, declared: Range | Choice) -> Any:
    return field(default=default, metadata={"declaration": declared})


def declarations(owner: Any) -> dict[str, Range | Choice]:
    """Return the declarations of a parameter class or object by the names of its fields."""
    fields = dataclasses.fields(owner)
    return {each.name: each.metadata["declaration"] for each in fields if "declaration" in each.metadata}


def validate(instance: Any) -> None:
    """Check every declared field of a frozen dataclass instance and store it as a plain number or word."""
    for name, declared in declarations(instance).items():
        value = getattr(instance, name)
        checked = None if value is None and declared.optional else declared.check(value)
        object.__setattr__(instance, name, checked)


class Declared:
    """Base of frozen dataclasses whose declared fields are checked when an object is made."""

    __slots__ = ()

    def __post_init__(self) -> None:
        validate(self)
