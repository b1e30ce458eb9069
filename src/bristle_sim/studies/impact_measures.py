"""What is read off an impact: the same number by closed form, and from a simulated contact.

A rod stands for the bristle on its hub and, with a hub of no radius, for Stronge's single pendulum.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from bristle_sim.parameters import Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.theory import monofilament
from bristle_sim.theory.pendulums import DoublePendulumImpact, double_pendulum_impact
from bristle_sim.trajectory import ContactRecord

__all__ = ["IMPULSE", "REBOUND", "ROD_IMPULSE", "Measure", "closed_form", "final_rate"]


@dataclass(frozen=True, slots=True)
class Measure:
    """One number of an impact: by closed form, and as read from a simulated one."""

    formula: Callable[[Chain, Surface], float]
    read: Callable[[Chain, ContactRecord], float]


def final_rate(rod: int) -> Measure:
    """Rate of a double pendulum's first (0) or second (1) rod after impact, rad/s, negative approaching."""
    name = f"final_rate_{rod + 1}"
    return Measure(
        lambda chain, surface: float(getattr(closed_form(chain, surface), name)),
        lambda _, contact: -contact.rates_after[rod],
    )


def closed_form(chain: Chain, surface: Surface) -> DoublePendulumImpact:
    """The double pendulum's closed form, its rates signed as in the dissertation."""
    return double_pendulum_impact(
        rod_mass=chain.masses[1],
        mass_ratio=chain.masses[0] / chain.masses[1],
        rod_length=chain.lengths[1],
        angle_1=-chain.angles[0],
        angle_2=-chain.angles[1],
        rate_1=-chain.rates[0],
        rate_2=-chain.rates[1],
        friction=surface.friction,
        restitution=surface.restitution,
        restitution_friction=surface.friction_in_restitution,
    )


def _rod_rebound(rod: Chain, surface: Surface) -> float:
    """Eqs. 2.43 and 2.48 over the rate before; with r_h = 0 that of fig. 2.26."""
    if rod.rates[0] == 0.0:
        raise ValueError("rate = 0: another rate than 0 is allowed where a rebound ratio is asked for (in rad/s)")
    hub = (rod.lengths[0], rod.hub_radius, rod.hub_speed)
    rate = monofilament.final_rate(
        _speed(rod), *hub, -rod.angles[0], surface.friction, surface.restitution, surface.friction_in_restitution
    )
    return float(rate) / rod.rates[0]


def _rod_impulse(rod: Chain, surface: Surface) -> float:
    """Eq. 2.48."""
    coefficients = (surface.friction, surface.restitution, surface.friction_in_restitution)
    return float(monofilament.normal_final_impulse(rod.masses[0], _speed(rod), -rod.angles[0], *coefficients))


def _speed(rod: Chain) -> float:
    """v_C (2.24), m/s."""
    return rod.lengths[0] * rod.rates[0] + rod.hub_radius * rod.hub_speed


REBOUND = Measure(_rod_rebound, lambda rod, contact: contact.rates_after[0] / rod.rates[0])
"""Rate of a rod after over before the impact."""

ROD_IMPULSE = Measure(_rod_impulse, lambda _, contact: contact.impulse[0])
"""p_f of a rod, N s."""

IMPULSE = Measure(
    lambda chain, surface: closed_form(chain, surface).normal_final_impulse, lambda _, contact: contact.impulse[0]
)
"""p_f of a double pendulum, N s."""
