"""Parameters of single experiments: a release, a strike, a pendulum, and what a run is compared with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from bristle_sim.quantity import ANY, Declared, choice, count, quantity


def speed_ratio_at_strike() -> Any:
    """Declare the bristle's rate over the hub's speed."""
    return quantity(
        3.23,
        "speed_ratio",
        "1",
        at_least=0.0,
        at_most=1e6,
        source="Zhang 2020, caption of fig. 2.7: R, bristle rate over hub speed",
        meaning="bristle's rate over the hub's speed when it strikes, R",
    )


def impact_angle_at_strike(
    source: str,
    at_most: float = 90.0,
    meaning: str = "angle between the radial bristle and the workpart's normal, gamma",
) -> Any:
    """Declare the angle gamma of a strike, in degrees."""
    key = "impact_angle_deg"
    return quantity(23.4, key, "deg", at_least=1e-30, at_most=at_most, source=source, meaning=meaning)


@dataclass(frozen=True, slots=True)
class Release(Declared):
    """Release of the bristle from rest relative to the hub."""

    retraction_deg: float = quantity(
        44.5,
        "retraction_deg",
        "deg",
        at_least=1e-6,
        at_most=89.9,
        source="Zhang 2020, eq. 2.2: theta_p",
        meaning="angle by which the released bristle lags the radial direction",
    )


@dataclass(frozen=True, slots=True)
class Strike(Declared):
    """State of a radial bristle at the instant of its strike."""

    speed_ratio: float = speed_ratio_at_strike()
    impact_angle_deg: float = impact_angle_at_strike("Zhang 2020, sec. 2.3: gamma")


@dataclass(frozen=True, slots=True)
class ContactStiffness(Declared):
    """Stiffness of a contact resolved in time, given by how long it would keep a rigid bristle in touch."""

    duration: float = quantity(
        7.1e-5,
        "contact_duration",
        "s",
        at_least=1e-9,
        at_most=1e-2,
        source="50 us of compression (Zhang 2020, sec. 3.3) times 1 + e*",
        meaning="time for which the contact's stiffness would keep the rigid bristle in touch, without friction, T",
    )

    def stiffness(self, inverse_mass: float, restitution: float) -> float:
        """Return k = (pi (1 + e*)/(2 T))^2/K_nn, N/m, with K_nn of the rigid bristle, 1/kg."""
        return (0.5 * math.pi * (1.0 + restitution) / self.duration) ** 2 / inverse_mass


@dataclass(frozen=True, slots=True)
class SinglePendulum(Declared):
    """Stronge's single pendulum: a rod that swings about a fixed hinge and strikes with its end."""

    mass: float = quantity(
        8.387e-5,
        "rod_mass",
        "kg",
        at_least=1e-30,
        at_most=1e6,
        source="the bristle's: Zhang 2020, 2.4.1",
        meaning="mass of the rod",
    )
    length: float = quantity(
        0.027,
        "rod_length",
        "m",
        at_least=1e-9,
        at_most=1e3,
        source="the bristle's: Zhang 2020, 2.4.1",
        meaning="length of the rod",
    )
    impact_angle_deg: float = impact_angle_at_strike(
        "Zhang 2020, fig. 2.25: rod to the normal", meaning="angle between the rod and the surface's normal, gamma"
    )
    rate: float = quantity(
        -845.6,
        "rate",
        "rad/s",
        at_least=-1e9,
        at_most=1e9,
        source="Zhang 2020, fig. 2.30; negative approaches",
        meaning="rate of the rod before the impact; negative approaches",
    )


@dataclass(frozen=True, slots=True)
class DoublePendulum(Declared):
    """Stronge's double pendulum: rods of equal length, the first ``mass_ratio`` times as heavy as the second."""

    mass: float = quantity(
        5.0,
        "rod_mass",
        "kg",
        at_least=1e-30,
        at_most=1e6,
        source="Zhang 2020, fig. 2.28: m_2",
        meaning="mass of the second rod, whose end strikes, m_2",
    )
    mass_ratio: float = quantity(
        1.0,
        "mass_ratio",
        "1",
        at_least=1e-9,
        at_most=1e12,
        source="Zhang 2020, sec. 2.4.2.1: n = m_1/m_2",
        meaning="mass of the first rod over the second's, n",
        usual=ANY,
    )
    length: float = quantity(
        1.0,
        "rod_length",
        "m",
        at_least=1e-9,
        at_most=1e3,
        source="Zhang 2020, sec. 2.4.2: both rods",
        meaning="length of each rod",
    )
    angle_1_deg: float = quantity(
        20.0,
        "angle_1_deg",
        "deg",
        at_least=-90.0,
        at_most=90.0,
        source="Zhang 2020, fig. 2.28: theta_1, to the normal",
        meaning="angle of the first rod to the surface's normal",
    )
    angle_2_deg: float = quantity(
        30.0,
        "angle_2_deg",
        "deg",
        at_least=-90.0,
        at_most=90.0,
        source="Zhang 2020, fig. 2.28: theta_2, to the normal",
        meaning="angle of the second rod to the surface's normal",
    )
    rate_1: float = quantity(
        -0.1,
        "rate_1",
        "rad/s",
        at_least=-1e9,
        at_most=1e9,
        source="Zhang 2020, fig. 2.28; negative approaches",
        meaning="rate of the first rod before the impact; negative approaches",
    )
    rate_2: float = quantity(
        -0.2,
        "rate_2",
        "rad/s",
        at_least=-1e9,
        at_most=1e9,
        source="Zhang 2020, fig. 2.28; negative approaches",
        meaning="rate of the second rod before the impact; negative approaches",
    )


@dataclass(frozen=True, slots=True)
class Neighbours(Declared):
    """Bristles that follow each other in one plane, and how two wires that touch rub and rebound."""

    bristles: int = count(
        2,
        "bristles",
        at_least=2,
        at_most=12,
        source="chosen: one bristle and its follower",
        meaning="number of bristles in the row; the quantities at a pitch are those of the last one",
    )
    pitch_deg: float = quantity(
        15.0,
        "pitch_deg",
        "deg",
        above=0.0,
        at_most=180.0,
        source="chosen: the wires touch at the bar, and again before the last one strikes",
        meaning="angle about the hub from one bristle to the next",
    )
    friction: float = quantity(
        0.31,
        "neighbour_friction",
        "1",
        at_least=0.0,
        at_most=1e6,
        source="assumed: steel on steel, as between tip and workpart",
        meaning="coefficient of friction between two wires",
    )
    restitution: float = quantity(
        0.42,
        "neighbour_restitution",
        "1",
        at_least=0.0,
        at_most=1.0,
        source="assumed: steel on steel, as between tip and workpart",
        meaning="energetic coefficient of restitution between two wires",
    )
    search: str = choice(
        "yes",
        "search",
        ("yes", "no"),
        source="chosen: it takes some twenty rows of two bristles",
        meaning="whether the least pitches are also searched on simulated rows",
    )


@dataclass(frozen=True, slots=True)
class Comparison(Declared):
    """What a run is compared with."""

    reference: str = choice(
        "no",
        "reference",
        ("no", "yes"),
        source="chosen: the independent solution takes longer",
        meaning="whether the independent solution is computed too and judges the result",
    )
