"""Tools of every size: lengths, masses and times scaled, and the same dimensionless motion expected.

With lengths times l, masses times m and times times t, a speed of rotation goes as 1/t, a belt's stiffness as m l^2/t^2 and
gravity as l/t^2. Scaled by powers of two nothing is rounded, so that not a bit may differ; otherwise rounding may tip the
choice of a step, which changes the result by its error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, same_bits, within, worst
from bristle_sim.parameters import RETRACTION_AT_RELEASE, Bristle, Contact, Surface, Tool
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = ["Scale", "cases", "dimensionless", "scaled"]

THEME = "size"

LIMIT = 1e-9
"""Of what differs after scaling, relative."""

ACCURACY = 1e-10
"""Asked for, so that the choice of a step does not show."""

RELEASE = 1e-6
"""The same for the end of a hold, where a force vanishes at a thousandth of the slope that motion has."""

WORTH = 1e-2
"""Impacts slower than this share of the fastest are the last of ever smaller taps, the sum of many errors."""


@dataclass(frozen=True, slots=True)
class Scale:
    """Factors of lengths, masses and times."""

    length: float
    mass: float
    time: float

    @property
    def impulse(self) -> float:
        """Of impulses."""
        return self.mass * self.length / self.time

    @property
    def energy(self) -> float:
        """Of energies, torques and torsional stiffness."""
        return self.mass * (self.length / self.time) ** 2


def _bristle(length: float, mass: float, time: float) -> Scale:
    """The scale that gives the default's bristle this length in m and mass in kg."""
    return Scale(length / Bristle().length, mass / Bristle().mass, time)


SCALES = {
    "1 um, 1e-12 kg": _bristle(1e-6, 1e-12, 1e-3),
    "10 m, 1e3 kg": _bristle(10.0, 1e3, 30.0),
    "1 um, 1e3 kg": _bristle(1e-6, 1e3, 1e3),
    "10 m, 1e-12 kg": _bristle(10.0, 1e-12, 30.0),
    "1 nm, 1e-30 kg": _bristle(1e-9, 1e-30, 1e-3),
    "500 m, 9e5 kg": _bristle(500.0, 9e5, 1e4),
}
"""The times keep belt stiffness, hub speed, gravity and contact duration within what is allowed."""

POWERS = {
    "0.82 um, 1.2e-12 kg": Scale(2.0**-15, 2.0**-26, 2.0**-8),
    "14 m, 1.4e3 kg": Scale(2.0**9, 2.0**24, 2.0**5),
}

TOOL = Tool(gravity=3e3)
"""With gravity nearly as strong as the tip's centrifugal acceleration, so that it shows."""

CONTACTS = {
    "": Contact(),
    ", in time": Contact("compliant"),
    ", engine's contact": Contact("engine"),
}

IN_TIME = Contact("compliant", duration=1e-5)

RODS = Chain((5.0, 5.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (100.0, 200.0))
"""Two rods of which the tip's slip reverses."""

HIT = Surface(0.5, None, 0.5)
"""What they strike."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Pass, strike and flight: to the last bit for powers of two, to rounding for bristles of 1 um and 10 m."""
    sizes, powers = list(SCALES.items()), list(POWERS.items())
    if not full:
        sizes, powers = sizes[:2], powers[:1]
    return (
        *(_pass_bits(size, scale, word) for size, scale in powers for word in CONTACTS),
        *(_flight_and_strike_bits(size, scale) for size, scale in powers),
        *(_to_rounding(size, scale, what) for size, scale in sizes for what in MEASURES),
    )


def _times(part: Any, **factors: float) -> Any:
    """A part with some of its numbers multiplied; None stays None."""
    values = {name: getattr(part, name) for name in factors}
    return replace(part, **{name: value and value * factors[name] for name, value in values.items()})


def scaled(tool: Tool, scale: Scale) -> Tool:
    """The similar tool."""
    length, time = scale.length, scale.time
    return Tool(
        hub=_times(tool.hub, speed=1.0 / time, radius=length),
        belt=_times(tool.belt, stiffness=scale.energy),
        bristle=_times(tool.bristle, length=length, mass=scale.mass, wire_diameter=length),
        bar=tool.bar and _times(tool.bar, radius=length, horizontal=length, vertical=length),
        workpart=tool.workpart and _times(tool.workpart, penetration=length),
        contact=_times(tool.contact, duration=time),
        gravity=tool.gravity * length / time**2,
    )


def _chain(scale: Scale) -> Chain:
    return replace(
        RODS,
        masses=tuple(each * scale.mass for each in RODS.masses),
        lengths=tuple(each * scale.length for each in RODS.lengths),
        rates=tuple(each / scale.time for each in RODS.rates),
    )


def dimensionless(run: Trajectory, scale: Scale) -> dict[str, Any]:
    """Everything that a run says, in units of its scale, as plain numbers."""
    found: dict[str, Any] = {
        "time": run.time / scale.time,
        "angles": run.angles,
        "rates": run.rates * scale.time,
        "tip": run.tip / scale.length,
        "kinetic": run.kinetic_energy / scale.energy,
        "potential": run.potential_energy / scale.energy,
        "force": run.normal_force / scale.impulse * scale.time,
        "events": [(event.name, event.time / scale.time) for event in run.events],
        "contacts": _impacts(run.contacts, scale),
        "stop_reason": run.stop_reason,
    }
    return {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in found.items()}


UNITY = Scale(1.0, 1.0, 1.0)

TO_THE_BIT = "the default's to the last bit"


def _pass_bits(size: str, scale: Scale, word: str) -> HardCase:
    tool = replace(TOOL, contact=CONTACTS[word])
    return HardCase(THEME, f"{size}: whole pass{word}", TO_THE_BIT, partial(_same, tool, scale))


def _same(tool: Tool, scale: Scale) -> Finding:
    runs = [simulate(scaled(tool, each)) for each in (UNITY, scale)]
    first, second = (dimensionless(run, each) for run, each in zip(runs, (UNITY, scale), strict=True))
    return same_bits(first, second, "all samples, events, contacts", runs[1].cost.steps)


def _flight_and_strike_bits(size: str, scale: Scale) -> HardCase:
    return HardCase(THEME, f"{size}: flight, two rods' strike", TO_THE_BIT, partial(_same_flight_and_strike, scale))


def _same_flight_and_strike(scale: Scale) -> Finding:
    runs = [dimensionless(_flown(each), each) for each in (UNITY, scale)]
    hits = [_impacts([_struck(each, Contact())], each) for each in (UNITY, scale)]
    return same_bits((runs[0], hits[0]), (runs[1], hits[1]), "all samples and the contact")


def _flown(scale: Scale) -> Trajectory:
    tool = scaled(replace(TOOL, bar=None, workpart=None), scale)
    return simulate(tool, Settings(accuracy=ACCURACY), start_relative_angle=-RETRACTION_AT_RELEASE)


def _struck(scale: Scale, contact: Contact) -> ContactRecord:
    return strike(_chain(scale), HIT, _times(contact, duration=scale.time), Settings(accuracy=ACCURACY)).contact


def _to_rounding(size: str, scale: Scale, what: str) -> HardCase:
    promise = f"the default's after scaling to {LIMIT:g}"
    if what == "whole pass":
        promise += f", the bar's release to {RELEASE:g}"
    return HardCase(THEME, f"{size}: {what}", promise, partial(MEASURES[what], scale))


def _passes(scale: Scale) -> Finding:
    """A whole pass: impacts, the bar's hold, and the end."""
    run, other = (simulate(scaled(TOOL, each), Settings(accuracy=ACCURACY)) for each in (scale, UNITY))
    late = _release(run) / scale.time / _release(other) - 1.0
    return both(
        within(_difference(_figures(run, scale), _figures(other, UNITY)), LIMIT, "off by", run.cost.steps),
        within(late, RELEASE, "release by"),
    )


def _release(run: Trajectory) -> float:
    """When the bar's hold ended, s."""
    held = next(each for each in run.contacts if each.law == "hold" and each.obstacle == "bar")
    return held.time + held.duration


def _flies(scale: Scale) -> Finding:
    run, other = _flown(scale), _flown(UNITY)
    figures = [_figures(run, scale), _figures(other, UNITY)]
    for found, each, unit in zip(figures, (run, other), (scale, UNITY), strict=True):
        found["words"] = [event.name for event in each.events]
        found["event times"] = [event.time / unit.time for event in each.events]
    return within(_difference(*figures), LIMIT, "off by", run.cost.steps)


def _struck_in_time(scale: Scale) -> Finding:
    tool = replace(TOOL, contact=IN_TIME)
    run, other = (
        simulate(scaled(tool, each), Settings(accuracy=ACCURACY), stop_after="strike") for each in (scale, UNITY)
    )
    return within(_difference(_figures(run, scale), _figures(other, UNITY)), LIMIT, "off by", run.cost.steps)


def _rods_strike(scale: Scale) -> Finding:
    """By every law."""
    off = []
    for contact in (Contact(), Contact("engine"), IN_TIME):
        pair = [_impacts([_struck(each, contact)], each) for each in (scale, UNITY)]
        off.append(_difference(*pair))
    return within(worst(off), LIMIT, "off by")


MEASURES: dict[str, Callable[[Scale], Finding]] = {
    "whole pass": _passes,
    "flight": _flies,
    "strike in time": _struck_in_time,
    "two rods' strike": _rods_strike,
}

Figures = dict[str, Any]
"""Words, and lists of numbers of one kind."""


def _figures(run: Trajectory, scale: Scale) -> Figures:
    """Impacts but for the last of ever smaller taps, and the end; dimensionless."""
    hits = [each for each in run.contacts if each.law != "hold"]
    fastest = max((-each.velocity_before[0] for each in hits), default=0.0)
    found = _impacts([each for each in hits if -each.velocity_before[0] > WORTH * fastest], scale)
    found["words"].append(run.stop_reason)
    found["times"].append(float(run.time[-1]) / scale.time)
    found["angles"] += [float(run.relative_angle[0]), float(run.relative_angle[-1])]
    found["rates"].append(float(run.rates[-1, 0]) * scale.time)
    found["tip"] = (run.tip[-1] / scale.length).tolist()
    found["energies"] = [float(each[-1]) / scale.energy for each in (run.kinetic_energy, run.potential_energy)]
    return found


def _impacts(hits: Sequence[ContactRecord], scale: Scale) -> Figures:
    velocity = scale.length / scale.time
    return {
        "words": [(each.obstacle, each.outcome, each.phases) for each in hits],
        "times": [each.time / scale.time for each in hits],
        "durations": [each.duration / scale.time for each in hits],
        "angles": [angle for each in hits for angle in each.angles],
        "rates": [rate * scale.time for each in hits for rate in (*each.rates_before, *each.rates_after)],
        "impulses": [part / scale.impulse for each in hits for part in each.impulse],
        "velocities": [part / velocity for each in hits for part in (*each.velocity_before, *each.velocity_after)],
        "works": [part / scale.energy for each in hits for part in each.compressive_work or ()],
    }


def _difference(one: Figures, two: Figures) -> float:
    """The largest difference over the largest number of its kind; NaN where words or numbers of numbers differ."""
    if one["words"] != two["words"] or any(len(one[kind]) != len(two[kind]) for kind in two):
        return math.nan
    off = [0.0]
    for kind in two.keys() - {"words"}:
        size = max(map(abs, two[kind]), default=0.0) or 1.0
        off += [(a - b) / size for a, b in zip(one[kind], two[kind], strict=True)]
    return worst(off)
