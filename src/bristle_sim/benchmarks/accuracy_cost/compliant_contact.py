"""The bilinear compliant contact in contact space, to be integrated by any solver of ordinary differential equations.

With the chain's mass matrix M and the Jacobian J of its tip's (normal, tangential) velocity, K = J M^-1 J^T, and in the
limit of a short contact, in which nothing but the contact acts and the chain keeps its shape,

    delta' = -v_n,    p_n' = N,    p_t' = F,    v = v(0) + K p,

with N = k delta while the tip goes in and N = (k/e*^2) (delta - (1 - e*^2) delta_max) on its way out, F = -mu sign(v_t) N
in slip, and F = -(K_nt/K_tt) N in stick. Time, impulse and depth are scaled so that k = K_nn = -v_n(0) = 1. This is the
limit to which the compliant contact of a scene tends; here it is cheaper, since no bodies move.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Surface
from bristle_sim.scene.strike import Chain
from bristle_sim.studies.impulse_course import tip_response, tip_velocity

Ends = Callable[[float, Sequence[float]], float]

LONGEST = 1e3
"""Scaled time in which a phase must end: near the jam, a phase lasts long."""

SMALL = 1e-9
"""Scaled velocities and depths below this are zero: solvers locate an event to rounding, not to nothing."""


@dataclass(frozen=True, slots=True)
class ContactPhase:
    """A smooth interval of a contact: friction (stick has none), direction of slip, and the spring's force law."""

    friction: float
    slip: float
    stiffness: float
    residual: float
    loading: bool


class TipContact:
    """A chain's contact, scaled; ``solve`` goes through its phases with a given integrator.

    Attributes:
        response: rates that a unit (normal, tangential) impulse gives the rods, shape (rods, 2), rad/s per N s.
        unit_impulse: unit of the scaled impulses, N s.
        k_nt, k_tt: entries of K over K_nn.
        v_t: tangential velocity before the contact over the speed of approach.
    """

    def __init__(self, chain: Chain, surface: Surface) -> None:
        self.chain, self.surface = chain, surface
        jacobian, response = tip_response(chain)
        inverse_mass, speeds = jacobian @ response, tip_velocity(chain)
        self.response = response / np.array(chain.lengths)[:, None]
        self.unit_impulse = -speeds[0] / float(inverse_mass[0, 0])
        (_, self.k_nt), (_, self.k_tt) = (inverse_mass / inverse_mass[0, 0]).tolist()
        self.v_t = -speeds[1] / speeds[0]

    def solve(self, follow: Callable[[TipContact, ContactPhase, list[float]], list[float]]) -> tuple[float, ...]:
        """Return rates of the rods after the contact, rad/s; ``follow`` carries (delta, p_n, p_t) to the end of a phase."""
        state, e = [0.0, 0.0, 0.0], self.surface.restitution
        phase = ContactPhase(self.surface.friction, math.copysign(1.0, self.v_t), 1.0, 0.0, loading=True)
        while True:
            state = follow(self, phase, state)
            if phase.slip and phase.slip * self.tangential(state) <= SMALL:
                # After slip has stopped: stick where friction suffices, else slip as the normal force drives it.
                sticks = phase.friction * self.k_tt >= abs(self.k_nt)
                phase = replace(phase, slip=0.0 if sticks else math.copysign(1.0, self.k_nt))
            if phase.loading and self.normal(state) >= -SMALL:
                depth = state[0]
                later = self.surface.friction_in_restitution
                phase = ContactPhase(later, phase.slip, 1.0 / e**2, depth * (1.0 - e**2), loading=False)
            elif not phase.loading and state[0] - phase.residual <= SMALL:
                break
        impulse = self.unit_impulse * np.array(state[1:])
        return tuple((np.asarray(self.chain.rates) + self.response @ impulse).tolist())

    def normal(self, state: Sequence[float]) -> float:
        """Return v_n."""
        return float(-1.0 + state[1] + self.k_nt * state[2])

    def tangential(self, state: Sequence[float]) -> float:
        """Return v_t."""
        return float(self.v_t + self.k_nt * state[1] + self.k_tt * state[2])

    def derivative(self, phase: ContactPhase) -> Callable[[float, Array], tuple[float, float, float]]:
        """Return the right-hand side within a phase, in plain floats: the fastest that Python offers a solver."""
        ratio = -phase.friction * phase.slip if phase.slip else -self.k_nt / self.k_tt
        stiffness, residual, coupling = phase.stiffness, phase.residual, self.k_nt

        def slope(_: float, state: Array) -> tuple[float, float, float]:
            """Return the derivatives of penetration, and of normal and tangential impulse."""
            depth, normal, tangential = state.tolist()
            force = stiffness * (depth - residual)
            return 1.0 - normal - coupling * tangential, force, ratio * force

        return slope

    def ends(self, phase: ContactPhase) -> list[tuple[Ends, float]]:
        """Return functions of (time, state) whose zeros end the phase, and the direction in which they cross."""
        own: tuple[Ends, float] = (lambda _, y: self.normal(y), 1.0)
        if not phase.loading:
            own = (lambda _, y: y[0] - phase.residual, -1.0)
        return [own, (lambda _, y: phase.slip * self.tangential(y), -1.0)] if phase.slip else [own]
