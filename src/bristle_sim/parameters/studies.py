"""Parameters of studies of many runs: maps, spreads of the inputs, the whole tool."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bristle_sim.units import ANY, Declared, count, described, quantity

FINE, MEDIUM = "ISO 2768-1 fine", "ISO 2768-1 medium"


@described
@dataclass(frozen=True, slots=True)
class MapGrid(Declared):
    """Resolution of the maps, and the processes that compute them."""

    points: int = count(25, "2 <= map_points <= 2000", "points of each axis of the maps", "chosen")
    half_width: float = quantity(
        0.008, "0 < map_half_width <= 1e3 m", "half-width of the maps about the bar's position", "chosen"
    )
    workers: int = count(1, "1 <= workers <= 64", "processes for the maps", "chosen")


@described
@dataclass(frozen=True, slots=True)
class Assembly(Declared):
    """How many bristles the tool has, and the load cell under the workpart."""

    bristles: int = count(
        42,
        "1 <= bristles <= 10000",
        "number of bristles, evenly spaced about the hub",
        "chosen: six staggered rows of seven, which do not touch each other",
        usual=None,
    )
    bandwidth: float = quantity(
        1000.0,
        "0.001 <= load_cell_bandwidth <= 100000 Hz",
        "bandwidth of the load cell under the workpart, a low-pass of second order",
        "chosen: a stiff load cell with a workpart on it",
    )


def _spread(default: float, key: str, unit: str, source: str) -> Any:
    meaning = f"half-width of the interval of {key}"
    return quantity(default, f"0 <= spread_{key} <= 1e6 {unit}", meaning, source, usual=ANY)


@described
@dataclass(frozen=True, slots=True)
class Spreads(Declared):
    """Half-widths of the inputs' intervals, in the inputs' units; an input with 0 stays at its value."""

    hub_speed: float = _spread(2.618, "hub_speed", "rad/s", "assumed: 1 %, a hand-held drive under load")
    hub_radius: float = _spread(1e-4, "hub_radius", "m", f"{FINE}, 6 to 30 mm: a turned part")
    bristle_length: float = _spread(2e-4, "bristle_length", "m", f"{MEDIUM}, 6 to 30 mm: cut wire")
    bristle_mass: float = _spread(2.4e-6, "bristle_mass", "kg", "of a wire drawn to 0.01 mm: 2.8 %")
    wire_diameter: float = _spread(1e-5, "wire_diameter", "m", "assumed: wire drawn to 0.01 mm")
    belt_stiffness: float = _spread(1.2e-3, "belt_stiffness", "N m/rad", "assumed: 5 % between belts")
    belt_damping_ratio: float = _spread(0.01, "belt_damping_ratio", "1", "assumed: 0.018 explains the printed speed")
    bar_radius: float = _spread(5e-5, "bar_radius", "m", f"{FINE}, 3 to 6 mm: a turned part")
    bar_horizontal: float = _spread(1.5e-4, "bar_horizontal", "m", f"{FINE}, 30 to 120 mm")
    bar_vertical: float = _spread(1e-4, "bar_vertical", "m", f"{FINE}, 6 to 30 mm")
    penetration: float = _spread(5e-4, "penetration", "m", "assumed: a tool guided by hand")
    friction: float = _spread(0.05, "friction", "1", "assumed: dry steel on steel")
    restitution: float = _spread(0.05, "restitution", "1", "assumed: between places of a workpart")


@described
@dataclass(frozen=True, slots=True)
class Sampling(Declared):
    """Size and seed of the samples; a study takes samples (d + 2) passes for d inputs.

    In a Sobol sequence of 26 dimensions, two for each of 13 inputs, the first 64 points leave pairs of dimensions correlated:
    indices are then off by up to 0.4, which no bootstrap sees; with 128 by 0.2, with 256 by 0.1, with 512 by 0.03 (tried on
    a linear model).
    """

    samples: int = count(
        256, f"2 <= samples <= {2**24}", "points of the Sobol sequence, a power of 2", "chosen; fewer give poor indices"
    )
    seed: int = count(1, f"0 <= seed <= {2**32 - 1}", "of the sequence's scrambling", "chosen")
    workers: int = count(1, "1 <= workers <= 64", "processes that simulate the passes", "chosen")

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        if self.samples & (self.samples - 1):
            raise ValueError(f"samples = {self.samples:g}: must be a power of 2 (dimensionless)")
