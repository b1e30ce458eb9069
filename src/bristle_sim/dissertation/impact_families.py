"""Families that an impact at hand belongs to: figures 2.22-2.30 with its own parameters, and what two other laws do (Zhang 2020).

Curves and points are those of the dissertation's figures. The engine's own contact settles, with more iterations, to an impact
that gains kinetic energy; the contact resolved in time approaches the rigid-body limit with the first power of plain steps.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.dissertation.impact_figures import (
    COMMON_FRICTION,
    FINAL,
    REBOUND,
    RESTITUTION,
    Case,
    Sweep,
    sweep_panel,
)
from bristle_sim.dissertation.pendulum_figures import friction_panel, rate_panel
from bristle_sim.dissertation.redrawn import Axis, Curve, Level, Mark, Panel
from bristle_sim.scene.contact.compliant import PLAIN_ACCURACY, CompliantLaw
from bristle_sim.scene.contact.laws import Coefficients, ContactLaw, EngineLaw
from bristle_sim.scene.strike import build_strike
from bristle_sim.studies.impacts import COMPLIANT_TOLERANCE, Impacts
from bristle_sim.studies.strike_point import contact_quantities

ROD = {
    "rebound ratio over the impact angle": ("rebound_ratio", REBOUND),
    "rebound ratio over friction": ("rebound_ratio", COMMON_FRICTION),
    "final impulse, by impact angle": (FINAL, COMMON_FRICTION),
    "final impulse, by restitution": (FINAL, RESTITUTION),
}
"""Quantities and sweeps of a single rod by title: figures 2.24 and 2.26, 2.22, 2.23."""

RATIOS = (2e-9, 5e11)
"""Least and largest mass ratio in the middle of curves: half the one and twice the other are the last that there are."""

ITERATIONS = np.array([1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000])
"""Iterations of the engine's solver, whose default is 10."""

STEPS = 2 ** np.arange(6, 11)
"""Plain engine steps in a contact."""

LEAST = 1e-16
"""An error of less is drawn here: a rate that is right to the last digit has no logarithm."""


def impact_families(impacts: Impacts) -> dict[str, Panel]:
    """Return the panels of an impact by title, its own values marked; none where the tip does not approach."""
    if not impacts.strikes[impacts.law].contact.impulse[0]:
        return {}
    panels = _rod_panels(impacts) if len(impacts.chain.masses) == 1 else _double_panels(impacts)
    if impacts.law == "compliant":
        panels["error of the contact resolved in time"] = convergence_panel(impacts)
    return panels


def _rod_panels(impacts: Impacts) -> dict[str, Panel]:
    """Return the families of a radial bristle or a single pendulum; no rebound ratio of a rod that is at rest on its hub."""
    own, panels = Case.of(impacts.chain, impacts.surface), {}
    for title, (quantity, sweep) in ROD.items():
        value = contact_quantities(impacts.strikes[impacts.law].contact)[quantity]
        if value is not None:
            mark = Mark(getattr(own, sweep.along), value)
            panels[title] = dataclasses.replace(sweep_panel(quantity, _through(sweep, own)), marks=(mark,))
    return panels


def _through(sweep: Sweep, own: Case) -> Sweep:
    """Return the sweep about the impact at hand, whose own value replaces the nearest one of the family."""
    high = _largest_friction(own.friction) if sweep.along == "friction" else sweep.high
    values = with_own(sweep.values, getattr(own, sweep.family))
    until_stiction = sweep.until_stiction and own.restitution_friction is None
    return dataclasses.replace(sweep, high=high, values=values, until_stiction=until_stiction, base=own)


def _largest_friction(own: float) -> float:
    """Return the friction at which curves end: 1, or 1.25 times that of the impact at hand, at most 1e9."""
    return min(max(1.0, 1.25 * own), 1e9)


def with_own(values: tuple[float, ...], own: float) -> tuple[float, ...]:
    """Return a family's values in ascending order, the nearest one replaced by that of the impact at hand."""
    nearest = min(values, key=lambda value: abs(value - own))
    return tuple(sorted({*values, own} - ({nearest} - {own})))


def _double_panels(impacts: Impacts) -> dict[str, Panel]:
    """Return rates over the mass ratio (figs. 2.28, 2.29), final impulse over friction (fig. 2.30) and the engine's energy."""
    chain, surface, found = impacts.chain, impacts.surface, impacts.strikes[impacts.law].contact
    own, friction = chain.masses[0] / chain.masses[1], surface.friction
    middle = min(max(own, RATIOS[0]), RATIOS[1])
    frictions, ratios = with_own((0.3, 0.5, 0.7), friction), (min(1.0, 0.5 * middle), max(1e4, 2.0 * middle))
    impulse = friction_panel(chain, surface, with_own((1.0, 10.0, 100.0), middle), _largest_friction(friction))
    panels = {}
    for rod, name in ((1, "first"), (2, "second")):
        panel, mark = rate_panel(chain, surface, rod, frictions, ratios), Mark(own, -found.rates_after[rod - 1])
        panels[f"rate of the {name} rod after impact"] = dataclasses.replace(panel, marks=(mark,))
    panels["final impulse over friction"] = dataclasses.replace(impulse, marks=(Mark(friction, found.impulse[0]),))
    return panels | {"energy after the engine's own contact": energy_panel(impacts)}


def energy_panel(impacts: Impacts) -> Panel:
    """Return kinetic energy after over before by the engine's own contact over its iterations, and the energetic law's."""
    energetic = impacts.strikes["energetic"].kinetic_energy_ratio
    engine = np.array([_struck(impacts, EngineLaw(int(count)))[1] for count in ITERATIONS])
    curve = Curve("energetic law", ITERATIONS, np.full(len(ITERATIONS), energetic), {"engine": (ITERATIONS, engine)})
    axes = Axis("iterations of the engine's solver", log=True), Axis("kinetic energy, after / before")
    levels = (Level(1.0, "above 1: energy created"), Level(10.0, "10: engine's default", upright=True))
    return Panel(*axes, (curve,), levels=levels, top=1.2 * max(1.2, engine.max()))


def convergence_panel(impacts: Impacts) -> Panel:
    """Return how far rates after a contact of plain steps are off the rigid-body limit, over the step.

    Where a duration was requested, they are compared with the resolved contact of that duration.
    """
    resolved, duration = impacts.strikes["compliant"], impacts.contact_duration
    limit = (impacts.strikes["energetic"] if duration is None else resolved).contact
    unit = build_strike(impacts.chain, impacts.surface)[3].time
    laws = [CompliantLaw(duration and duration / unit, PLAIN_ACCURACY, int(count)) for count in STEPS]
    rates = np.array([*(_struck(impacts, law)[0] for law in laws), resolved.contact.rates_after])
    fastest = np.abs([limit.rates_before, limit.rates_after]).max()
    *errors, own = np.maximum(np.abs(rates - limit.rates_after).max(axis=1) / fastest, LEAST)
    steps, points = 1.0 / STEPS, {"compliant": (1.0 / STEPS, np.array(errors))}
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    observed = f"observed: {order:.2f}" if max(errors) > PLAIN_ACCURACY else f"all below {PLAIN_ACCURACY:g}"
    curve = Curve(f"first order; {observed}", steps, errors[-1] * steps / steps[-1], points)
    marks = (Mark(1.0 / resolved.steps, own),) if duration is None else ()
    axes = Axis("engine step / duration of the contact", log=True), Axis("error of the rates / fastest rate", log=True)
    return Panel(*axes, (curve,), marks=marks, levels=(Level(COMPLIANT_TOLERANCE, "tolerance of the default"),))


def _struck(impacts: Impacts, law: ContactLaw) -> tuple[Array, float]:
    """Return rates after the impact by a law with settings of its own, rad/s, and kinetic energy after over before."""
    scene, start, obstacle, units = build_strike(impacts.chain, impacts.surface)
    after, record = law.resolve(scene, start, obstacle, Coefficients.of(obstacle))
    energy = scene.mechanism.kinetic_energy
    return np.array(record.rates_after) / units.time, energy(after) / energy(start)
