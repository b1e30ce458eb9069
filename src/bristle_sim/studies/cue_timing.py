"""The position of the bar that the dissertation's quasi-static formulas give, compared with the
position that follows from a simulated release of the bristle from rest.

The cue formulas (Zhang 2020, sec. 2.2) treat the bristle as a linear oscillator on its belt:
undamped in the dissertation, with the belt's damping here. The bristle is cued if it strikes at its
highest speed. The cue time is the time from the release to the highest speed; it determines the
bar's position (eq. 2.1).

The formulas neglect the centrifugal stiffening, which the simulated release includes. Formulas and
release neglect the impact of the first touch of the bar, and the swing of the bristle after the
last touch of the bar. A simulated whole pass includes these effects.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, Table, Values, rows
from bristle_sim.dissertation.printed import printed_cue
from bristle_sim.parameters import (
    PRINTED_BELT_STIFFNESS,
    RETRACTION_AT_RELEASE,
    Bar,
    Belt,
    Bristle,
    Hub,
    Tool,
)
from bristle_sim.readable import amount
from bristle_sim.scene.simulate import samples_per_period, simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_measures import beside_radial
from bristle_sim.studies.strike_point import full_pass
from bristle_sim.studies.whole_pass import require_result, require_rigid, run_fields
from bristle_sim.theory import cueing
from bristle_sim.theory.cueing import Cue
from bristle_sim.trajectory import Trajectory

QUANTITIES = {
    "cue_time": ("cue time t_c", "s"),
    "cue_hub_turn_deg": ("turn of the hub in it", "deg"),
    "highest_relative_speed": ("highest relative speed", "rad/s"),
    "bar_direction_deg": ("bar's direction", "deg"),
    "bar_horizontal": ("bar along the workpart S_H", "m"),
    "bar_vertical": ("bar normal to the workpart S_V", "m"),
}

# Longest simulated release, in revolutions of the hub. A bristle that still accelerates after so
# many revolutions has an extremely soft belt.
FULL_TURNS = 1e3
# Largest factor by which an overdamped release is sampled more densely. A larger factor would put
# the samples as close as the steps of the simulation.
MOST_DAMPED = 10.0


@dataclass(frozen=True, slots=True)
class CueTiming:
    """A simulated release of the bristle, the cues by several methods, and passes with the bar at
    two positions.

    A cue consists of the bar position from which the released bristle strikes at its highest speed,
    of this speed, and of the cue time from the release to the strike.

    Attributes:
        tool: the tool.
        retraction: angle by which the bristle is behind the radial direction at the release, rad.
        trajectory: simulated release, up to the instant of the highest relative angular velocity.
        simulated: cue by the simulated release; None if the relative angular velocity has no
            maximum.
        formula: cue by the formulas; None if the belt has no stiffness.
        reference: cue by the independent reference solver; None if it was not requested.
        bar: the bar at the position with which the cues are compared.
        passes: results of whole passes. In the first pass the bar stands at the position of
            ``simulated``; if ``simulated`` is None, this pass is absent. In the last pass the bar
            is ``bar``.
        readings: results for several belt stiffnesses, by name. They are the printed stiffness in
            each possible unit, the stiffness that gives the filmed 254 Hz, and, under the key
            ``own``, the tool's stiffness if it differs from the others.
    """

    tool: Tool
    retraction: float
    trajectory: Trajectory
    simulated: Cue | None
    formula: Cue | None
    reference: Cue | None
    bar: Bar
    passes: tuple[dict[str, Any], ...]
    readings: Mapping[str, CueTiming] = field(default_factory=dict)

    @property
    def wires(self) -> Array:
        """Centre lines of the wire (m) at its release and at its highest speed, shape (2, corners,
        2).

        Both lines are rotated about the hub's centre by one angle. The root of the wire at highest
        speed then stands at the impact angle gamma from the workpart's normal.
        """
        assert self.tool.workpart is not None
        geometry = (self.tool.hub.radius, self.tool.bristle.length, self.tool.workpart.penetration)
        turn = -float(cueing.impact_angle(*geometry)) - float(self.trajectory.hub_angle[-1])
        cosine, sine = math.cos(turn), math.sin(turn)
        rotation = np.array([[cosine, sine], [-sine, cosine]])
        return np.asarray(self.trajectory.centre_line[[0, -1]] @ rotation)


def unplaced(bar: Bar, hub: Hub, bristle: Bristle) -> Bar:
    """Return a bar of the same radius outside the bristle's reach.

    A study that determines the bar's position starts from this bar.
    """
    away = hub.radius + 2.0 * (bristle.length + bristle.wire_diameter + bar.radius)
    return dataclasses.replace(bar, horizontal=min(away, 1e3), vertical=0.0)


def cue_timing(
    tool: Tool,
    retraction: float,
    settings: Settings,
    *,
    bar: Bar | None = None,
    with_reference: bool = True,
) -> Report:
    """Simulate the bristle's release from rest relative to the hub, and compare the bar position
    that follows with that of the cue formulas.

    The comparison is made for up to four belt stiffnesses: that of the tool; the number 0.00041
    printed in the dissertation, in N m per radian; the same number in N m per degree; and the
    stiffness at which the bristle swings at the filmed 254 Hz. Whole passes with a bar are also
    simulated.

    Args:
        tool: the tool.
        retraction: angle by which the bristle is behind the radial direction at the release, rad.
        settings: accuracy and limits of the simulations.
        bar: bar of the whole passes; the tool's bar by default.
        with_reference: whether to also solve the release with the independent reference solver.

    Returns:
        The report of the comparison.

    Raises:
        ValueError: if nothing drives the bristle, the wire bends, the tip cannot reach the workpart
            radially, or the release exceeds the step budget.
    """
    require_rigid(tool)

    readings = {
        "per radian": PRINTED_BELT_STIFFNESS,
        "per degree": math.degrees(PRINTED_BELT_STIFFNESS),
        "from 254 Hz": tool.bristle.inertia_about_root * (2.0 * math.pi * 254.0) ** 2,
    }
    if tool.belt.stiffness not in readings.values():
        readings = {"own": tool.belt.stiffness, **readings}
    bar = bar or tool.bar or Bar()
    timings = {}
    for reading, stiffness in readings.items():
        read = dataclasses.replace(tool, belt=Belt(stiffness, tool.belt.damping_ratio))
        timings[reading] = _timed(read, retraction, settings, bar, with_reference)
    own = next(each for each in timings.values() if each.tool == tool)
    printed: Values = {}
    if tool == Tool(bar=tool.bar) and retraction == RETRACTION_AT_RELEASE:
        printed = dict(zip((*QUANTITIES,)[2:], printed_cue().values(), strict=True))
    quantities = _rows(own, settings, printed)
    passes = [row for each in timings.values() for row in each.passes]
    return Report(
        quantities=quantities,
        **run_fields(own.trajectory),
        extra={"bar_stands_at_deg": passes[-1]["bar_direction_deg"], "full_passes": passes},
        remarks=(
            "The formulas leave out the centrifugal stiffening of the rotating root, which the release includes, and the bar's"
            " dynamics (first tap, swing after the last touch), which a whole pass includes.",
        ),
        tables=(_readings_table(timings),),
        subject=dataclasses.replace(own, readings=timings),
        answer=_answer(quantities[3], own.passes[0]["lag_deg_at_contact"]),
    )


def _answer(direction: Quantity, lag: float | None) -> str:
    if direction.simulated is None:
        return "No bar cues this bristle: its relative speed has no maximum."
    formula = ""
    if direction.theory is not None:
        missed = direction.simulated - direction.theory
        word = "less" if missed < 0.0 else "more"
        formula = (
            f", {amount(abs(missed), 'deg')} {word} than the formula's {direction.theory:.2f}°"
        )
    printed = "" if direction.printed is None else f" (printed: {direction.printed:.2f}°)"
    strike = "has no cued strike" if lag is None else f"strikes {beside_radial(lag)}"
    return f"A release that is fastest at the strike needs the bar at {direction.simulated:.2f}°{formula}{printed}; a whole pass with the bar there {strike}."


def _readings_table(readings: Mapping[str, CueTiming]) -> Table:
    rows = []
    for name, each in readings.items():
        cues = (
            "none" if cue is None else f"{math.degrees(cue.bar_direction):.2f}"
            for cue in (each.simulated, each.formula)
        )
        lags = [None, *(row["lag_deg_at_contact"] for row in each.passes)][-2:]
        strikes = ("no strike" if lag is None else f"{lag:.2f}" for lag in lags)
        rows.append((name, f"{each.tool.belt.stiffness:.5g}", *cues, *strikes))
    stands = f"{next(iter(readings.values())).passes[-1]['bar_direction_deg']:.2f}"
    head = (
        "belt stiffness",
        "N m/rad",
        "bar at, deg",
        "formula, deg",
        "lag there, deg",
        f"lag at {stands} deg, deg",
    )
    return Table("the bar for each reading of the printed belt stiffness", head, tuple(rows))


def _timed(
    tool: Tool, retraction: float, settings: Settings, bar: Bar, with_reference: bool
) -> CueTiming:
    """Simulate the release of the bristle, and two whole passes.

    In the first pass the bar stands at the cue of the release, in the second at the position of
    ``bar``. There is no first pass if the release has no cue.
    """
    start: dict[str, Any] = {
        "start_relative_angle": -retraction,
        "stop_after": "highest relative speed",
    }
    formula = cueing.cue(tool, retraction) if tool.belt.stiffness else None
    bare = dataclasses.replace(tool, bar=None, workpart=None)
    # An overdamped release lasts a small fraction of the period to which the number of samples
    # refers.
    denser = min(max(1.0, 2.0 * bare.belt.damping_ratio), MOST_DAMPED)
    turning = dataclasses.replace(
        settings,
        hub_turn=FULL_TURNS * 2.0 * math.pi,
        samples_per_period=math.ceil(samples_per_period(settings) * denser),
    )
    run = simulate(bare, turning, **start)
    require_result(run, settings)
    estimate = run.cost.error_estimate or 0.0
    if estimate > _tolerance(settings):
        raise ValueError(
            f"accuracy = {settings.accuracy:g}: must be at least {0.1 * estimate:.2g} for this release, as over"
            f" {math.degrees(bare.hub.speed * run.time[-1]):.3g} deg of hub turn its error grows to {estimate:.2g}"
            " (dimensionless)"
        )
    found = _cue(tool, retraction, run)
    reference = None
    places = [(bar.horizontal, bar.vertical)]
    if found is not None:
        places.insert(0, (found.bar_horizontal, found.bar_vertical))
        if with_reference:
            from bristle_sim.reference import simulate_reference

            longest = 2.0 * found.cue_time
            solved = simulate_reference(bare, accuracy=1e-10, duration=longest, **start)
            reference = _cue(tool, retraction, solved)
    bars = (dataclasses.replace(bar, horizontal=x, vertical=y) for x, y in places)
    passes = tuple(full_pass(tool, each, settings) for each in bars)
    return CueTiming(tool, retraction, run, found, formula, reference, bar, passes)


def _cue(tool: Tool, retraction: float, run: Trajectory) -> Cue | None:
    """Return the bar position, cue time and highest speed of a release (Zhang 2020, eq. 2.1).

    The result is None if the angular velocity relative to the hub has no maximum.
    """
    time = run.event_time("highest relative speed")
    if time is None:
        return None
    return cueing.placed_cue(
        tool, retraction, time, run.relative_rate[int(abs(run.time - time).argmin())]
    )


def _rows(timing: CueTiming, settings: Settings, printed: Values) -> tuple[Quantity, ...]:
    """Compare the cue of the simulated release with the cues that the formulas and the reference
    give.

    The tolerances follow from the relative error delta of the angular velocity. The bristle is
    fastest at the instant t at which two torques balance,

        K alpha + c alpha' = 0,

    where alpha is the angle relative to the hub, K the stiffness of belt and centrifugal force, and
    c the coefficient of the belt's damping. The error changes the torque of damping by c delta
    alpha', while the torque K alpha grows by K alpha' per unit time. The instant therefore shifts
    by c delta/K, a relative error of c delta/(K t). An error of the bar's direction changes each
    coordinate of the bar in proportion to the other coordinate.
    """
    tool = timing.tool
    cue = timing.reference
    within = dict[str, float]()
    if cue is not None:
        stiffness = tool.belt.stiffness + cueing.field_stiffness(tool)
        damped = tool.belt_damping / (stiffness * cue.cue_time) if cue.cue_time else 0.0
        allowed = _tolerance(settings)
        within = dict.fromkeys(QUANTITIES, allowed * max(1.0, damped))
        within["highest_relative_speed"] = allowed
        for name in ("bar_horizontal", "bar_vertical"):
            leverage = cue.bar_distance / max(abs(getattr(cue, name)), 1e-300)
            within[name] *= max(1.0, cue.bar_direction) * leverage
    simulated, theory, reference = map(_values, (timing.simulated, timing.formula, cue))
    return rows(QUANTITIES, simulated, theory, reference, printed, within)


def _tolerance(settings: Settings) -> float:
    """Return the largest accepted relative difference of a release from the reference solution."""
    return max(1e-8, 10.0 * settings.accuracy)


def _values(cue: Cue | None) -> Values:
    if cue is None:
        return {}
    turn = math.degrees(cue.hub_turn)
    direction = math.degrees(cue.bar_direction)
    values = (
        cue.cue_time,
        turn,
        cue.highest_relative_speed,
        direction,
        cue.bar_horizontal,
        cue.bar_vertical,
    )
    return dict(zip(QUANTITIES, values, strict=True))
