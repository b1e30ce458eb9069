"""Declared, checked fields for frozen parameter objects.

A physical parameter is declared once, with its default, unit, allowed range and source. The declaration validates
every value that enters a parameter object and is what the scenario scripts list and parse.
"""

from __future__ import annotations

import dataclasses
import math
import reprlib
from dataclasses import dataclass, field
from numbers import Real
from typing import Any

__all__ = ["Choice", "Range", "check", "choice", "declaration", "quantity", "shown", "validate"]


@dataclass(frozen=True, slots=True)
class Range:
    """A real number with a unit and an allowed range; ``optional`` ones may be None."""

    key: str
    unit: str
    lowest: float
    highest: float
    lowest_allowed: bool
    source: str
    optional: bool = False

    @property
    def allowed(self) -> str:
        """The allowed range in words, for messages and listings."""
        sign = "<=" if self.lowest_allowed else "<"
        return f"{self.lowest:g} {sign} {self.key} <= {self.highest:g}"

    def parse(self, text: str) -> float:
        """Turn a typed decimal number into a checked value; raises ValueError in one line."""
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        # float() also takes grouped digits and those of other scripts, which nobody types on purpose here.
        if "_" in text or not text.isascii() or not self._admits(number):
            raise self.refusal(text)
        return number + 0.0

    def check(self, value: Any) -> float:
        """Return the value as a float, or raise ValueError naming key, value, range and unit."""
        if isinstance(value, bool) or not isinstance(value, Real):
            raise self.refusal(value)
        try:
            number = float(value)
        except OverflowError:
            number = -math.inf if value < 0 else math.inf
        if not self._admits(number):
            raise self.refusal(number)
        return number + 0.0  # no negative zero

    def _admits(self, number: float) -> bool:
        above = number >= self.lowest if self.lowest_allowed else number > self.lowest
        return math.isfinite(number) and above and number <= self.highest

    def refusal(self, value: Any) -> ValueError:
        """What to raise for a value that is not allowed."""
        unit = "dimensionless" if self.unit == "1" else f"in {self.unit}"
        return ValueError(f"{self.key} = {shown(value)}: a finite number with {self.allowed} is allowed ({unit})")


@dataclass(frozen=True, slots=True)
class Choice:
    """One word out of a few."""

    key: str
    options: tuple[str, ...]
    source: str
    unit: str = "word"
    optional: bool = False

    @property
    def allowed(self) -> str:
        """The allowed words, for messages and listings."""
        return " | ".join(self.options)

    def parse(self, text: str) -> str:
        """Turn typed text into a checked word."""
        return self.check(text)

    def check(self, value: Any) -> str:
        """Return the word, or raise ValueError naming key, value and the allowed words."""
        if not isinstance(value, str) or value not in self.options:
            raise ValueError(f"{self.key} = {shown(value)}: one word of {self.allowed} is allowed")
        return str(value)


LONGEST_SHOWN = 100
"""Characters of a value in a message."""


def shown(value: Any) -> str:
    """Any value whatsoever in one short line, for messages."""
    try:
        text = reprlib.repr(value)
    except ValueError:  # a whole number of thousands of digits, which Python does not write out
        text = f"<{type(value).__name__}>"
    line = " ".join(each.strip() for each in text.splitlines())
    return line if len(line) <= LONGEST_SHOWN else f"{line[:LONGEST_SHOWN]}..."


def quantity(
    default: float | None,
    key: str,
    unit: str,
    *,
    above: float | None = None,
    at_least: float | None = None,
    at_most: float,
    source: str,
) -> Any:
    """Declare a dataclass field that holds a real number; ``above`` excludes its bound, ``at_least`` includes it.

    A default of None makes the parameter optional.
    """
    if (above is None) == (at_least is None):
        raise ValueError(f"{key}: declare exactly one of above and at_least")
    lowest = above if above is not None else at_least
    assert lowest is not None
    declared = Range(key, unit, lowest, at_most, at_least is not None, source, optional=default is None)
    return field(default=default, metadata={"declaration": declared})


def choice(default: str, key: str, options: tuple[str, ...], *, source: str) -> Any:
    """Declare a dataclass field that holds one word out of a few."""
    return field(default=default, metadata={"declaration": Choice(key, options, source)})


def declaration(owner: Any, name: str) -> Range | Choice:
    """The declaration of one field of a parameter class or object."""
    for each in dataclasses.fields(owner):
        if each.name == name:
            found = each.metadata["declaration"]
            assert isinstance(found, Range | Choice)
            return found
    raise AttributeError(f"{owner!r} declares no field {name!r}")


def check(owner: Any, name: str, value: Any) -> Any:
    """Check one value against the declaration of a field."""
    declared = declaration(owner, name)
    return None if value is None and declared.optional else declared.check(value)


def validate(instance: Any) -> None:
    """Check every declared field of a frozen dataclass instance and store it as a plain float or word."""
    for each in dataclasses.fields(instance):
        if "declaration" in each.metadata:
            checked = check(instance, each.name, getattr(instance, each.name))
            object.__setattr__(instance, each.name, checked)
