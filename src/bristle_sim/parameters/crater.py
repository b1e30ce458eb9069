"""Parameters of the contact's force history and of the crater (Zhang 2020, chapters 3 and 4)."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bristle_sim.glossary import KEYS
from bristle_sim.parameters.experiments import impact_angle_at_strike, speed_ratio_at_strike
from bristle_sim.quantity import Declared, count, quantity, shown, validate


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
