"""A sweep in sentences: how quantities run over one key or two, where the outcome changes, which
points lack results."""

from collections.abc import Sequence

import numpy as np

from bristle_sim.conversion import display_unit, plain_number
from bristle_sim.readable import amount
from bristle_sim.studies.scenario_sweep import Swept

FIRST = ("tip_speed_at_contact", "normal_final_impulse", "lag_deg_at_contact")
"""Quantities that come before others."""

NAMED = 3  # quantities that an answer names


def sweep_in_words(found: Swept, chosen: Sequence[str]) -> str:
    """Return how the first quantities run, where the outcome changes, why points lack results, and
    what the scene says."""
    over = " and ".join(
        f"{key} from {shown_value(found, key, values[0])} to {shown_value(found, key, values[-1])}"
        for key, values in found.axes.items()
    )
    points = f"Over {over} ({' x '.join(str(len(each)) for each in found.axes.values())} points)"
    run = _along if len(found.axes) == 1 else _between
    parts = [run(found, name) for name in chosen[:NAMED] if np.isfinite(found.values[name]).any()]
    if not parts:
        parts = ["no quantity changes"]
    if found.outcome is not None:
        parts.append(_outcomes(found))
    reasons, numbers = np.unique(found.failure[found.failure != ""].astype(str), return_counts=True)
    parts += [
        f"{number} points lack results: {reason.rstrip('.')}"
        for reason, number in zip(reasons.tolist(), numbers.tolist(), strict=True)
    ][:NAMED]
    return f"{points} {'; '.join([*parts, *filter(None, [found.check])])}."


def shown_value(found: Swept, name: str, value: float) -> str:
    """Return a value with its unit, of a key with the one in which it is displayed."""
    if name in found.axes:
        unit, size = display_unit(name, found.units[name])
        return f"{plain_number(float(value) / size, 4)} {unit}".rstrip()
    return amount(float(value) + 0.0, found.units[name], 4)


def _along(found: Swept, name: str) -> str:
    """Return how a quantity runs over the key: it rises, falls, or has its extremes within."""
    (key,) = found.axes
    values = found.values[name]
    known = np.flatnonzero(np.isfinite(values))
    first, last = values[known[0]], values[known[-1]]
    changes = np.diff(values[known])
    if name not in found.changing:
        return f"the {found.labels.get(name, name)} stays {shown_value(found, name, first)}"
    ends = f"from {shown_value(found, name, first)} to {shown_value(found, name, last)}"
    label = found.labels.get(name, name)
    if (changes >= 0.0).all() or (changes <= 0.0).all():
        return f"the {label} {'rises' if last > first else 'falls'} {ends}"
    low, high = (known[each(values[known])] for each in (np.argmin, np.argmax))
    places = [
        f"{shown_value(found, name, values[at])} at {shown_value(found, key, found.axes[key][at])}"
        for at in (low, high)
    ]
    return f"the {label} is lowest, {places[0]}, and highest, {places[1]}"


def _between(found: Swept, name: str) -> str:
    values = found.values[name]
    ends = [shown_value(found, name, each(values)) for each in (np.nanmin, np.nanmax)]
    return f"the {found.labels.get(name, name)} lies between {ends[0]} and {ends[1]}"


def _outcomes(found: Swept) -> str:
    """Return the outcomes along the key, with the values from which they hold, or their parts of a
    map."""
    assert found.outcome is not None
    words = found.outcome.ravel()
    if len(found.axes) > 1:
        kinds, numbers = np.unique(words, return_counts=True)
        order = np.argsort(-numbers)
        parts = [f"{kinds[each]} in {100.0 * numbers[each] / words.size:.3g} %" for each in order]
        return f"the tip {', '.join(parts)} of them"
    (key,) = found.axes
    starts = [0, *(np.flatnonzero(words[1:] != words[:-1]) + 1).tolist()]
    parts = [f"{words[0]}"]
    parts += [
        f"then {words[at]} from {shown_value(found, key, found.axes[key][at])}" for at in starts[1:]
    ]
    if len(parts) > 2 * NAMED:
        parts = [*parts[:NAMED], f"changes {len(starts) - NAMED} more times"]
    return f"the tip {', '.join(parts)}"


def constants_in_words(found: Swept) -> list[str]:
    """Return the quantities that do not change, with their values."""
    shown = []
    for name, values in found.known.items():
        if name not in found.changing:
            value = float(values[np.isfinite(values)][0])
            shown.append(f"{found.labels.get(name, name)} {amount(value, found.units[name], 5)}")
    return shown
