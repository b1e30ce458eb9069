"""The quantities of the passes of many tools, computed at once in arrays and checked by single
simulations. A pass is the trip of one bristle past bar and workpart.

Names and units of the quantities are those of the study of a whole pass.
"""

from __future__ import annotations

import functools
import logging
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array, Number
from bristle_sim.declared import Choice, UnusualValueWarning
from bristle_sim.parameters import KEYS, Tool
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.passes.result import Ensemble
from bristle_sim.passes.strike import JAMS, MISSES, OUTCOMES, REFUSED
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings, StopReason
from bristle_sim.studies.sweep_point import FAILURE
from bristle_sim.studies.whole_pass import QUANTITIES, measures_of
from bristle_sim.units import likely_key, shown

log = logging.getLogger(__name__)

ENTRY = "entry_angle"
OUTCOME = "outcome"

CHECKED_POINTS = 8
"""Number of random points at which simulations check the vectorised passes."""

SCENE = Settings(accuracy=1e-9)
"""Settings of the simulations that check the vectorised passes. A smaller accuracy takes longer and
agrees no better."""

SIZES = {
    "contact_time": 0.0,
    "lag_deg_at_contact": np.degrees(1.0),
    "tip_speed_at_contact": 0.0,
    "normal_final_impulse": 0.0,
}
"""Quantities in which simulations and vectorised passes are compared. A difference is divided by
the quantity's magnitude, or by the value given here (in the quantity's unit) if that is larger."""

UNSTRUCK = {StopReason.JAM: OUTCOMES[JAMS], StopReason.RETRACTION_LIMIT: OUTCOMES[REFUSED]}
"""Outcome in words of a simulation that stops before a strike, by the reason of the stop."""


def unable(tool: Tool) -> str:
    """Return the reason why the vectorised computation cannot handle a tool; empty if it can."""
    if tool.contact.law != "energetic":
        return f"contact = {tool.contact.law}"
    if tool.bristle.links > 1:
        return f"wire_links = {tool.bristle.links}"
    angle = tool.bristle.knee_angle_deg
    return f"knee_angle_deg = {angle:g}" if angle else ""


def checked_range(tool: Tool, key: str, ends: Any) -> tuple[float, float]:
    """Return the lower and upper bound of a parameter's range, in SI units.

    ``ends`` are two numbers or texts with a unit, or one text ``FROM:TO``.

    Raises:
        ValueError: for an invalid parameter or range, or a tool that the vectorised computation
            cannot handle.
    """
    if reason := unable(tool):
        raise ValueError(f"{reason}: must be a straight rigid bristle with the energetic law")
    if key not in KEYS:
        raise ValueError(f"unknown key {shown(key)}; {likely_key(key, KEYS)}")
    declared = KEYS[key]
    if isinstance(declared, Choice) or declared.whole:
        raise ValueError(f"{key}: must be a key of real numbers, such as friction")
    given = ends.split(":") if isinstance(ends, str) else ends
    if not isinstance(given, list | tuple | np.ndarray) or len(given) != 2:
        raise ValueError(
            f"{key} = {shown(ends)}: must be the two ends of a range, FROM:TO, such as 0.1:0.6"
        )
    low, high = sorted(float(declared.parse(each)) for each in given)
    if low == high:
        raise ValueError(f"{key} = {shown(ends)}: must be two different ends of a range")
    return low, high


def pass_quantities(tool: Tool, settings: Settings, **values: Any) -> dict[str, NDArray[Any]]:
    """Compute the passes of many tools at once, and return their quantities as arrays, by name.

    Missing quantities are NaN. Further entries are ``outcome``, ``failure`` (the reason in words),
    and ``entry_angle``, the angle between the surface and the tip's path before the strike, rad.

    Args:
        tool: the tool that gives the values of the parameters that are not in ``values``.
        settings: requested accuracy, and the angle by which the hub turns in a pass.
        values: an array of values for each varied parameter, by name. The arrays are broadcast
            together.
    """
    options: dict[str, Any] = {"accuracy": settings.accuracy, "hub_turn": settings.hub_turn}
    many = ensemble(tool, progress=_log, **options, **values)
    found = {name: _quantity(many, name) for name in QUANTITIES if name != "rebound_ratio"}
    speed = many.keys.get("hub_speed", tool.hub.speed) + many.relative_speed_at_contact
    found["rebound_ratio"] = many.final_bristle_rate / np.where(speed == 0.0, np.nan, speed)
    return found | {ENTRY: many.entry_angle_at_contact, OUTCOME: many.outcome, FAILURE: many.reason}


def _log(part: float) -> None:
    log.info("%.0f %% of the passes finished", 100.0 * part)


def _quantity(many: Ensemble, name: str) -> Array:
    values: Array = getattr(many, name.replace("_deg", ""))
    return np.degrees(values) if "_deg" in name else values


@dataclass(frozen=True, slots=True)
class Check:
    """Agreement of the vectorised passes with passes simulated one by one.

    Attributes:
        passes: number of passes compared.
        difference: largest relative difference of a quantity.
        apart: number of passes whose outcomes differ.
    """

    passes: int
    difference: float
    apart: int

    def __str__(self) -> str:
        """Return the agreement in words, for the end of a sentence."""
        apart = f", but for {self.apart} with another outcome" if self.apart else ""
        return f"the time-domain simulation agrees to {self.difference:.0e} in {self.passes} passes{apart}"


def values_at(ranges: Mapping[str, tuple[float, float]], fractions: Number) -> dict[str, Number]:
    """Return the values of parameters at given fractions of their ranges, by name.

    Args:
        ranges: lower and upper bound of each parameter, by name.
        fractions: fraction of its range for each parameter, shape (parameters, ...).
    """
    pairs = zip(ranges.items(), fractions, strict=True)
    return {key: low + (high - low) * each for (key, (low, high)), each in pairs}


def checked_by_scene(
    tool: Tool,
    settings: Settings,
    answer: Array,
    values_of: Callable[[Array], Mapping[str, Array]],
) -> Check:
    """Compare vectorised passes with passes simulated one by one, at a given and at random points.

    The outcome, the instant of the strike, the lag, the tip speed and the normal impulse are
    compared. Differences of the last four are relative. A point is left out if the vectorised
    computation rejects its tool.

    A point is a set of fractions, from 0 (lower end) to 1 (upper end), of the ranges in which the
    parameters vary.

    Args:
        tool: the tool that gives the values of the parameters that are not varied.
        settings: settings of both computations.
        answer: the given point, shape (ranges,).
        values_of: function that takes an array of points, shape (ranges, points), and returns the
            values of the varied parameters at these points, by name.
    """
    random = np.random.default_rng(1).random((answer.size, CHECKED_POINTS))
    values = values_of(np.column_stack([answer, random]))
    found = pass_quantities(tool, settings, **values)
    compared = np.flatnonzero(found[OUTCOME] != OUTCOMES[REFUSED])
    worst = 0.0
    apart = 0
    for number in compared:
        point = {key: float(each[number]) for key, each in values.items()}
        word, measured = scene_pass(tool, settings, point)
        if word != found[OUTCOME][number]:
            apart += 1
            continue
        for name, size in SIZES.items():
            other = measured[name]
            if other is not None:
                difference = abs(float(found[name][number]) - other)
                worst = max(worst, difference / max(abs(other), size, 1e-300))
    return Check(compared.size, worst, apart)


def scene_pass(
    tool: Tool, settings: Settings, values: Mapping[str, float]
) -> tuple[str, Mapping[str, float | None]]:
    """Simulate a pass up to the strike, with the tool's parameters changed to ``values``.

    Returns:
        The outcome in words.
        The quantities of the pass, by name.
    """
    log.info("single simulations check the passes")
    try:
        with warnings.catch_warnings():  # about values that the user has not typed
            warnings.simplefilter("ignore", UnusualValueWarning)
            changed = tool.replace(**values)
        run = simulate(changed, settings, stop_after="strike")
    except ValueError:
        return OUTCOMES[REFUSED], {}
    strike = run.first_contact("workpart")
    ended = UNSTRUCK.get(run.stop_reason, OUTCOMES[MISSES])
    return ended if strike is None else strike.outcome_in_words, measures_of(changed, run)


Function = Callable[[Array], Array]
"""Function of fractions of the parameters' ranges, shape (parameters, points), that returns values at
the points."""

# Step of a fraction in a finite difference. The truncation error is about 1e-10, as large as the
# error of the passes.
DIFFERENCE = 1e-5


def with_derivatives(function: Function, step: float = DIFFERENCE) -> tuple[Function, Function]:
    """Return two functions of one point: the values of ``function``, and its derivatives.

    A coordinate of a point is a parameter as a fraction of its range. ``function`` itself takes an
    array of points. The derivatives are difference quotients between points inside the ranges, at
    most ``step`` from the given point. A derivative that is not finite is replaced by 0. The values
    have the shape (values,), the derivatives (values, parameters). One call of ``function`` gives
    values and derivatives at a point. Those of the two latest points are stored.
    """

    @functools.lru_cache(maxsize=2)
    def at(text: bytes) -> tuple[Array, Array]:
        """Return values and derivatives at the point whose coordinates have the bytes ``text``."""
        place = np.frombuffer(text)[:, np.newaxis]
        steps = step * np.eye(len(place))
        high = np.minimum(place + steps, 1.0)
        low = np.maximum(place - steps, 0.0)
        values = function(np.concatenate([place, low, high], axis=1))
        lows, highs = np.split(values[:, 1:], 2, axis=1)
        return values[:, 0], np.nan_to_num((highs - lows) / np.diagonal(high - low))

    return lambda place: at(place.tobytes())[0], lambda place: at(place.tobytes())[1]
