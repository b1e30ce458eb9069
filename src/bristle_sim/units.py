"""Declarations of parameters that are numbers or words: their checks, and the units in which they
may be typed.
"""

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
    scaled,
)
from bristle_sim.readable import plain_number

GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+(?![\d,])")
"""Pattern of a number whose thousands are grouped by commas, as in 3,000 rpm."""

FAR = 100.0  # largest factor, up or down, between a usual value and its default


@dataclass(frozen=True, slots=True)
class Range:
    """Declaration of a parameter that is a real or whole number: unit, range and source.

    Attributes:
        key: name of the parameter on the command line and in messages.
        unit: unit of the number; "1" for a pure number.
        lowest, highest: ends of the range.
        lowest_allowed: whether the range includes its lower end.
        source: source of the default.
        optional: whether the value may be None.
        meaning: meaning of the number, in words.
        usual: smallest and largest magnitude that causes no warning; None means within a factor of
            100 of the default.
        needs: condition on another key without which this key has no effect, such as ``contact =
            compliant``.
        whole: whether the number must be whole; its value is then an int.
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
        """Customary unit of the number, such as mm, and its size in the declared unit.

        The unit is "" for a pure number.
        """
        return display_unit(self.key, self.unit)

    def with_display_unit(self, text: str) -> str:
        """Add the customary unit to a typed number that has no unit: ``30`` becomes ``30 mm``.

        The result can be passed to :meth:`parse`.
        """
        typed = TYPED.fullmatch(text.strip())
        bare = typed is not None and not typed["unit"]
        return f"{text.strip()} {self.display[0]}".rstrip() if bare else text

    def parse(self, text: Any) -> float:
        """Return the value of a typed number in the declared unit, after a check of its range.

        A number with a unit, such as ``27mm``, is converted. A number without a unit is taken to be
        in the declared unit. A value that is no text is checked alone.

        Raises:
            ValueError: in one line, if the text is no decimal number, its unit has another
                dimension, or its value is out of range.
        """
        if not isinstance(text, str):
            return self.check(text)
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
        """Return a value after a check of its range, as a float, or as an int if it must be whole.

        A negative zero becomes 0.

        Args:
            value: value in the declared unit.
            typed: text from which the value was read; the message then shows this text.

        Raises:
            ValueError: if the value is no number or out of range; the message names key, value,
                range and unit.
        """
        if isinstance(value, bool) or not isinstance(value, Real):
            raise self.refusal(value)
        try:
            number = float(value)
        except OverflowError:
            number = -math.inf if value < 0 else math.inf
        except TypeError:  # NumPy's durations count as whole numbers, but are not numbers
            raise self.refusal(value) from None
        if not self._holds(number):
            raise self.refusal(
                number if typed is None else typed, self._likely_display_unit(number, typed)
            )
        return int(number) if self.whole else number + 0.0

    def _holds(self, number: float) -> bool:
        """Return whether a number is in the range, and whole where it must be."""
        above = number >= self.lowest if self.lowest_allowed else number > self.lowest
        whole = not self.whole or number.is_integer()
        return above and number <= self.highest and math.isfinite(number) and whole

    def _likely_display_unit(self, number: float, typed: str | None) -> str:
        """Return a hint that a refused number may have been meant in the customary unit.

        It is empty if the number does not lie in the range with that unit either. For example, 27
        for a length in m may have been meant in mm.
        """
        size = self.display[1]
        bare = typed or f"{number:g}"
        fits = size < 1.0 and self._holds(scaled(number, size))
        meant = self.with_display_unit(bare)
        return f"; did you mean {meant}?" if fits and meant != bare else ""

    def refusal(self, value: Any, why: str = "") -> ValueError:
        """Return the ValueError for a refused value; ``why`` ends its message."""
        unit = "dimensionless" if self.unit == "1" else f"in {self.unit}"
        rule = self.allowed if self.whole else f"finite number with {self.allowed}"
        return ValueError(
            f"{self.key} = {shown(value)}: must be a {rule} ({unit}{' '.join(why.split())})"
        )


def displayed(declared: Any, value: Any) -> str:
    """Return the value of a parameter as text with five digits in its customary unit, for example
    ``27 mm``.

    ``declared`` is the parameter's declaration.
    """
    if value is None or isinstance(value, str) or declared.whole:
        return "none" if value is None else str(value)
    unit, size = declared.display
    return f"{plain_number(value / size, 5)} {unit}".rstrip()


def displayed_range(declared: Any) -> str:
    """Return the range of a parameter in its customary unit, or its permitted words, for listings.

    ``declared`` is the parameter's declaration.
    """
    if not isinstance(declared, Range) or declared.whole:
        return str(declared.allowed)
    low, high = (
        plain_number(end / declared.display[1], 5) for end in (declared.lowest, declared.highest)
    )
    return f"{low} {'<=' if declared.lowest_allowed else '<'} {declared.key} <= {high}"


def unusual_value(declared: Any, default: Any, value: Any, given: Any) -> str:
    """Return a warning that a value is unusual; empty for a usual value.

    If the number may have been meant in another unit, the warning says so.

    Args:
        declared: declaration of the parameter.
        default: default of the parameter.
        value: value in the declared unit.
        given: value as it was typed or passed.
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
        given if isinstance(given, str) else f"{float(given):g}",
        default or math.sqrt(least * most),
    )
    return f"{declared.key} = {value:.6g}{unit}{ratio}{meant}"


def _meant_unit(declared: Range, text: str, typical: float) -> str:
    """Return a hint to another unit in which a number without a unit may have been meant.

    In that unit the number lies within a factor of ten of a typical value. The hint is empty if
    there is no such unit.
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
    """Declaration of a parameter whose value is one of a few words."""

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
        """Return a value after a check that it is one of the permitted words.

        Raises:
            ValueError: for any other value; the message names key, value and permitted words.
        """
        if not isinstance(value, str) or value not in self.options:
            raise ValueError(f"{self.key} = {shown(value)}: must be one of {self.allowed}")
        return str(value)

    parse = check


LONGEST_SHOWN = 100  # largest number of characters of a value in a message


def shown(value: Any) -> str:
    """Return any Python value as one short line of text, for messages."""
    try:
        text = reprlib.repr(value)
    except ValueError:  # Python does not convert an integer of thousands of digits to text
        text = f"<{type(value).__name__}>"
    line = " ".join(each.strip() for each in text.splitlines())
    return line if len(line) <= LONGEST_SHOWN else f"{line[:LONGEST_SHOWN]}..."


def likely_key(key: str, keys: Iterable[str], otherwise: str = "") -> str:
    """Return advice on a misspelt key, for messages.

    Args:
        key: the misspelt key.
        keys: all known keys.
        otherwise: advice if no known key is similar; by default the list of all known keys.
    """
    known = sorted(keys)
    likely = difflib.get_close_matches(key.strip().lower().replace("-", "_"), known, n=1)
    likely = likely or [each for each in known if each.endswith(f"_{key}")]
    return (
        f"did you mean {likely[0]}?"
        if likely
        else otherwise or f"must be one of {', '.join(known)}"
    )
