"""Parameters of single experiments: a release, a strike, a pendulum, a force history, a crater, and a comparison."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from bristle_sim.units import ANY, Declared, choice, count, described, quantity

GAMMA = "angle between the radial bristle and the workpart's normal, gamma"
STEEL_ON_STEEL = "assumed: steel on steel, as between tip and workpart"


def speed_ratio_at_strike() -> Any:
    """Declare the bristle's rate over the hub's speed."""
    source = "Zhang 2020, caption of fig. 2.7: R, bristle rate over hub speed"
    return quantity(3.23, "0 <= speed_ratio <= 1e6", "bristle's rate over the hub's speed when it strikes, R", source)


def impact_angle_at_strike(source: str, at_most: float = 90.0, meaning: str = GAMMA) -> Any:
    """Declare the angle gamma of a strike, in degrees."""
    return quantity(23.4, f"1e-30 <= impact_angle_deg <= {at_most} deg", meaning, source)


@described
@dataclass(frozen=True, slots=True)
class Release(Declared):
    """Release of the bristle from rest relative to the hub."""

    retraction_deg: float = quantity(
        44.5,
        "1e-6 <= retraction_deg <= 89.9 deg",
        "angle by which the released bristle lags the radial direction",
        "Zhang 2020, eq. 2.2: theta_p",
    )


@described
@dataclass(frozen=True, slots=True)
class Strike(Declared):
    """State of a radial bristle at the instant of its strike."""

    speed_ratio: float = speed_ratio_at_strike()
    impact_angle_deg: float = impact_angle_at_strike("Zhang 2020, sec. 2.3: gamma")


@described
@dataclass(frozen=True, slots=True)
class ContactStiffness(Declared):
    """Stiffness of a contact resolved in time, given by its half periods as a frictionless spring on a rigid bristle's K."""

    duration: float = quantity(
        7.1e-5,
        "1e-9 <= contact_duration <= 0.01 s",
        "half periods of a frictionless spring on K at the touch, T; a rigid bristle is in touch some per cent longer",
        "50 us of compression (Zhang 2020, sec. 3.3) times 1 + e*",
    )

    def stiffness(self, inverse_mass: float, restitution: float) -> float:
        """Return k = (pi (1 + e*)/(2 T))^2/K_nn, N/m, with K_nn of the rigid bristle, 1/kg."""
        return (0.5 * math.pi * (1.0 + restitution) / self.duration) ** 2 / inverse_mass


@described
@dataclass(frozen=True, slots=True)
class SinglePendulum(Declared):
    """Stronge's single pendulum: a rod that swings about a fixed hinge and strikes with its end."""

    mass: float = quantity(
        8.387e-5, "1e-30 <= rod_mass <= 1e6 kg", "mass of the rod", "the bristle's: Zhang 2020, 2.4.1"
    )
    length: float = quantity(
        0.027, "1e-9 <= rod_length <= 1e3 m", "length of the rod", "the bristle's: Zhang 2020, 2.4.1"
    )
    impact_angle_deg: float = impact_angle_at_strike(
        "Zhang 2020, fig. 2.25: rod to the normal", meaning="angle between the rod and the surface's normal, gamma"
    )
    rate: float = quantity(
        -845.6,
        "-1e9 <= rate <= 1e9 rad/s",
        "rate of the rod before the impact; negative approaches",
        "Zhang 2020, fig. 2.30; negative approaches",
    )


@described
@dataclass(frozen=True, slots=True)
class DoublePendulum(Declared):
    """Stronge's double pendulum: rods of equal length, the first ``mass_ratio`` times as heavy as the second."""

    mass: float = quantity(
        5.0,
        "1e-30 <= rod_mass <= 1e6 kg",
        "mass of the second rod, whose end strikes, m_2",
        "Zhang 2020, fig. 2.28: m_2",
    )
    mass_ratio: float = quantity(
        1.0,
        "1e-9 <= mass_ratio <= 1e12",
        "mass of the first rod over the second's, n",
        "Zhang 2020, sec. 2.4.2.1: n = m_1/m_2",
        usual=ANY,
    )
    length: float = quantity(
        1.0, "1e-9 <= rod_length <= 1e3 m", "length of each rod", "Zhang 2020, sec. 2.4.2: both rods"
    )
    angle_1_deg: float = quantity(
        20.0,
        "-90 <= angle_1_deg <= 90 deg",
        "angle of the first rod to the surface's normal",
        "Zhang 2020, fig. 2.28: theta_1, to the normal",
    )
    angle_2_deg: float = quantity(
        30.0,
        "-90 <= angle_2_deg <= 90 deg",
        "angle of the second rod to the surface's normal",
        "Zhang 2020, fig. 2.28: theta_2, to the normal",
    )
    rate_1: float = quantity(
        -0.1,
        "-1e9 <= rate_1 <= 1e9 rad/s",
        "rate of the first rod before the impact; negative approaches",
        "Zhang 2020, fig. 2.28; negative approaches",
    )
    rate_2: float = quantity(
        -0.2,
        "-1e9 <= rate_2 <= 1e9 rad/s",
        "rate of the second rod before the impact; negative approaches",
        "Zhang 2020, fig. 2.28; negative approaches",
    )


@described
@dataclass(frozen=True, slots=True)
class Neighbours(Declared):
    """Bristles that follow each other in one plane, and how two wires that touch rub and rebound."""

    bristles: int = count(
        2,
        "2 <= bristles <= 12",
        "number of bristles in the row; the quantities at a pitch are those of the last one",
        "chosen: one bristle and its follower",
    )
    pitch_deg: float = quantity(
        15.0,
        "0 < pitch_deg <= 180 deg",
        "angle about the hub from one bristle to the next",
        "chosen: the wires touch at the bar, and again before the last one strikes",
    )
    friction: float = quantity(
        0.31, "0 <= neighbour_friction <= 1e6", "coefficient of friction between two wires", STEEL_ON_STEEL
    )
    restitution: float = quantity(
        0.42,
        "0 <= neighbour_restitution <= 1",
        "energetic coefficient of restitution between two wires",
        STEEL_ON_STEEL,
    )
    search: str = choice(
        "yes",
        "search",
        ("yes", "no"),
        "whether the least pitches are also searched on simulated rows",
        "chosen: it takes some twenty rows of two bristles",
    )


@described
@dataclass(frozen=True, slots=True)
class Comparison(Declared):
    """What a run is compared with."""

    reference: str = choice(
        "no",
        "reference",
        ("no", "yes"),
        "whether the independent solution is computed too and judges the result",
        "chosen: the independent solution takes longer",
    )

    @property
    def with_reference(self) -> bool:
        """Whether the independent solution is requested."""
        return self.reference == "yes"
