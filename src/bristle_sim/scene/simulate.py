"""Public functions that simulate a tool, or a row of bristles, in pymunk from a given start.

When the gap between a link and an obstacle closes, the instant is located and the contact law
resolves the impact. If the link is then pressed onto the obstacle, the contact is sustained, with
Coulomb friction, until its normal force falls to zero. The instant of this release is located too.
Several contacts may be sustained at the same time.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.declared import Declared
from bristle_sim.fields import quantity
from bristle_sim.parameters import Tool
from bristle_sim.parameters.tool import checked_tool
from bristle_sim.scene.build import Scene
from bristle_sim.scene.extrapolation import (
    LEAST_NOISE,
    MOST_DAMPING,
    Extrapolation,
    damped_interval,
)
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.motion import RETRACTION_LIMIT
from bristle_sim.scene.results import trajectories_in_si
from bristle_sim.scene.run import run
from bristle_sim.scene.system import Plan, System
from bristle_sim.scene.tool import ONE_BRISTLE, Row, Units, build_tool, contact_law
from bristle_sim.settings import STOP_AFTER, Settings
from bristle_sim.trajectory import Trajectory
from bristle_sim.units import shown

# values of the entry "method" in a trajectory's parameters
METHOD = "pymunk"
ROW_METHOD = "pymunk, a row of bristles"
REST_PERIODS = 3.0  # duration of a run on a hub at rest, in the bristle's periods of oscillation
OVERLAP_ROUNDING = 1e-11
"""Largest overlap of bristle and obstacle that is accepted at the start as rounding error, as a
fraction of the bristle's length."""

LEAST_NEEDED = 8
MOST_NEEDED = 24
"""Smallest and largest default number of samples in a period of the bristle on its belt.

With fewer samples a drawing is inaccurate. More samples are not worth their computing time,
although cubic interpolation between 24 samples in a period still has an error of 1e-5."""

PLACE_KEYS = {
    "bar": ("bar_horizontal", "bar_vertical"),
    "workpart": ("penetration",),
}  # parameters that determine the positions of the bar and of the workpart


@dataclass(frozen=True, slots=True)
class StartRelativeToHub(Declared):
    """The start: the hub's angle, and the wires' angles and angular velocities relative to the hub.

    Every number is checked against its declared range.
    """

    hub_angle: float = quantity(0.0, "-1e6 <= start_hub_angle <= 1e6 rad [requested]")
    relative_angle: float = quantity(
        0.0, f"{-RETRACTION_LIMIT} <= start_relative_angle <= {RETRACTION_LIMIT} rad [requested]"
    )
    relative_rate: float = quantity(0.0, "-1e9 <= start_relative_rate <= 1e9 rad/s [requested]")


def simulate(
    tool: Tool,
    settings: Settings | None = None,
    *,
    start_hub_angle: float | None = None,
    start_relative_angle: float = 0.0,
    start_relative_rate: float = 0.0,
    stop_after: str | None = None,
) -> Trajectory:
    """Simulate one bristle, rigid or a chain of links, in pymunk from a given start.

    Args:
        tool: the tool; its bar and its workpart may be None, that is, absent.
        settings: numerical settings.
        start_hub_angle: angle of the root from the direction of the workpart, rad; by default
            ``tool.start_hub_angle``.
        start_relative_angle: angle of the bristle from the radial direction, rad.
        start_relative_rate: angular velocity of the bristle relative to the hub, rad/s.
        stop_after: name of the event that ends the run: ``bar touch``, ``bar release``, ``strike``,
            ``workpart touch``, ``workpart release``, ``wire touch``, ``wire release``,
            ``largest retraction``, ``highest relative speed``, ``retraction limit`` or ``jam``.

    Returns:
        The trajectory, in SI units.

    Raises:
        ValueError: if the start is out of range or overlaps an obstacle; if no event has the name
            ``stop_after``; if rounding errors exceed the requested accuracy; if the wire's damping
            requires more steps than ``settings.maximum_steps``; or if the contact law cannot
            resolve the run's first contact.
    """
    begin = (start_hub_angle, start_relative_angle, start_relative_rate)
    system, units, parameters = prepare(tool, settings, begin, stop_after=stop_after)
    for _ in run(system):
        pass
    (simulated,) = trajectories_in_si(tool, system, units, parameters)
    return simulated


def simulate_row(
    tool: Tool,
    settings: Settings | None = None,
    *,
    bristles: int,
    pitch: float,
    neighbour_friction: float,
    neighbour_restitution: float,
    start_hub_angle: float | None = None,
    stop_after: str | None = None,
) -> tuple[Trajectory, ...]:
    """Simulate a row of bristles in one plane in pymunk.

    The bristles can touch each other, the bar and the workpart. All bristles start at the same
    instant, radial and with the hub's angular velocity.

    Args:
        tool: the tool; every bristle has its parameters.
        settings: numerical settings. The run ends when the last root is ``hub_turn`` past the
            starting angle of the foremost root.
        bristles: number of bristles.
        pitch: angle between neighbouring roots, rad.
        neighbour_friction: Coulomb's coefficient of friction mu between two wires.
        neighbour_restitution: energetic coefficient of restitution e* between two wires.
        start_hub_angle: angle of the foremost root from the direction of the workpart, rad; by
            default ``tool.start_hub_angle``.
        stop_after: name of an event; the run ends when every bristle has had this event.

    Returns:
        One trajectory for each bristle, the foremost first, with the same sampling instants. When
        two wires touch, both trajectories have the event ``wire touch`` and a contact record with
        the obstacle ``wire``. The normal of a record points to the trajectory's own bristle.

    Raises:
        ValueError: as for ``simulate``, and if bristles overlap at the start or have no thickness.
    """
    row = Row(bristles, pitch, neighbour_friction, neighbour_restitution)
    begin = (start_hub_angle, 0.0, 0.0)
    system, units, parameters = prepare(tool, settings, begin, row, stop_after=stop_after)
    for _ in run(system):
        pass
    return trajectories_in_si(tool, system, units, parameters)


def prepare(
    tool: Tool,
    settings: Settings | None,
    begin: tuple[float | None, float, float],
    row: Row = ONE_BRISTLE,
    *,
    stop_after: str | None,
) -> tuple[System, Units, dict[str, Any]]:
    """Check the input of a run and prepare the system to be run.

    Args:
        tool, settings, stop_after: as for ``simulate``.
        begin: three numbers: the hub angle at the start (rad), or None for the tool's own start;
            the angle (rad) of every wire relative to its root; the angular velocity (rad/s) of
            every wire relative to its root.
        row: number, pitch and contact parameters of the bristles.

    Returns:
        The system.
        The conversion factors from engine units to SI units.
        The input as a dict of plain numbers and strings.
    """
    tool = checked_tool(tool)
    if not isinstance(settings, Settings | None):
        raise ValueError(f"settings = {shown(settings)}: must be Settings or None")
    stop_after = None if stop_after is None else STOP_AFTER.check(stop_after)
    settings = settings or Settings()
    hub_angle = begin[0]
    described = StartRelativeToHub(
        tool.start_hub_angle if hub_angle is None else hub_angle, *begin[1:]
    )
    scene, units = build_tool(tool, hub_start=described.hub_angle, row=row)
    mechanism = scene.mechanism
    links = range(len(mechanism.links))
    rate = mechanism.hub_speed + described.relative_rate * units.time
    angles = tuple([mechanism.root_angle(0.0, link) + described.relative_angle for link in links])
    start = State(0.0, angles, (rate,) * len(links))
    check_start(scene, tool, start)
    # The run ends when the last root is hub_turn past the starting angle of the foremost root.
    turn = settings.hub_turn + (mechanism.wires - 1) * mechanism.pitch
    speed = mechanism.hub_speed
    plan = Plan(
        end=turn / speed if speed else REST_PERIODS * 2.0 * math.pi,
        accuracy=settings.accuracy,
        stop_after=stop_after,
        longest_interval=2.0 * math.pi / samples_per_period(settings),
        damped_interval=damped_interval(scene),
        maximum_steps=settings.maximum_steps,
        time_scale=time_scale(scene),
        # A bar gives its bristle an angular velocity of the order of the hub's.
        scale=1.0
        if scene.effects.pairs or not mechanism.single_link
        else motion_scale(scene, start),
    )
    damping = tool.bristle.bending_damping_ratio
    least_steps = DAMPED_STEPS * plan.end / plan.damped_interval
    if damping and stop_after is None and least_steps > settings.maximum_steps:
        raise ValueError(
            f"wire_damping_ratio = {damping:g}: must be below {damping * settings.maximum_steps / least_steps:.3g},"
            f" or a run over this hub_turn takes more than {settings.maximum_steps} steps (dimensionless)"
        )
    stepper = stepper_for(scene, settings, plan)
    law = contact_law(tool.contact, settings.accuracy, units.time)
    parameters = {
        "method": METHOD if row is ONE_BRISTLE else ROW_METHOD,
        "tool": dataclasses.asdict(tool),
        "settings": dataclasses.asdict(settings),
        "start": dataclasses.asdict(described),
        "stop_after": stop_after,
    }
    if row is not ONE_BRISTLE:
        parameters["row"] = dataclasses.asdict(row)
    return System(scene, start, stepper, plan, law=law), units, parameters


# Least number of engine steps in the longest interval that resolves damping. With fewer steps the
# difference of two extrapolated results is no estimate of the angular velocities' error.
DAMPED_STEPS = 27

LOCAL_FRACTION = 0.05
"""Error permitted in one interval, as a fraction of the run's accuracy: the errors of twenty
intervals add up to the accuracy."""

SOME_INTERVALS = 50.0
"""Number of intervals above which the permitted error of an interval is reduced, in inverse
proportion to the number.

For a single link it is the number of intervals that damping requires within the belt's relaxation
time c/k. For several links it is the number that damping or vibration requires in the whole run."""


def samples_per_period(settings: Settings) -> int:
    """Return the least number of samples in a period of the bristle on its belt.

    The settings may state this number. Otherwise the number follows from the accuracy: the relative
    error of cubic interpolation is h^4/384 for samples at intervals of h rad of the oscillation.
    """
    if settings.samples_per_period is not None:
        return settings.samples_per_period
    needed: int = math.ceil(math.tau / (384.0 * settings.accuracy) ** 0.25)
    return min(max(LEAST_NEEDED, needed), MOST_NEEDED)


def stepper_for(scene: Scene, settings: Settings, plan: Plan) -> Extrapolation:
    """Return an integrator whose errors are small enough for the requested accuracy of the run.

    Raises:
        ValueError: if the motion is so small that rounding error exceeds the requested accuracy.
    """
    least = LEAST_NOISE / (LOCAL_FRACTION * plan.scale)
    if settings.accuracy < least:
        raise ValueError(
            f"accuracy = {settings.accuracy:g}: must be at least {least:.3g} for so small and slow a motion,"
            " or rounding would hide its errors (dimensionless)"
        )
    if scene.mechanism.single_link:
        stiffness = scene.effects.stiffness
        relaxation = scene.effects.damping / stiffness if stiffness else 0.0
        intervals = min(plan.end, relaxation) / plan.damped_interval
    else:
        intervals = plan.end / min(plan.damped_interval, MOST_DAMPING * plan.time_scale)
    tolerance = settings.accuracy * LOCAL_FRACTION / max(1.0, intervals / SOME_INTERVALS)
    longest = min(2.0 * plan.longest_interval, plan.damped_interval)
    damped_step = plan.damped_interval / DAMPED_STEPS
    return Extrapolation(tolerance * plan.scale, longest=longest, damped_step=damped_step)


def time_scale(scene: Scene) -> float:
    """Return the time scale of the motion, in scene units.

    The time scale is 1/omega, with the angular frequency omega of the straight wire's fastest
    bending mode, but at most 1.
    """
    if not scene.effects.hinge[0]:
        return 1.0
    links = scene.mechanism.wire_links
    twists = np.eye(links)[1:] - np.eye(links)[:-1]
    stiffness = scene.effects.hinge[0] * twists.T @ twists
    mass = scene.mechanism.straight_mass_matrix()
    return 1.0 / math.sqrt(
        max(1.0, np.abs(np.linalg.eigvals(np.linalg.solve(mass, stiffness))).max())
    )


def motion_scale(scene: Scene, start: State) -> float:
    """Return the angular velocity (scene units) by which errors of a free bristle are divided.

    The result is the largest angular velocity relative to the hub that the single rigid bristle
    reaches, but at most 1. A bristle of natural angular frequency w that is released from rest at
    the angle a reaches the angular velocity a w. The result is 1 for a bristle that does not move.
    """
    mechanism = scene.mechanism
    effects = scene.effects
    link = mechanism.links[0]
    field = mechanism.hub_radius * mechanism.hub_speed**2 + effects.gravity
    stiffness = effects.stiffness + link.mass * abs(link.centre) * field
    frequency = math.sqrt(stiffness / link.inertia_about_joint)
    swing = abs(start.angles[0] - mechanism.root_angle(start.time)) * frequency
    return min(max(swing, abs(start.rates[0] - mechanism.hub_speed)), 1.0) or 1.0


def check_start(scene: Scene, tool: Tool, start: State) -> None:
    """Check that no bristle overlaps an obstacle or another bristle at the start.

    Raises:
        ValueError: if there is an overlap; the message states its depth (m).
    """
    poses = scene.mechanism.poses(start)
    for pair in scene.effects.pairs:
        gap = pair.closest(poses, start.rates).gap
        if gap >= -OVERLAP_ROUNDING:
            continue
        overlap = -gap * tool.bristle.length
        if pair.partner is not None:
            raise ValueError(
                f"pitch = {scene.mechanism.pitch:g}: must be one at which bristles are clear of each other at the start,"
                f" these overlap by {overlap:.3g} m (in rad)"
            )
        part = getattr(tool, pair.name)
        given = ", ".join(
            f"{key} = {getattr(part, key.split('_')[-1]):g}" for key in PLACE_KEYS[pair.name]
        )
        raise ValueError(
            f"{given}: the {pair.name} must be clear of the bristle at the start, this one overlaps it by"
            f" {overlap:.3g} (in m)"
        )
