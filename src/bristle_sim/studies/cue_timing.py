"""Compares the bar position of the quasi-static cue formulas with that of a simulated release from rest.

In the formulas an undamped belt swings the bristle for a quarter period while the hub turns. They leave out the rotating
root's centrifugal stiffening and the bar's own effects: the impact of first touch, the swing that continues after the last
touch. The simulated release includes the first, a whole pass the second too.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, Values
from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.cue_places import (
    BarPlace,
    ReadingPlaces,
    Release,
    formula_cue,
    formula_release,
    seen_at_strike,
    simulated_cue,
    stiffness_readings,
)
from bristle_sim.studies.inertia_driven import WIRE_RUNS, Run, reference_run, scene_run, until_radial
from bristle_sim.studies.strike_point import ran, require_result
from bristle_sim.theory.cueing import Cue, field_stiffness
from bristle_sim.trajectory import Trajectory

OWN = "own"
"""Name of the tool's belt stiffness where it is none of the readings."""

UNITS = {
    "cue_time": "s",
    "cue_hub_turn_deg": "deg",
    "highest_relative_speed": "rad/s",
    "bar_direction_deg": "deg",
    "bar_horizontal": "m",
    "bar_vertical": "m",
}

PRINTED = {
    "highest_relative_speed": 845.6,
    "bar_direction_deg": math.degrees(math.atan2(0.05037, 0.0225)),
    "bar_horizontal": 0.05037,
    "bar_vertical": 0.0225,
}
"""Zhang 2020, eqs. 2.2 and 2.3; the direction is A + theta_1 + gamma."""

FULL_TURNS = 1e3
"""Hub turns after which a bristle that still accelerates is given up: only an extremely soft belt takes as long."""

MOST_DAMPED = 10.0
"""Samples of a damped release are at most this many times as dense; beyond it the scene's own steps are as short."""

LEFT_OUT = (
    "left out by the formulas: centrifugal stiffening of the rotating root, belt damping beyond the linear oscillator,",
    "and the bar's dynamics (first tap, swing beyond the last touch), which a full pass simulates.",
)

OF_WIRE = (
    "a wire that bends is cued when its tip is radial, where an undamped rigid bristle is fastest; its lag and its rate are",
    "those of the line from root to tip.",
)


@dataclass(frozen=True, slots=True)
class CueTiming:
    """A simulated release, that of the formula, and the bars that they need.

    The trajectory is the release from the retraction, rad, up to the highest relative speed; ``formula`` the quasi-static
    formula's motion, None without belt stiffness; ``bar`` stands where its keys put it. ``places`` are those for the readings of
    the belt stiffness, ``own`` the name of the tool's among them. ``released`` and ``fastest`` are centre lines of the
    simulated wire, (corners, 2), m, at both ends of the release; None if no speed is the highest.
    """

    tool: Tool
    retraction: float
    bar: Bar
    trajectory: Trajectory
    formula: Release | None
    own: str
    places: dict[str, ReadingPlaces]
    released: Array | None
    fastest: Array | None


def unplaced(bar: Bar, hub: Hub, bristle: Bristle) -> Bar:
    """Return a bar of the same radius out of the bristle's reach, for a question whose answer is the bar's position."""
    away = hub.radius + 2.0 * (bristle.length + bristle.wire_diameter + bar.radius)
    return dataclasses.replace(bar, horizontal=min(away, 1e3), vertical=0.0)


def cue_timing(
    tool: Tool, retraction: float, settings: Settings, *, bar: Bar | None = None, with_reference: bool = True
) -> Report:
    """Simulate the release from rest at a retraction (rad) and place the bar by what came out.

    ``bar`` is the bar as it stands, with which whole passes are simulated; by default the tool's.

    Raises:
        ValueError: if nothing drives the bristle, the tip cannot reach the workpart radially, or the release is not
            computed within the settings' steps.
    """
    given = bar or tool.bar or Bar()
    if tool.bristle.links > 1:
        settings = dataclasses.replace(settings, maximum_steps=max(1, settings.maximum_steps // WIRE_RUNS))
    run = _release(tool, retraction, settings)
    found = _rows(tool, retraction, run, settings, UNITS, with_reference=with_reference)
    places: dict[str, ReadingPlaces] = {}
    for reading, stiffness in stiffness_readings(tool).items():
        read = dataclasses.replace(tool, belt=Belt(stiffness, tool.belt.damping_ratio))
        released = run if read == tool else _release(read, retraction, settings)
        names = ("cue_time", "bar_direction_deg")
        found += _rows(read, retraction, released, settings, names, reading, with_reference=with_reference)
        places[reading] = ReadingPlaces.of(reading, read, retraction, released, given, settings)
    mine = next((name for name, each in places.items() if each.stiffness == tool.belt.stiffness), OWN)
    if mine == OWN:
        places = {OWN: ReadingPlaces.of(OWN, tool, retraction, run, given, settings), **places}
    lines = (None, None) if places[mine].simulated is None else seen_at_strike(tool, run)
    formula = formula_release(tool, retraction)
    return Report(
        outcome=None,
        quantities=tuple(found),
        **ran(run),
        extra={
            "bar_stands_at_deg": math.degrees(BarPlace.of(given).direction),
            "full_passes": [row for each in places.values() for row in each.pass_rows(given)],
        },
        remarks=(
            *(line for each in places.values() for line in each.in_words(given)),
            *LEFT_OUT,
            *(OF_WIRE if tool.bristle.links > 1 else ()),
        ),
        subject=CueTiming(tool, retraction, given, run, formula, mine, places, *lines),
    )


def _bare(tool: Tool) -> Tool:
    """Return the tool without the bar and the workpart that it must have."""
    if tool.bar is None or tool.workpart is None:
        raise ValueError("bar, workpart: must both be parts of the tool")
    return dataclasses.replace(tool, bar=None, workpart=None)


def _release(tool: Tool, retraction: float, settings: Settings) -> Trajectory:
    if tool.bristle.links > 1:
        return _released_wire(tool, scene_run(settings, retraction))
    # An overdamped release is over in a small part of the period that samples are counted in.
    samples = math.ceil(settings.samples_per_period * min(max(1.0, 2.0 * tool.belt.damping_ratio), MOST_DAMPED))
    turning = dataclasses.replace(settings, hub_turn=FULL_TURNS * 2.0 * math.pi, samples_per_period=samples)
    run = simulate(_bare(tool), turning, start_relative_angle=-retraction, stop_after="highest relative speed")
    require_result(run, settings)
    estimate = run.cost.error_estimate
    if estimate is not None and estimate > _tolerance(settings):
        raise ValueError(
            f"accuracy = {settings.accuracy:g}: must be at least {0.1 * estimate:.2g} for this release, in whose"
            f" {math.degrees(tool.hub.speed * run.time[-1]):.3g} deg of hub turn errors of {estimate:.2g} add up"
            " (dimensionless)"
        )
    return run


def _released_wire(tool: Tool, run: Run) -> Trajectory:
    radial = until_radial(_bare(tool), run)
    if radial is None:
        raise ValueError(
            f"wire_links = {tool.bristle.links}: must be 1 for a bristle that does not come back to the radial direction, where"
            " a wire that bends is cued (dimensionless)"
        )
    return radial.trajectory


def _tolerance(settings: Settings) -> float:
    """Return the relative difference from the reference that a release may have."""
    return max(1e-8, 10.0 * settings.accuracy)


def _rows(
    tool: Tool,
    retraction: float,
    run: Trajectory,
    settings: Settings,
    names: Iterable[str],
    reading: str = "",
    *,
    with_reference: bool,
) -> list[Quantity]:
    """Return one belt stiffness's release by simulation, formula and reference, which judges it."""
    simulated, theory = _values(simulated_cue(tool, retraction, run)), _values(formula_cue(tool, retraction))
    time, reference, printed = simulated["cue_time"], _values(None), _at_print(tool, retraction, any_belt=bool(reading))
    if with_reference and tool.bristle.links > 1:
        referred = _released_wire(tool, reference_run(1e-10, retraction))
        reference = _values(simulated_cue(tool, retraction, referred))
    elif with_reference and time is not None:
        from bristle_sim.reference import simulate_reference

        referred = simulate_reference(
            _bare(tool),
            start_relative_angle=-retraction,
            accuracy=1e-10,
            duration=2.0 * time,
            stop_after="highest relative speed",
        )
        reference = _values(simulated_cue(tool, retraction, referred))
    found = []
    for name in names:
        sides = (simulated[name], theory[name], reference[name], printed.get(name))
        within = None if sides[2] is None else _tolerance(settings) * _conditioning(name, reference, tool)
        found.append(Quantity(f"{name}_{reading}" if reading else name, UNITS[name], *sides, within))
    return found


def _values(cue: Cue | None) -> Values:
    if cue is None:
        return dict.fromkeys(UNITS)
    degrees = (math.degrees(cue.hub_turn), math.degrees(cue.bar_direction))
    place = (cue.bar_horizontal, cue.bar_vertical)
    return dict(zip(UNITS, (cue.cue_time, degrees[0], cue.highest_relative_speed, degrees[1], *place), strict=True))


def _conditioning(name: str, values: Values, tool: Tool) -> float:
    """Return the factor by which a quantity magnifies a relative error of the motion.

    Highest is the rate where the torques of belt and damping balance, and they leave it as alpha''' = -(K/I) alpha': an
    error delta of the rate, relative, moves that instant t by c delta/K, which is c/(K t) times delta of it. A coordinate
    of the bar magnifies what turns the bar, some delta of its direction, by the other coordinate over this one.
    """
    time = values["cue_time"]
    if name == "highest_relative_speed" or not time:
        return 1.0
    timing = max(1.0, tool.belt_damping / ((tool.belt.stiffness + field_stiffness(tool)) * time))
    if name not in ("bar_horizontal", "bar_vertical"):
        return timing
    distance = math.hypot(values["bar_horizontal"] or 0.0, values["bar_vertical"] or 0.0)
    turned = max(1.0, math.radians(values["bar_direction_deg"] or 0.0))
    return timing * turned * distance / max(abs(values[name] or 0.0), 1e-300)


def _at_print(tool: Tool, retraction: float, *, any_belt: bool) -> Values:
    """Return the printed numbers if the tool is the printed one, apart from its belt stiffness if that may differ."""
    own = Tool()
    same = (tool.hub, tool.bristle, tool.workpart) == (own.hub, own.bristle, own.workpart)
    belt = Belt(tool.belt.stiffness, own.belt.damping_ratio) if any_belt else own.belt
    return PRINTED if same and retraction == math.radians(44.5) and tool.belt == belt else {}
