"""The result of an impact at one point: impulses, velocities, phases, works and the outcome."""

from __future__ import annotations

from dataclasses import dataclass

from bristle_sim.arrays import Number

NO_CONTACT, REBOUND, NO_REBOUND, STICTION, JAM = range(5)
OUTCOMES = ("no contact", "rebound", "no rebound", "stiction", "jam")
"""What an outcome code means.

``no contact``: the point does not approach. ``rebound``: restitution ends with v_n > 0. ``no rebound``: e = 0, or
what restitution has to give is spent with v_n = 0, in slip at rest (Poisson's impulse) or below the smallest float.
``stiction``: compression ends, but no impulse can part the point from the surface again (the jam of one degree of
freedom, mu >= tan gamma). ``jam``: the point sticks before compression ends and no impulse can end it; the rigid-body
law has no solution.
"""

PHASES = ("compression", "compression after slip", "restitution", "restitution after slip")
"""The four phases an impact can have; one that does not occur has a normal impulse of zero."""


@dataclass(frozen=True, slots=True)
class Impact:
    """Result of an impact; each entry is a float, or an array of the broadcast shape.

    Impulses act on the moving point; normal ones are positive, works are those of the impulse on the bodies.

    Attributes:
        impulse_normal, impulse_tangential: p_f, N s.
        velocity_normal, velocity_tangential: after the impact, m/s.
        compressive_impulse_normal, compressive_impulse_tangential: p_c, at the end of compression, N s.
        slip_stop_impulse: p_s, normal impulse at which the initial slip stops, N s; inf if it does not.
        phase_impulse: normal impulse of each of PHASES, shape (..., 4), N s.
        phase_slip: direction of slip in each of PHASES, -1, 0 (stick) or 1, shape (..., 4).
        phase_work_normal, phase_work_tangential: works in each of PHASES, shape (..., 4), J.
        outcome: index into OUTCOMES.
    """

    impulse_normal: Number
    impulse_tangential: Number
    velocity_normal: Number
    velocity_tangential: Number
    compressive_impulse_normal: Number
    compressive_impulse_tangential: Number
    slip_stop_impulse: Number
    phase_impulse: Number
    phase_slip: Number
    phase_work_normal: Number
    phase_work_tangential: Number
    outcome: Number

    @property
    def compressive_work(self) -> tuple[Number, Number]:
        """Return normal (W_c, negative) and tangential work of compression, J."""
        return self._works(0)

    @property
    def restitutive_work(self) -> tuple[Number, Number]:
        """Return normal (W_r, positive) and tangential work of restitution, J."""
        return self._works(2)

    def _works(self, first: int) -> tuple[Number, Number]:
        normal, tangential = self.phase_work_normal, self.phase_work_tangential
        return normal[..., first] + normal[..., first + 1], tangential[..., first] + tangential[..., first + 1]

    @property
    def energy_change(self) -> Number:
        """Change of the bodies' kinetic energy, the sum of all works, J."""
        return self.phase_work_normal.sum(axis=-1) + self.phase_work_tangential.sum(axis=-1)

    @property
    def outcome_name(self) -> str:
        """Return the outcome of a single impact in words."""
        return OUTCOMES[int(self.outcome)]

    @property
    def phases(self) -> tuple[str, ...]:
        """Return the phases of a single impact in order, e.g. ``("compression slip", "restitution reverse slip")``."""
        slips = self.phase_slip.tolist()
        names = []
        for name, impulse, slip in zip(PHASES, self.phase_impulse.tolist(), slips, strict=True):
            if impulse > 0.0:
                motion = "stick" if slip == 0.0 else "reverse slip" if slip == -slips[0] else "slip"
                names.append(f"{name.split()[0]} {motion}")
        return tuple(names)
