"""Parameters of single experiments: a release, a strike, a pendulum, a force history, a crater, and a comparison."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bristle_sim.glossary import KEYS
from bristle_sim.units import ANY, Declared, choice, count, quantity, shown, validate

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
    """Stiffness of a contact resolved in time, given by its half periods as a frictionless spring on a rigid bristle's K."""

    duration: float = quantity(
        7.1e-5,
        "contact_duration",
        at_least=1e-9,
        at_most=1e-2,
        source="50 us of compression (Zhang 2020, sec. 3.3) times 1 + e*",
        meaning="half periods of a frictionless spring on K at the touch, T; a rigid bristle is in touch some per cent longer",
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

    @property
    def with_reference(self) -> bool:
        """Whether the independent solution is requested."""
        return self.reference == "yes"


@dataclass(frozen=True, slots=True)
class Text:
    """A declared text: the name of a file, or the heading or number of one of its columns; None where there is none."""

    key: str
    source: str
    unit: str
    meaning: str
    optional: bool = True
    needs: str = ""

    @property
    def allowed(self) -> str:
        """Say what the text must be, for messages and listings."""
        return "a readable file" if self.unit == "file" else "the heading of a column, or its number from 1 on"

    def check(self, value: Any) -> str:
        """Return the text, or raise ValueError with key, value and what it must be."""
        if not isinstance(value, str) or not (_is_file(value) if self.unit == "file" else value.strip()):
            raise ValueError(f"{self.key} = {shown(value)}: must be {self.allowed}")
        return str(value)

    parse = check


def _is_file(name: str) -> bool:
    try:
        return bool(name) and Path(name).is_file()
    except (OSError, ValueError):  # a name too long, a null character
        return False


def _text(key: str, source: str) -> Any:
    return field(default=None, metadata={"declaration": Text(key, source, KEYS[key].unit, KEYS[key].meaning)})


@dataclass(frozen=True, slots=True)
class Measurement:
    """A measured force history that takes the place of the published curve."""

    force_csv: str | None = _text("force_csv", "none: the measured points are not in print")
    time_column: str | None = _text("time_column", "the one that the file marks as time, else the first")
    force_column: str | None = _text("force_column", "the one that the file marks as force, or the only other one")
    force_per_volt: float | None = quantity(
        None, "force_per_volt", source="none: the file holds a force, not a voltage"
    )

    def __post_init__(self) -> None:
        validate(self)
        for key in ("time_column", "force_column", "force_per_volt"):
            value = getattr(self, key)
            if value is not None and self.force_csv is None:
                raise ValueError(f"{key} = {shown(value)}: must be given with force_csv, which it describes")
        if self.force_per_volt == 0.0:
            raise ValueError("force_per_volt = 0: must be positive, or negative for an inverted signal (in N/V)")


@dataclass(frozen=True, slots=True)
class ForceHistory(Declared):
    """The contact compared with a force curve.

    ``speed_ratio`` and ``compression_time`` are those of the curve when None: as fast as its impulse needs, as long as
    its force rises.
    """

    speed_ratio: float | None = quantity(
        None,
        "speed_ratio",
        above=0.0,
        at_most=1e6,
        source="the one that gives the curve's compressive impulse",
        meaning="bristle's rate over the hub's speed when it strikes, R; none: from the curve's impulse",
    )
    impact_angle_deg: float = impact_angle_at_strike("Zhang 2020, eq. 3.9: gamma")
    compression_time: float | None = quantity(
        None,
        "compression_time",
        source="the curve's: Zhang 2020, eq. 3.20, 5e-5",
        meaning="time from first touch to the highest force; none: the curve's",
    )


@dataclass(frozen=True, slots=True)
class Crater(Declared):
    """A bristle's tip that cuts."""

    speed_ratio: float = speed_ratio_at_strike()
    impact_angle_deg: float = impact_angle_at_strike("Zhang 2020, eq. 4.51: gamma", at_most=89.0)
    friction: float = quantity(
        0.5,
        "friction",
        at_least=1e-6,
        source="Zhang 2020, eq. 4.51: while cutting; chapter 2 has 0.31",
        meaning="coefficient of friction between tip and workpart while it cuts",
    )
    shear_yield_stress: float = quantity(1.2e8, "shear_yield_stress", source="Zhang 2020, eq. 4.53: steel API 5L")
    plies: int = count(300, "plies", source="Zhang 2020, below fig. 4.13: n, of equal time")
    compression_time: float = quantity(
        5e-5,
        "compression_time",
        at_least=1e-8,
        at_most=1e-4,
        source="Zhang 2020, eq. 3.20: t_c, from the camera; (3.19) ends at 1e-4",
    )
