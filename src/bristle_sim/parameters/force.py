"""Parameters of force histories, craters, measured impacts, and the map over contact stiffness and
wire damping.
"""

from dataclasses import dataclass

from bristle_sim.declared import Declared
from bristle_sim.fields import count, quantity, text
from bristle_sim.parameters.experiments import impact_angle_at_strike, speed_ratio_at_strike
from bristle_sim.units import shown


@dataclass(frozen=True, slots=True)
class Measurement(Declared):
    """A measured force history that replaces the published curve."""

    force_csv: str | None = text(
        "force_csv: measured force history: columns of time and force, with or without headings"
        " [none: the measured points are not in print]",
        "file",
    )
    time_column: str | None = text(
        "time_column: column of the time in the file [the one whose heading has a unit of time, else the first]",
        "column",
    )
    force_column: str | None = text(
        "force_column: column of the force in the file"
        " [the one whose heading has a unit of force, or the only other one]",
        "column",
    )
    force_per_volt: float | None = quantity(
        None,
        "-1e12 <= force_per_volt <= 1e12 N/V: calibration of a force that was recorded as a voltage"
        " [none: the file holds a force, not a voltage]",
    )

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        for key in ("time_column", "force_column", "force_per_volt"):
            value = getattr(self, key)
            if value is not None and self.force_csv is None:
                raise ValueError(
                    f"{key} = {shown(value)}: must be given with force_csv, which it describes"
                )
        if self.force_per_volt == 0.0:
            raise ValueError(
                "force_per_volt = 0: must be positive, or negative for an inverted signal (in N/V)"
            )


@dataclass(frozen=True, slots=True)
class ForceHistory(Declared):
    """Settings of the simulated contact whose force is compared with a given force curve.

    If ``speed_ratio`` is None, the simulated impulse up to the end of compression is made equal to
    the impulse of the curve. If ``compression_time`` is None, the time from the curve's start to
    its peak is used.
    """

    speed_ratio: float | None = quantity(
        None,
        "0 < speed_ratio <= 1e6: bristle's rate divided by the hub's speed when it strikes, R; none: from the"
        " impulse of the curve [the one that gives the curve's compressive impulse]",
    )
    impact_angle_deg: float = impact_angle_at_strike("Zhang 2020, eq. 3.9: gamma")
    compression_time: float | None = quantity(
        None,
        "1e-9 <= compression_time <= 1 s: time from first touch to the highest force; none: the curve's"
        " [the curve's: Zhang 2020, eq. 3.20, 5e-5]",
    )


@dataclass(frozen=True, slots=True)
class Crater(Declared):
    """The crater that a bristle's tip cuts into the workpart."""

    speed_ratio: float = speed_ratio_at_strike()
    impact_angle_deg: float = impact_angle_at_strike("Zhang 2020, eq. 4.51: gamma", at_most=89.0)
    friction: float = quantity(
        0.5,
        "1e-6 <= cutting_friction <= 1e9: coefficient of friction between tip and workpart while it cuts"
        " [Zhang 2020, eq. 4.51: while cutting; chapter 2 has 0.31]",
    )
    shear_yield_stress: float = quantity(
        1.2e8,
        "1 <= shear_yield_stress <= 1e15 Pa: shear yield stress of the workpart's steel"
        " [Zhang 2020, eq. 4.53: steel API 5L]",
    )
    plies: int = count(
        300,
        "1 <= plies <= 1e5: number of layers into which the cut is divided"
        " [Zhang 2020, below fig. 4.13: n, of equal time]",
    )
    compression_time: float = quantity(
        5e-5,
        "1e-8 <= compression_time <= 0.0001 s: time from first touch to deepest penetration, t_c"
        " [Zhang 2020, eq. 3.20: t_c, from the camera; (3.19) ends at 1e-4]",
    )


@dataclass(frozen=True, slots=True)
class Measured(Declared):
    """Settings of the comparison of the impact law with measured impacts."""

    tangential_compliance: float = quantity(
        1.15,
        "0 <= tangential_compliance <= 1e4: stiffness of the contact along its normal divided by that along the surface,"
        " eta^2 [(2 - nu)/(2 (1 - nu)) with nu = 0.23, soda-lime glass and aluminium oxide (Stronge 2018, ch. 5)]",
    )
    data: str | None = text(
        "data: measured impacts of an ellipse: MATLAB file with an array bounce_array [none: the file is its authors']",
        "file",
    )


@dataclass(frozen=True, slots=True)
class FilmGrid(Declared):
    """Points of a map of contact duration and wire damping, and settings of a simulated high-speed
    camera.

    The camera films the pass at the point of the map whose results are nearest to the measurements.
    """

    durations: int = count(
        8,
        "2 <= map_durations <= 200: number of contact durations on the map, in equal ratios [chosen]",
    )
    shortest: float = quantity(
        5e-5,
        "1e-6 <= shortest_duration <= 0.001 s: shortest contact of a rigid bristle on the map [chosen]",
    )
    longest: float = quantity(
        3e-4,
        "1e-6 <= longest_duration <= 0.001 s: longest contact of a rigid bristle on the map"
        " [chosen: a period of the wire's first bending mode]",
    )
    dampings: int = count(
        6,
        "2 <= map_dampings <= 200: number of wire damping ratios on the map, closest at 0 [chosen]",
    )
    largest_damping: float = quantity(
        0.4,
        "0 < largest_damping <= 10: largest damping ratio of the wire's first bending mode on the map [chosen]",
    )
    frame_rate: float = quantity(
        2e4,
        "2000 <= frame_rate <= 1e6 1/s: frame rate of the camera [chosen: one frame in the printed compression time]",
    )
    exposure: float = quantity(
        1e-5, "1e-9 <= exposure <= 0.0005 s: time that the camera's shutter is open [chosen]"
    )
    workers: int = count(
        2,
        "1 <= workers <= 64: number of processes that compute the map [chosen: a small computer's]",
    )
    store: str | None = text(
        "store: folder that keeps finished cases, from which an interrupted map continues [none: nothing is kept]",
        "folder",
    )

    def __post_init__(self) -> None:
        Declared.__post_init__(self)
        if not self.shortest < self.longest:
            raise ValueError(
                f"shortest_duration = {self.shortest:g}: must be below longest_duration = {self.longest:g} (in s)"
            )
