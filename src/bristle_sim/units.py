"""Declarations of numbers and words, and the units that may be typed."""

import difflib
import math
import re
import reprlib
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Real
from typing import Any

from bristle_sim.conversion import (
    TYPED,
    TYPICAL_UNITS,
    conversion,
    display_unit,
    likely_unit,
    plain_number,
    scaled,
)

GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+(?![\d,])")
"""Pattern of a number whose thousands are grouped by commas, as in 3,000 rpm."""

FAR = 100.0  # largest ratio of a usual value to its default, or of the default to the value


@dataclass(frozen=True, slots=True)
class Range:
    """Declaration of a real or whole number: unit, range and source.

    Attributes:
        key: its name on the command line and in messages.
        unit: unit of the number; "1" for a pure number.
        lowest, highest: ends of the range.
        lowest_allowed: whether the range includes its lower end.
        source: source of the default.
        optional: whether the value may be None.
        meaning: meaning of the number, in words.
        usual: smallest and largest size without a warning; None for sizes within a factor of 100 of
            the default.
        needs: condition on another key without which this key has no effect, such as ``contact =
            compliant``.
        whole: whether the number must be whole; it is then an int.
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

    @property
    def allowed(self) -> str:
        """The range in words, for messages and listings."""
        if self.whole:
            return f"whole number from {self.lowest:.0f} to {self.highest:.0f}"
        return (
            f"{self.lowest:g} {'<=' if self.lowest_allowed else '<'} {self.key} <= {self.highest:g}"
        )

    @property
    def display(self) -> tuple[str, float]:
        """Unit in which a person types and reads the number, "" for a pure number, and its size in
        the declared unit.
        """
        return display_unit(self.key, self.unit)

    def with_display_unit(self, text: str) -> str:
        """Return a typed text for :meth:`parse`; a bare number gets the displayed unit, as ``30``
        becomes ``30 mm``.
        """
        typed = TYPED.fullmatch(text.strip())
        bare = typed is not None and not typed["unit"]
        return f"{text.strip()} {self.display[0]}".rstrip() if bare else text

    def parse(self, text: str) -> float:
        """Return the checked value of a typed decimal number, with a unit (``27mm``) or in the
        declared unit.

        Raises:
            ValueError: in one line, if the text is no number, has another dimension, or is out of
                range.
        """
        typed = TYPED.fullmatch(text.strip())
        number = math.nan if typed is None else float(typed["number"])
        meant = text.strip().replace(",", "" if GROUPED.match(text.strip()) else ".")
        if typed is None and TYPED.fullmatch(meant):  # a comma for thousands, or a decimal one
            raise self.refusal(text, f"; did you mean {meant}?")
        if typed is not None and typed["unit"]:
            factor = conversion(typed["unit"], self.unit)
            if factor is None:
                why = f", to which {typed['unit']} cannot be converted{likely_unit(typed['unit'], self.unit)}"
                raise self.refusal(text, why)
            number = scaled(number, factor)
        return self.check(number, text)

    def check(self, value: Any, typed: str | None = None) -> float:
        """Return the value as a float without a negative zero.

        Raises:
            ValueError: for a value out of range; the message names key, value, range and unit.
        """
        if isinstance(value, bool) or not isinstance(value, Real):
            raise self.refusal(value)
        try:
            number = float(value)
        except OverflowError:
            number = -math.inf if value < 0 else math.inf
        above = number >= self.lowest if self.lowest_allowed else number > self.lowest
        if not (
            above
            and number <= self.highest
            and math.isfinite(number)
            and (not self.whole or number.is_integer())
        ):
            raise self.refusal(
                number if typed is None else typed, self._likely_display_unit(number, typed)
            )
        return int(number) if self.whole else number + 0.0

    def _likely_display_unit(self, number: float, typed: str | None) -> str:
        """Return a hint to the displayed unit if a refused bare number is in the range with it: 27
        m may be meant in mm.
        """
        size = self.display[1]
        bare = typed or f"{number:g}"
        fits = size < 1.0 and self.lowest <= scaled(number, size) <= self.highest
        meant = self.with_display_unit(bare)
        return f"; did you mean {meant}?" if fits and meant != bare else ""

    def refusal(self, value: Any, why: str = "") -> ValueError:
        """Return the error for a refused value; ``why`` may repeat a typed number with its unit."""
        unit = "dimensionless" if self.unit == "1" else f"in {self.unit}"
        rule = self.allowed if self.whole else f"finite number with {self.allowed}"
        return ValueError(
            f"{self.key} = {shown(value)}: must be a {rule} ({unit}{' '.join(why.split())})"
        )


def displayed(declared: Any, value: Any) -> str:
    """Return the value of a key as a person reads it, with five digits and the displayed unit, for
    example ``27 mm``.
    """
    if value is None or isinstance(value, str) or declared.whole:
        return "none" if value is None else str(value)
    unit, size = declared.display
    return f"{plain_number(value / size, 5)} {unit}".rstrip()


def displayed_range(declared: Any) -> str:
    """Return the range of a key in the displayed unit, or the permitted words, for listings."""
    if not isinstance(declared, Range) or declared.whole:
        return str(declared.allowed)
    low, high = (
        plain_number(end / declared.display[1], 5) for end in (declared.lowest, declared.highest)
    )
    return f"{low} {'<=' if declared.lowest_allowed else '<'} {declared.key} <= {high}"


def unusual_value(declared: Any, default: Any, value: Any, given: Any) -> str:
    """Return a line that states why a value is unusual, with the unit that may be meant; empty for
    a usual value.

    ``given`` is the value as typed; a bare number may be meant in another unit.
    """
    if not isinstance(declared, Range) or value is None:
        return ""
    least, most = declared.usual or (abs(default or 0.0) / FAR, abs(default or 0.0) * FAR)
    if (
        value == 0.0 or most == 0.0 or least * (1.0 + 1e-12) < abs(value) < most * (1.0 - 1e-12)
    ):  # the ends include rounding
        return ""
    unit = "" if declared.unit == "1" else f" {declared.unit}"
    ratio = (
        f" is {value / default:.3g} times the default, {default:.6g}{unit}"
        if default
        else " is unusual"
    )
    meant = _meant_unit(
        declared,
        given if isinstance(given, str) else f"{given:g}",
        default or math.sqrt(least * most),
    )
    return f"{declared.key} = {value:.6g}{unit}{ratio}{meant}"


def _meant_unit(declared: Range, text: str, typical: float) -> str:
    """Return a hint to the unit that would bring a bare number within a factor of ten of a typical
    value.
    """
    try:
        number = float(text)
    except ValueError:  # the text has a unit already
        return ""
    for unit in TYPICAL_UNITS:
        size = conversion(unit, declared.unit) or 1.0
        if size != 1.0 and 0.1 <= abs(number * size / typical) <= 10.0:
            return f"; if it was meant in {unit}: {declared.key}='{text.strip()} {unit}'"
    return ""


@dataclass(frozen=True, slots=True)
class Choice:
    """Declaration of a field whose value is one of a few words."""

    key: str
    options: tuple[str, ...]
    source: str
    unit: str = "word"
    optional: bool = False
    meaning: str = ""
    needs: str = ""

    @property
    def allowed(self) -> str:
        """The permitted words, for messages and listings."""
        return " | ".join(self.options)

    def check(self, value: Any) -> str:
        """Return the word.

        Raises:
            ValueError: for any other value; the message names key, value and permitted words.
        """
        if not isinstance(value, str) or value not in self.options:
            raise ValueError(f"{self.key} = {shown(value)}: must be one of {self.allowed}")
        return str(value)

    parse = check


LONGEST_SHOWN = 100  # largest number of characters of a value in a message


def shown(value: Any) -> str:
    """Return any value as one short line, for messages."""
    try:
        text = reprlib.repr(value)
    except ValueError:  # Python does not convert an integer of thousands of digits to text
        text = f"<{type(value).__name__}>"
    line = " ".join(each.strip() for each in text.splitlines())
    return line if len(line) <= LONGEST_SHOWN else f"{line[:LONGEST_SHOWN]}..."


def likely_key(key: str, keys: Iterable[str], otherwise: str = "") -> str:
    """Return advice on a misspelt key: the most similar key, else ``otherwise``, by default the
    list of all keys.
    """
    known = sorted(keys)
    likely = difflib.get_close_matches(key.strip().lower().replace("-", "_"), known, n=1)
    likely = likely or [each for each in known if each.endswith(f"_{key}")]
    return (
        f"did you mean {likely[0]}?"
        if likely
        else otherwise or f"must be one of {', '.join(known)}"
    )
