"""The bristle-blasting tool as a scene: from SI parameters to engine units and back."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

from bristle_sim.parameters import Contact, Tool
from bristle_sim.quantity import quantity, shown, validate
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.contact_laws import ContactLaw, EnergeticLaw, EngineLaw
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.obstacles import BarObstacle, Obstacle, WorkpartObstacle
from bristle_sim.scene.plan import Plan
from bristle_sim.scene.results import note_absences, trajectory_in_si
from bristle_sim.scene.run import run
from bristle_sim.scene.time_scales import longest_interval, stepper_for, time_scale
from bristle_sim.scene.units import Units
from bristle_sim.scene.wire_links import wire_hinges, wire_links
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import EVENTS, checked_event
from bristle_sim.trajectory import Trajectory

__all__ = ["build_tool", "contact_law", "refuse_endless", "simulate"]

METHOD = "pymunk"
"""Says in a trajectory's parameters that the scene was simulated."""

START = -math.pi / 2.0
"""Angle of the root at the start of a pass: 90 degrees before the workpart's normal."""

RETRACTION_LIMIT = math.pi / 2.0
"""Angle of the bristle from the radial direction at which it lies on the hub, rad."""


def tool_units(tool: Tool) -> Units:
    """Return bristle length, bristle mass, and the fastest of belt, hub and gravity as units of the tool's scene."""
    stiffness = tool.belt.stiffness + tool.bristle.mass * (
        tool.hub.radius * tool.bristle.length / 2.0 * tool.hub.speed**2 + tool.gravity * tool.bristle.length
    )
    rate = max(math.sqrt(stiffness / tool.bristle.inertia_about_root), tool.hub.speed)
    return Units(tool.bristle.length, tool.bristle.mass, 1.0 / rate if rate > SLOWEST else 1.0)


SLOWEST = 1e-100
"""Motion slower than this, in rad/s, counts as rest: in its own units energy would be too small a number."""


def build_tool(tool: Tool, *, hub_start: float = START) -> tuple[Scene, Units]:
    """Return the tool's scene with exactly the effects its parameters call for, and the units it runs in."""
    units = tool_units(tool)
    mechanism = Mechanism(
        wire_links(tool.bristle), tool.hub.radius / units.length, tool.hub.speed * units.time, hub_start
    )
    effects = Effects(
        stiffness=tool.belt.stiffness / units.energy if tool.belt.stiffness or tool.belt.damping_ratio else None,
        damping=tool.belt_damping / units.angular_damping,
        gravity=tool.gravity / units.acceleration,
        obstacles=tuple(_obstacles(tool, units, tool.bristle.links)),
        hinges=wire_hinges(tool.bristle, tool.belt.stiffness, units),
    )
    return Scene(mechanism, effects), units


def _obstacles(tool: Tool, units: Units, links: int) -> Iterator[Obstacle]:
    """Yield what the links can touch: the bar any of them, the workpart the tip."""
    if tool.bar is not None:
        centre = (tool.bar.centre[0] / units.length, tool.bar.centre[1] / units.length)
        wire_radius = tool.bristle.wire_diameter / 2.0 / units.length
        of_bar = (tool.bar.radius / units.length, wire_radius, tool.bar.friction, tool.bar.restitution)
        for link in range(links):
            yield BarObstacle(centre, *of_bar, link=link)
    if (part := tool.workpart) is not None:
        surface = (part.friction, part.friction_in_restitution, part.restitution)
        yield WorkpartObstacle(tool.workpart_depth / units.length, *surface, link=links - 1)


def simulate(
    tool: Tool,
    settings: Settings | None = None,
    *,
    start_hub_angle: float = START,
    start_relative_angle: float = 0.0,
    start_relative_rate: float = 0.0,
    stop_after: str | None = None,
) -> Trajectory:
    """Simulate the bristle, a rigid one or a wire of links, in pymunk from a given start.

    Args:
        tool: what to simulate; parts that are None are absent from the scene.
        settings: numerical settings.
        start_hub_angle: of the root from the direction of the workpart, rad.
        start_relative_angle, start_relative_rate: of the bristle relative to the radial direction, rad and rad/s.
        stop_after: name of the event that ends the run, e.g. ``strike`` or ``highest relative speed``.

    Returns:
        The trajectory, in SI units.

    Raises:
        ValueError: if the start is out of range or overlaps an obstacle, no event has that name, a fixed step is too long
            for this tool, rounding hides the accuracy, or a contact resolved in time comes to no end.
    """
    settings, stop_after = _checked(tool, settings, stop_after)
    begin = _Start(start_hub_angle, start_relative_angle, start_relative_rate)
    scene, units = build_tool(tool, hub_start=begin.hub_angle)
    angle, speed = begin.hub_angle + begin.relative_angle, scene.mechanism.hub_speed
    links = len(scene.links)
    start = State(0.0, (angle,) * links, (speed + begin.relative_rate * units.time,) * links)
    _check_start(scene, tool, start)
    plan = _plan(scene, settings, stop_after)
    stepper = stepper_for(scene, settings, units, start, plan.end)
    recording = run(scene, start, stepper, contact_law(tool.contact, settings, units), plan)
    note_absences(recording, tool)
    parameters = {
        "method": METHOD,
        "tool": dataclasses.asdict(tool),
        "settings": dataclasses.asdict(settings),
        "start": dataclasses.asdict(begin),
        "stop_after": stop_after,
    }
    return trajectory_in_si(recording, scene, units, parameters, with_estimate=settings.step is None)


def _checked(tool: object, settings: object, stop_after: str | None) -> tuple[Settings, str | None]:
    """Return the settings, and the name of the event to stop after."""
    if not isinstance(tool, Tool):
        raise ValueError(f"tool = {shown(tool)}: must be a Tool")
    if not isinstance(settings, Settings | None):
        raise ValueError(f"settings = {shown(settings)}: must be Settings or None")
    name = None if stop_after is None else checked_event("stop_after", stop_after, EVENTS)
    return settings or Settings(), name


def _plan(scene: Scene, settings: Settings, stop_after: str | None) -> Plan:
    return Plan(
        end=_end(settings, scene.mechanism.hub_speed),
        accuracy=settings.accuracy,
        stop_after=stop_after,
        longest_interval=longest_interval(scene, settings.samples_per_period),
        maximum_steps=settings.maximum_steps,
        retraction_limit=RETRACTION_LIMIT,
        time_scale=time_scale(scene),
    )


@dataclass(frozen=True, slots=True)
class _Start:
    """Where a run starts, checked."""

    hub_angle: float = quantity(0.0, "start_hub_angle", "rad", at_least=-1e6, at_most=1e6, source="requested")
    relative_angle: float = quantity(
        0.0, "start_relative_angle", "rad", at_least=-RETRACTION_LIMIT, at_most=RETRACTION_LIMIT, source="requested"
    )
    relative_rate: float = quantity(0.0, "start_relative_rate", "rad/s", at_least=-1e9, at_most=1e9, source="requested")

    def __post_init__(self) -> None:
        validate(self)


OVERLAP = 1e-11
"""Fraction of the bristle's length by which rounding lets it overlap what it touches at the start."""

PLACES = {"bar": ("bar_horizontal", "bar_vertical"), "workpart": ("penetration",)}
"""Keys that say where an obstacle stands."""


def _check_start(scene: Scene, tool: Tool, start: State) -> None:
    """Refuse a start in which the bristle stands in an obstacle."""
    poses = scene.mechanism.poses(start)
    for obstacle in scene.effects.obstacles:
        gap = obstacle.touch(poses[obstacle.link], 0.0).gap
        if gap < -OVERLAP:
            part = getattr(tool, obstacle.name)
            given = ", ".join(f"{key} = {getattr(part, key.split('_')[-1]):g}" for key in PLACES[obstacle.name])
            raise ValueError(
                f"{given}: the {obstacle.name} must be clear of the bristle at the start, this one overlaps it by"
                f" {-gap * tool.bristle.length:.3g} (in m)"
            )


REST_PERIODS = 3.0
"""Length of a run on a hub at rest, in the scene's periods."""


def _end(settings: Settings, speed: float) -> float:
    """Return the length of a run for a hub's speed, both in the scene's unit of time."""
    return settings.hub_turn / speed if speed else REST_PERIODS * 2.0 * math.pi


MOST_FIXED_STEPS = 100_000
"""Fixed steps of a whole run; each is an interval of its own: measured, 55 us each, 5 s in all."""


def refuse_endless(tool: Tool, settings: Settings) -> None:
    """Refuse a fixed step so short that a whole run of the tool would take minutes.

    Raises:
        ValueError: if length of run and step, known before anything is computed, give more than ``MOST_FIXED_STEPS``.
    """
    if settings.step is None:
        return
    unit = tool_units(tool).time
    end = _end(settings, tool.hub.speed * unit) * unit
    if end > settings.step * MOST_FIXED_STEPS:
        raise ValueError(
            f"step = {settings.step:g}: must be at least {end / MOST_FIXED_STEPS:.3g} for a run of {end:.3g} s, which else"
            f" takes more than {MOST_FIXED_STEPS} steps (in s)"
        )


ONE_CONTACT = 20_000
"""Engine steps that a contact resolved in time may take, whatever the budget: it counts as one interval."""


def contact_law(contact: Contact, settings: Settings, units: Units) -> ContactLaw:
    """Return the contact law that the parameters name."""
    if contact.law == "compliant":
        duration = None if contact.duration is None else contact.duration / units.time
        return CompliantLaw(duration, settings.accuracy, maximum_steps=max(settings.maximum_steps, ONE_CONTACT))
    return EngineLaw() if contact.law == "engine" else EnergeticLaw()
