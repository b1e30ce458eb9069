"""Positions of the bar that each reading of the belt stiffness needs, and whole passes with a bar there.

The released bristle's cue time places the bar (Zhang 2020, eq. 2.1), be it simulated or from the quasi-static formulas,
in which the bristle swings as a linear oscillator on its belt,

    alpha(t) = -theta_p e^(-zeta Omega t) (cosh w t + zeta Omega/w sinh w t),    w = Omega sqrt(zeta^2 - 1),

an undamped cosine in the dissertation (sec. 2.2). Neither includes the bar's effects: the impact of
first touch, and the swing that continues after the last touch. A whole pass does.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bristle_sim.arrays import Array
from bristle_sim.parameters import PRINTED_BELT_STIFFNESS, Bar, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_point import from_radial, state_at_strike
from bristle_sim.theory import cueing
from bristle_sim.trajectory import Trajectory

BEFORE_BAR = math.radians(30.0)
"""A whole pass starts with the radial bristle this far before the bar's direction, clear of the bar, rad."""

POINTS = 400
"""Instants of a formula's curve."""


class BarPlace(NamedTuple):
    """A bar's centre: S_H and S_V in m, and its direction from the workpart's normal in rad."""

    horizontal: float
    vertical: float
    direction: float

    @classmethod
    def of(cls, bar: Bar) -> BarPlace:
        """Return the position of a bar."""
        return cls(bar.horizontal, bar.vertical, math.atan2(bar.horizontal, bar.vertical))


class FullPass(NamedTuple):
    """The strike at the end of a whole pass: lag in deg and relative speed in rad/s, None if there is none.

    ``failure`` says how the pass ends if it does not strike.
    """

    lag_deg: float | None
    relative_speed: float | None
    failure: str = ""

    @property
    def retraction(self) -> float | None:
        """The lag in rad."""
        return None if self.lag_deg is None else math.radians(self.lag_deg)

    def __str__(self) -> str:
        """Say what the pass gives, as the end of a sentence."""
        if self.lag_deg is None:
            return self.failure
        side = "short of" if self.lag_deg >= 0.0 else "beyond"
        return (
            f"strikes {abs(self.lag_deg):.2f} deg {side} radial at {self.relative_speed:.1f} rad/s relative to the hub"
        )


@dataclass(frozen=True, slots=True)
class Release:
    """A bristle released from rest, up to its highest speed: arrays of one length, in s, rad and rad/s."""

    time: Array
    retraction: Array
    relative_speed: Array


@dataclass(frozen=True, slots=True)
class ReadingPlaces:
    """The bar that one belt stiffness (N m/rad) needs, by simulation and by formula, None where none.

    ``passed`` is a whole pass with the bar where the simulation places it, ``passed_as_given`` one with the bar as given.
    """

    reading: str
    stiffness: float
    simulated: BarPlace | None
    formula: BarPlace | None
    passed: FullPass | None
    passed_as_given: FullPass

    @classmethod
    def of(
        cls, reading: str, tool: Tool, retraction: float, run: Trajectory, given: Bar, settings: Settings
    ) -> ReadingPlaces:
        """Place the bar by a simulated release and by formula, and simulate whole passes."""
        needed, formula = (
            None if cue is None else BarPlace(cue.bar_horizontal, cue.bar_vertical, cue.bar_direction)
            for cue in (simulated_cue(tool, retraction, run), formula_cue(tool, retraction))
        )
        passed = None if needed is None else full_pass(tool, given, needed, settings)
        as_given = full_pass(tool, given, BarPlace.of(given), settings)
        return cls(reading, tool.belt.stiffness, needed, formula, passed, as_given)

    def pass_rows(self, given: Bar) -> list[dict[str, str | float | None]]:
        """Return the whole passes as plain numbers, None for the strike of a pass that has none."""
        pairs = ((self.simulated, self.passed), (BarPlace.of(given), self.passed_as_given))
        return [
            {
                "belt_stiffness": self.stiffness,
                "bar_direction_deg": math.degrees(place.direction),
                "lag_deg_at_contact": passed.lag_deg,
                "relative_speed_at_contact": passed.relative_speed,
            }
            for place, passed in pairs
            if place is not None and passed is not None
        ]

    def in_words(self, given: Bar) -> tuple[str, ...]:
        """Say where the belt stiffness needs the bar, and what whole passes give."""
        words = f"belt stiffness {self.reading.replace('_', ' ')} ({self.stiffness:.5g} N m/rad): "
        stands = math.degrees(BarPlace.of(given).direction)
        as_given = f"  a full pass with the bar as it stands {self.passed_as_given}"
        if self.simulated is None:
            return words + "never reaches a highest speed; cannot be cued by any bar", as_given
        needed = math.degrees(self.simulated.direction)
        return (
            f"{words}bar needed at {needed:.2f} deg, {needed - stands:+.2f} deg from where it stands ({stands:.2f} deg)",
            f"  a full pass with the bar at {needed:.2f} deg {self.passed}",
            as_given,
        )


def stiffness_readings(tool: Tool) -> dict[str, float]:
    """Return the readings of the printed "0.00041 N m/rad", and the stiffness of the bristle filmed at 254 Hz, N m/rad."""
    filmed = tool.bristle.inertia_about_root * (2.0 * math.pi * 254.0) ** 2
    degrees = math.degrees(PRINTED_BELT_STIFFNESS)
    return {"per_radian": PRINTED_BELT_STIFFNESS, "per_degree": degrees, "from_254_hz": filmed}


def simulated_cue(tool: Tool, retraction: float, run: Trajectory) -> cueing.Cue | None:
    """Return the cue of a simulated release (Zhang 2020, eq. 2.1); None if no speed is the highest.

    The release of a wire that bends ends when its tip is radial, where an undamped rigid bristle is fastest.
    """
    if tool.bristle.links > 1:
        return cueing.placed_cue(tool, retraction, float(run.time[-1]), float(from_radial(run, tool.bristle)[1][-1]))
    time = run.event_time("highest relative speed")
    if time is None or tool.workpart is None:
        return None
    return cueing.placed_cue(tool, retraction, time, run.relative_rate[int(abs(run.time - time).argmin())])


def formula_cue(tool: Tool, retraction: float) -> cueing.Cue | None:
    """Return the cue of the quasi-static formulas; None without belt stiffness."""
    return cueing.cue(tool, retraction) if tool.belt.stiffness else None


def full_pass(tool: Tool, bar: Bar, place: BarPlace, settings: Settings) -> FullPass:
    """Simulate a pass up to the strike with a bar at a place; an error becomes the reason why there is no strike."""
    turning = dataclasses.replace(settings, hub_turn=2.0 * math.pi)
    try:
        placed = dataclasses.replace(bar, horizontal=place.horizontal, vertical=place.vertical)
        start = -place.direction - BEFORE_BAR
        run = simulate(dataclasses.replace(tool, bar=placed), turning, start_hub_angle=start, stop_after="strike")
    except ValueError as error:
        return FullPass(None, None, f"cannot be simulated ({error})")
    contact = run.first_contact("workpart")
    if contact is None:
        return FullPass(None, None, f"ends without a strike ({run.stop_reason})")
    state = state_at_strike(tool, run, contact)
    return FullPass(state["lag_deg_at_contact"], state["relative_speed_at_contact"])


def formula_motion(tool: Tool, retraction: float, time: ArrayLike) -> tuple[Array, Array]:
    """Return retraction and relative speed of the released bristle as a linear oscillator, rad and rad/s, at times in s.

    Raises:
        ValueError: if the belt has no stiffness.
    """
    instants = np.asarray(time, dtype=float)
    rate = float(cueing.natural_rate(tool.belt.stiffness, tool.bristle.inertia_about_root))
    decay = tool.belt.damping_ratio * rate
    turns = 1j * np.sqrt(complex(decay**2 - rate**2)) * instants
    # sinh(w t)/w = t sin(i w t)/(i w t), which has its limit t at critical damping.
    swing, drift = np.cos(turns), instants * np.sinc(turns / np.pi)
    fading = np.exp(-decay * instants)
    return retraction * fading * (swing + decay * drift).real, retraction * rate**2 * fading * drift.real


def formula_release(tool: Tool, retraction: float) -> Release | None:
    """Return the formula's motion up to its highest speed; None without belt stiffness."""
    cue = formula_cue(tool, retraction)
    if cue is None:
        return None
    time = np.linspace(0.0, cue.cue_time, POINTS)
    return Release(time, *formula_motion(tool, retraction, time))


def seen_at_strike(tool: Tool, run: Trajectory) -> tuple[Array, Array]:
    """Return the simulated wire as released and at its highest speed, turned to where it then strikes radially.

    Hub and belt have no preferred direction, so the run may be turned about the hub's centre: until the root stands at
    the impact angle gamma before the workpart's normal when the speed is highest.

    Returns:
        The two centre lines, each of shape (corners, 2), m.
    """
    assert tool.workpart is not None
    angle = float(cueing.impact_angle(tool.hub.radius, tool.bristle.length, tool.workpart.penetration))
    turn = np.exp(1j * (-angle - run.hub_angle[-1]))
    points = (run.centre_line[[0, -1]] @ np.array([1.0, 1j])) * turn
    released, fastest = np.stack([points.real, points.imag], axis=-1)
    return released, fastest
