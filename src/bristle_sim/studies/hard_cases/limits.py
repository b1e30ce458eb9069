"""Coefficients at the ends of their ranges: restitution 0 and 1, friction 0 and huge."""

from __future__ import annotations

import math
from functools import partial

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.hard_cases.case import Finding, HardCase, both, within

__all__ = ["cases"]

THEME = "limits"

RODS = Chain((5.0, 5.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))
"""Two rods that slip, stick or reverse, as friction is small or large."""

FRICTIONS = (0.0, 0.3, 1e6)


def cases(full: bool) -> tuple[HardCase, ...]:
    """Both rods against a surface with each coefficient at both its ends."""
    del full
    return (
        *(
            HardCase(
                THEME, f"no restitution, friction {mu:g}", "leaves with no normal velocity to 1e-12", partial(_dead, mu)
            )
            for mu in FRICTIONS
        ),
        HardCase(THEME, "restitution 1, no friction", "keeps the energy to 1e-12", _elastic),
        *(
            HardCase(THEME, f"restitution 1, friction {mu:g}", "gains no energy to 1e-12", partial(_rough, mu))
            for mu in FRICTIONS[1:]
        ),
    )


def _hit(friction: float, restitution: float) -> ChainStrike:
    return strike(RODS, Surface(friction, None, restitution), Contact(), Settings())


def _dead(friction: float) -> Finding:
    one = _hit(friction, 0.0)
    assert one.contact.velocity_after is not None
    assert one.contact.velocity_before is not None
    share = one.contact.velocity_after[0] / one.contact.velocity_before[0]
    return within(share, 1e-12, "normal velocity after over before", one.steps)


def _elastic() -> Finding:
    one = _hit(0.0, 1.0)
    assert one.kinetic_energy_ratio is not None
    return within(one.kinetic_energy_ratio - 1.0, 1e-12, "energy ratio less 1", one.steps)


def _rough(friction: float) -> Finding:
    one = _hit(friction, 1.0)
    assert one.kinetic_energy_ratio is not None
    gain = within(max(0.0, one.kinetic_energy_ratio - 1.0), 1e-12, "energy gained", one.steps)
    return both(gain, Finding(f"energy ratio {one.kinetic_energy_ratio:.6f}", 0.0 < one.kinetic_energy_ratio <= 1.0))
