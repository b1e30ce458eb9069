"""Parameters of single experiments: a release, a strike, a pendulum, and what a run is compared with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from bristle_sim.quantity import ANY, Declared, choice, count, quantity

STEEL_ON_STEEL = "assumed: steel on steel, as between tip and workpart"


def speed_ratio_at_strike() -> Any:
    """Declare the bristle's rate over the hub's speed."""
    source = "Zhang 2020, caption of fig. 2.7: R, bristle rate over hub speed"
    return quantity(3.23, "speed_ratio", source=source)


def impact_angle_at_strike(source: str, at_most: float = 90.0, meaning: str = "") -> Any:
    """Declare the angle gamma of a strike, in degrees."""
    return quantity(23.4, "impact_angle_deg", at_most=at_most, source=source, meaning=meaning)


@dataclass(frozen=True, slots=True)
class Release(Declared):
    """Release of the bristle from rest relative to the hub."""

    retraction_deg: float = quantity(44.5, "retraction_deg", source="Zhang 2020, eq. 2.2: theta_p")


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

    mass: float = quantity(8.387e-5, "rod_mass", source="the bristle's: Zhang 2020, 2.4.1")
    length: float = quantity(0.027, "rod_length", source="the bristle's: Zhang 2020, 2.4.1")
    impact_angle_deg: float = impact_angle_at_strike(
        "Zhang 2020, fig. 2.25: rod to the normal", meaning="angle between the rod and the surface's normal, gamma"
    )
    rate: float = quantity(-845.6, "rate", source="Zhang 2020, fig. 2.30; negative approaches")


@dataclass(frozen=True, slots=True)
class DoublePendulum(Declared):
    """Stronge's double pendulum: rods of equal length, the first ``mass_ratio`` times as heavy as the second."""

    mass: float = quantity(
        5.0, "rod_mass", source="Zhang 2020, fig. 2.28: m_2", meaning="mass of the second rod, whose end strikes, m_2"
    )
    mass_ratio: float = quantity(1.0, "mass_ratio", source="Zhang 2020, sec. 2.4.2.1: n = m_1/m_2", usual=ANY)
    length: float = quantity(
        1.0, "rod_length", source="Zhang 2020, sec. 2.4.2: both rods", meaning="length of each rod"
    )
    angle_1_deg: float = quantity(20.0, "angle_1_deg", source="Zhang 2020, fig. 2.28: theta_1, to the normal")
    angle_2_deg: float = quantity(30.0, "angle_2_deg", source="Zhang 2020, fig. 2.28: theta_2, to the normal")
    rate_1: float = quantity(-0.1, "rate_1", source="Zhang 2020, fig. 2.28; negative approaches")
    rate_2: float = quantity(-0.2, "rate_2", source="Zhang 2020, fig. 2.28; negative approaches")


@dataclass(frozen=True, slots=True)
class Neighbours(Declared):
    """Bristles that follow each other in one plane, and how two wires that touch rub and rebound."""

    bristles: int = count(2, "bristles", source="chosen: one bristle and its follower")
    pitch_deg: float = quantity(
        15.0, "pitch_deg", source="chosen: the wires touch at the bar, and again before the last one strikes"
    )
    friction: float = quantity(0.31, "neighbour_friction", source=STEEL_ON_STEEL)
    restitution: float = quantity(0.42, "neighbour_restitution", source=STEEL_ON_STEEL)
    search: str = choice("yes", "search", ("yes", "no"), source="chosen: it takes some twenty rows of two bristles")


@dataclass(frozen=True, slots=True)
class Comparison(Declared):
    """What a run is compared with."""

    reference: str = choice("no", "reference", ("no", "yes"), source="chosen: the independent solution takes longer")
