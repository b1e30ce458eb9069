"""Parameters of single experiments (release, strike, pendulum) and of studies of many passes."""

import math
from dataclasses import dataclass
from typing import Any

from bristle_sim.declared import Declared
from bristle_sim.fields import ANY, choice, count, quantity

GAMMA = "angle between the radial bristle and the workpart's normal, gamma"
STEEL_ON_STEEL = "assumed: steel on steel, as between tip and workpart"


def speed_ratio_at_strike() -> Any:
    """Declare the field for the bristle's angular velocity at the strike, divided by the hub's."""
    source = "Zhang 2020, caption of fig. 2.7: R, bristle rate divided by hub speed"
    return quantity(
        3.23,
        f"0 <= speed_ratio <= 1e6: bristle's rate divided by the hub's speed when it strikes, R [{source}]",
    )


def impact_angle_at_strike(source: str, at_most: float = 90.0, meaning: str = GAMMA) -> Any:
    """Declare the field for the impact angle gamma, deg.

    Args:
        source: source of the default, 23.4 deg.
        at_most: largest permitted angle, deg.
        meaning: meaning of the angle, in words.
    """
    return quantity(23.4, f"1e-30 <= impact_angle_deg <= {at_most} deg: {meaning} [{source}]")


@dataclass(frozen=True, slots=True)
class Release(Declared):
    """Release of the bristle from rest relative to the hub."""

    retraction_deg: float = quantity(
        44.5,
        "1e-6 <= retraction_deg <= 89.9 deg: angle by which the released bristle lags the radial direction"
        " [Zhang 2020, eq. 2.2: theta_p]",
    )


@dataclass(frozen=True, slots=True)
class Strike(Declared):
    """State of a bristle that points radially at the instant of its strike."""

    speed_ratio: float = speed_ratio_at_strike()
    impact_angle_deg: float = impact_angle_at_strike("Zhang 2020, sec. 2.3: gamma")


@dataclass(frozen=True, slots=True)
class ContactStiffness(Declared):
    """Stiffness of the contact between tip and workpart, specified by the contact's duration.

    The duration T is that of the contact of a rigid, frictionless bristle whose rotation during the
    contact is neglected. The tip then oscillates on the spring: compression takes a quarter of a
    period. Restitution takes a quarter of a period on a spring that is 1/e*^2 times as stiff.
    """

    duration: float = quantity(
        7.1e-5,
        "1e-9 <= contact_duration <= 0.01 s: duration T of the contact of a rigid bristle without friction; with friction and"
        " its rotation it is a few per cent longer [50 us of compression (Zhang 2020, sec. 3.3) times 1 + e*]",
    )

    def stiffness(self, inverse_mass: float, restitution: float) -> float:
        """Return the stiffness in compression k = (pi (1 + e*)/(2 T))^2/K_nn, N/m.

        Args:
            inverse_mass: normal inverse mass K_nn of the tip of the rigid bristle, 1/kg.
            restitution: energetic coefficient of restitution e*.
        """
        return (0.5 * math.pi * (1.0 + restitution) / self.duration) ** 2 / inverse_mass


def _rod_rate(default: float, key: str, rod: str, figure: str) -> Any:
    meaning = f"rate of the {rod} before the impact"
    source = f"Zhang 2020, fig. 2.{figure}"
    return quantity(
        default,
        f"-1e9 <= {key} <= 1e9 rad/s: {meaning}; negative approaches [{source}; negative approaches]",
    )


def _rod_angle(default: float, rod: str, number: int) -> Any:
    meaning = f"angle of the {rod} rod to the surface's normal"
    source = "Zhang 2020, fig. 2.28"
    return quantity(
        default,
        f"-90 <= angle_{number}_deg <= 90 deg: {meaning} [{source}: theta_{number}, to the normal]",
    )


@dataclass(frozen=True, slots=True)
class SinglePendulum(Declared):
    """Stronge's single pendulum: a rod that swings about a fixed hinge and strikes with its end."""

    mass: float = quantity(
        8.387e-5, "1e-30 <= rod_mass <= 1e6 kg: mass of the rod [the bristle's: Zhang 2020, 2.4.1]"
    )
    length: float = quantity(
        0.027, "1e-9 <= rod_length <= 10 m: length of the rod [the bristle's: Zhang 2020, 2.4.1]"
    )
    impact_angle_deg: float = impact_angle_at_strike(
        "Zhang 2020, fig. 2.25: rod to the normal",
        meaning="angle between the rod and the surface's normal, gamma",
    )
    rate: float = _rod_rate(-845.6, "rate", "rod", "30")


@dataclass(frozen=True, slots=True)
class DoublePendulum(Declared):
    """Stronge's double pendulum: two rods of equal length in a chain that hangs from a fixed hinge.

    The second rod strikes with its end. The first rod, on the hinge, is ``mass_ratio`` times as
    heavy as the second.
    """

    mass: float = quantity(
        5.0,
        "1e-30 <= rod_mass <= 1e6 kg: mass of the second rod, whose end strikes, m_2 [Zhang 2020, fig. 2.28: m_2]",
    )
    mass_ratio: float = quantity(
        1.0,
        "1e-9 <= mass_ratio <= 1e12: mass of the first rod divided by the second's, n"
        " [Zhang 2020, sec. 2.4.2.1: n = m_1/m_2]",
        usual=ANY,
    )
    length: float = quantity(
        1.0, "1e-9 <= rod_length <= 10 m: length of each rod [Zhang 2020, sec. 2.4.2: both rods]"
    )
    angle_1_deg: float = _rod_angle(20.0, "first", 1)
    angle_2_deg: float = _rod_angle(30.0, "second", 2)
    rate_1: float = _rod_rate(-0.1, "rate_1", "first rod", "28")
    rate_2: float = _rod_rate(-0.2, "rate_2", "second rod", "28")


@dataclass(frozen=True, slots=True)
class Neighbours(Declared):
    """Several bristles in one row, with friction and restitution between two wires."""

    bristles: int = count(
        2,
        "2 <= bristles <= 12: number of bristles in the row; the quantities at a pitch are those of the last one"
        " [chosen: one bristle and its follower]",
    )
    pitch_deg: float = quantity(
        15.0,
        "0 < pitch_deg <= 180 deg: angle about the hub from one bristle to the next"
        " [chosen: the wires touch at the bar, and again before the last one strikes]",
    )
    friction: float = quantity(
        0.31,
        f"0 <= neighbour_friction <= 1e6: coefficient of friction between two wires [{STEEL_ON_STEEL}]",
    )
    restitution: float = quantity(
        0.42,
        f"0 <= neighbour_restitution <= 1: energetic coefficient of restitution between two wires [{STEEL_ON_STEEL}]",
    )
    search: str = choice(
        "search: whether the least pitches are also determined by simulating rows"
        " [chosen: it takes about twenty rows of two bristles]",
        *("yes", "no"),
    )


@dataclass(frozen=True, slots=True)
class Comparison(Declared):
    """Request to compare a result with an independent solution of the same problem."""

    reference: str = choice(
        "reference: whether the independent solution is computed too and judges the result"
        " [chosen: the independent solution takes longer]",
        *("no", "yes"),
    )


FINE = "ISO 2768-1 fine"
MEDIUM = "ISO 2768-1 medium"


@dataclass(frozen=True, slots=True)
class MapGrid(Declared):
    """Resolution and extent of the maps of a quantity against the bar's position."""

    points: int = count(
        121, "2 <= map_points <= 2000: number of points along each axis of the maps [chosen]"
    )
    half_width: float = quantity(
        0.008,
        "0 < map_half_width <= 10 m: least half-width of the maps; they are wider where the bar or its best positions require it"
        " [chosen]",
    )


@dataclass(frozen=True, slots=True)
class Assembly(Declared):
    """Number of bristles of the tool, and the load cell under the workpart."""

    bristles: int = count(
        42,
        "1 <= bristles <= 10000: number of bristles, evenly spaced about the hub"
        " [chosen: six staggered rows of seven, which do not touch each other]",
        usual=None,
    )
    bandwidth: float = quantity(
        1000.0,
        "0.001 <= load_cell_bandwidth <= 100000 Hz: bandwidth of the load cell under the workpart, a low-pass of"
        " second order [chosen: a stiff load cell with a workpart on it]",
    )


def _spread(default: float, key: str, unit: str, source: str) -> Any:
    meaning = f"half-width of the interval in which {key} varies"
    return quantity(default, f"0 <= spread_{key} <= 1e6 {unit}: {meaning} [{source}]", usual=ANY)


@dataclass(frozen=True, slots=True)
class Spreads(Declared):
    """Half-widths of the intervals in which the inputs of a tolerance study vary.

    Each half-width has the unit of its input. An input with half-width 0 does not vary.
    """

    hub_speed: float = _spread(
        2.618, "hub_speed", "rad/s", "assumed: 1 %, a hand-held drive under load"
    )
    hub_radius: float = _spread(1e-4, "hub_radius", "m", f"{FINE}, 6 to 30 mm: a turned part")
    bristle_length: float = _spread(2e-4, "bristle_length", "m", f"{MEDIUM}, 6 to 30 mm: cut wire")
    bristle_mass: float = _spread(
        0.0, "bristle_mass", "kg", "follows from the wire's length, diameter and density"
    )
    wire_diameter: float = _spread(1e-5, "wire_diameter", "m", "assumed: wire drawn to 0.01 mm")
    wire_density: float = _spread(40.0, "wire_density", "kg/m^3", "assumed: 0.5 % between steels")
    belt_stiffness: float = _spread(
        1.2e-3, "belt_stiffness", "N m/rad", "assumed: 5 % between belts"
    )
    belt_damping_ratio: float = _spread(
        0.01, "belt_damping_ratio", "1", "assumed: 0.018 explains the printed speed"
    )
    bar_radius: float = _spread(5e-5, "bar_radius", "m", f"{FINE}, 3 to 6 mm: a turned part")
    bar_horizontal: float = _spread(1.5e-4, "bar_horizontal", "m", f"{FINE}, 30 to 120 mm")
    bar_vertical: float = _spread(1e-4, "bar_vertical", "m", f"{FINE}, 6 to 30 mm")
    penetration: float = _spread(5e-4, "penetration", "m", "assumed: a tool guided by hand")
    friction: float = _spread(0.05, "friction", "1", "assumed: dry steel on steel")
    restitution: float = _spread(0.05, "restitution", "1", "assumed: between places of a workpart")


@dataclass(frozen=True, slots=True)
class Sampling(Declared):
    """Number and seed of the samples from which a study computes sensitivity indices.

    A study with d inputs simulates d + 2 passes for each sample. The samples are points of Sobol
    sequences with two dimensions for each input. The first points of a sequence are correlated in
    some pairs of dimensions. On a linear model with 13 inputs, the error of the indices was
    therefore up to 0.4 with 64 points, 0.2 with 128, 0.1 with 256 and 0.03 with 512. The samples
    are divided among sixteen sequences, whose scatter shows such errors.
    """

    samples: int = count(
        2**13,
        f"32 <= samples <= {2**20}: number of points of the Sobol sequences, a power of 2 [chosen: error of the indices below 0.01, with 122,880 passes for 13 inputs]",
    )
    seed: int = count(
        1, f"0 <= seed <= {2**32 - 1}: seed of the scrambling of the sequences [chosen]"
    )

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        if self.samples & (self.samples - 1):
            raise ValueError(f"samples = {self.samples:g}: must be a power of 2 (dimensionless)")
