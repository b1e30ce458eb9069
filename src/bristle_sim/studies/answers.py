"""Text of an answer: numbers in readable units, and the quantities that differ most from the formulas and from print."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bristle_sim.comparison import Quantity, readable_unit

LEAST_SIZE = 1e-12
"""Reference values below this, in SI units, count as zero; no relative difference from them is computed."""

RADIAL = 0.005
"""Lag in degrees below which a bristle counts as radial in words: half a unit of the last digit that is shown."""


def amount(value: float, unit: str, digits: int = 3) -> str:
    """Return a number with its unit, prefixed as an engineer writes it: ``2.75 mN s``."""
    shown, factor = readable_unit(unit, [value])
    separator = "" if shown == "deg" else " "
    return f"{value / factor:.{digits}g}{separator}{'' if shown == '1' else '°' if shown == 'deg' else shown}".strip()


def most_different(quantities: Iterable[Quantity], side: str, word: str) -> str:
    """Return the quantity whose simulated value is relatively farthest from a side, with both: ``x 3 N, printed 4 N``.

    Empty where no quantity has both values.
    """
    pairs = [(each, each.simulated, getattr(each, side)) for each in quantities]
    known = [(each, one, other) for each, one, other in pairs if one is not None and other and abs(other) > LEAST_SIZE]
    if not known:
        return ""
    each, one, other = max(known, key=lambda row: abs(row[1] / row[2] - 1.0))
    return f"{each.label} {amount(one, each.unit)}, {word} {amount(other, each.unit)}"


def differences(quantities: Sequence[Quantity]) -> str:
    """Return a sentence on the largest differences from the formulas and from print; empty if there is nothing to compare."""
    sides = (("theory", "by formula"), ("printed", "printed"))
    found = list(dict.fromkeys(filter(None, (most_different(quantities, *each) for each in sides))))
    return f" What differs most: {'; '.join(found)}." if found else ""


def agreement(quantities: Sequence[Quantity]) -> str:
    """Return whether the simulated values follow the closed forms: ``Yes, to 2e-16``, or the one that differs most."""
    judged = [each for each in quantities if each.ok is not None]
    missed = [each for each in judged if not each.ok]
    if judged and not missed:
        worst = max(abs(each.relative_difference or 0.0) for each in judged)
        return f"Yes, to {worst:.0e}" if worst else "Yes, to the last digit"
    differing = most_different(missed or quantities, "theory", "by formula")
    return f"{'No' if missed else 'Not exactly'} ({differing})" if differing else "There is no closed form"


def beside_radial(lag: float) -> str:
    """Return a lag in degrees in words: ``2.74° short of radial``."""
    if abs(lag) < RADIAL:
        return "radial"
    return f"{amount(abs(lag), 'deg')} {'beyond' if lag < 0.0 else 'short of'} radial"
