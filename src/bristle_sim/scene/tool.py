"""The bristle-blasting tool as a scene: from SI parameters to engine units and back."""

from __future__ import annotations

import dataclasses
import math
import time as clock
from collections.abc import Iterator

from bristle_sim.parameters import Tool
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact.compliant import contact_law
from bristle_sim.scene.contact.obstacles import BarObstacle, Obstacle, WorkpartObstacle, wire_pairs
from bristle_sim.scene.integrate.stepping import PlainSteps, Stepper
from bristle_sim.scene.integrate.time_scales import checked_step, longest_interval, stepper_for, time_scale
from bristle_sim.scene.mechanism import Mechanism, State
from bristle_sim.scene.plan import Plan
from bristle_sim.scene.results import trajectory_in_si
from bristle_sim.scene.run import run
from bristle_sim.scene.starts import LONE, RETRACTION_LIMIT, Row, Start, StartRelativeToHub, check_start
from bristle_sim.scene.units import Units
from bristle_sim.scene.wire_links import SHORTEST_PIECE, wire_hinges, wire_links
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import EVENTS, checked_name
from bristle_sim.trajectory import Trajectory
from bristle_sim.units import shown

METHOD, ROW_METHOD = "pymunk", "pymunk, a row of bristles"
"""Say in a trajectory's parameters that the scene was simulated."""

ACCURACY = Settings().accuracy
"""Accuracy of contacts resolved in time, where no run has another one."""

START = -math.pi / 2.0
"""Angle of the root at the start of a pass: 90 degrees before the workpart's normal."""


def tool_units(tool: Tool) -> Units:
    """Return bristle length, bristle mass, and the fastest of belt, hub and gravity as units of the tool's scene."""
    stiffness = tool.belt.stiffness + tool.bristle.mass * (
        tool.hub.radius * tool.bristle.length / 2.0 * tool.hub.speed**2 + tool.gravity * tool.bristle.length
    )
    rate = max(math.sqrt(stiffness / tool.bristle.inertia_about_root), tool.hub.speed)
    return Units(tool.bristle.length, tool.bristle.mass, 1.0 / rate if rate > SLOWEST else 1.0)


SLOWEST = 1e-100
"""Motion slower than this, in rad/s, counts as rest: in its own units energy would be too small a number."""


def build_tool(
    tool: Tool, *, hub_start: float = START, row: Row = LONE, accuracy: float = ACCURACY
) -> tuple[Scene, Units]:
    """Return the tool's scene with exactly the effects its parameters call for, and the units it runs in."""
    units = tool_units(tool)
    mechanism = Mechanism(
        wire_links(tool.bristle) * row.bristles,
        tool.hub.radius / units.length,
        tool.hub.speed * units.time,
        hub_start,
        row.bristles,
        row.pitch,
    )
    obstacles = [
        each for wire in range(row.bristles) for each in _obstacles(tool, units, wire * tool.bristle.links, accuracy)
    ]
    if row.bristles > 1:
        wire_radius = tool.bristle.wire_diameter / 2.0 / units.length
        obstacles += wire_pairs(mechanism, wire_radius, row.friction, row.restitution)
    effects = Effects(
        stiffness=tool.belt.stiffness / units.energy if tool.belt.stiffness or tool.belt.damping_ratio else None,
        damping=tool.belt_damping / units.angular_damping,
        gravity=tool.gravity / units.acceleration,
        obstacles=tuple(obstacles),
        hinges=wire_hinges(tool.bristle, tool.belt.stiffness, units) * row.bristles,
    )
    return Scene(mechanism, effects), units


def _obstacles(tool: Tool, units: Units, first: int, accuracy: float) -> Iterator[Obstacle]:
    """Yield what the links of a wire can touch, from its first link on: the bar any of them, the workpart tip and knee."""
    links = tool.bristle.links
    if tool.bar is not None:
        centre = (tool.bar.centre[0] / units.length, tool.bar.centre[1] / units.length)
        wire_radius = tool.bristle.wire_diameter / 2.0 / units.length
        of_bar = (tool.bar.radius / units.length, wire_radius, tool.bar.friction, tool.bar.restitution)
        for link in range(first, first + links):
            yield BarObstacle(centre, *of_bar, link=link)
    if (part := tool.workpart) is not None:
        surface = (part.friction, part.friction_in_restitution, part.restitution)
        law = contact_law(tool.contact, accuracy, units.time)
        for link, corner in [(first + links - 1, -1), *_knees(tool, first)]:
            yield WorkpartObstacle(tool.workpart_depth / units.length, *surface, link=link, law=law, corner=corner)


def _knees(tool: Tool, first: int) -> list[tuple[int, int]]:
    """Return link and corner of each knee of a wire, whose links begin at a number; the tip of a link is its corner -1."""
    links, joint = tool.bristle.links, tool.bristle.knee_position * tool.bristle.links
    if len(tool.bristle.path) == 1:
        return []
    if links > 1 and abs(joint - round(joint)) < links * SHORTEST_PIECE:
        return [(first + round(joint) - 1, -1)]
    return [(first + int(joint), 0)]


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
        ValueError: if the start is out of range or overlaps an obstacle, no event has that name, rounding hides the accuracy,
            or a contact cannot be resolved in time.
    """
    settings, stop_after = _checked(tool, settings, stop_after)
    begin = StartRelativeToHub(start_hub_angle, start_relative_angle, start_relative_rate)
    (run,) = _simulated(tool, settings, _start_relative_to_hub(tool, begin, LONE), LONE, stop_after)
    return run


def simulate_in_steps(
    tool: Tool,
    step: float,
    settings: Settings | None = None,
    *,
    start_hub_angle: float = START,
    start_relative_angle: float = 0.0,
    stop_after: str | None = None,
) -> Trajectory:
    """Simulate the bristle as :func:`simulate` does, but in plain engine steps of a fixed length, s, to compare with.

    It is of first order in the step, and knows nothing of its error.

    Raises:
        ValueError: also if the step is too long for this tool.
    """
    settings, stop_after = _checked(tool, settings, stop_after)
    begin = StartRelativeToHub(start_hub_angle, start_relative_angle)
    (run,) = _simulated(tool, settings, _start_relative_to_hub(tool, begin, LONE), LONE, stop_after, step)
    return run


def simulate_row(
    tool: Tool,
    settings: Settings | None = None,
    *,
    bristles: int,
    pitch: float,
    neighbour_friction: float,
    neighbour_restitution: float,
    start_hub_angle: float = START,
    stop_after: str | None = None,
) -> tuple[Trajectory, ...]:
    """Simulate a row of bristles of one plane that touch each other, bar and workpart, in pymunk.

    All start together, radial and turning with the hub.

    Args:
        tool: what to simulate, each bristle like the others.
        settings: numerical settings; ``hub_turn`` is that of the last bristle, from where the foremost one starts.
        bristles: number of them.
        pitch: angle from each root to the next one, which follows it, rad.
        neighbour_friction, neighbour_restitution: Coulomb's coefficient and the energetic one between two wires.
        start_hub_angle: of the foremost root from the direction of the workpart, rad.
        stop_after: name of an event; the run ends when every bristle has had it.

    Returns:
        One trajectory for each bristle, the foremost first, at common instants. The touch of two wires is the event
        ``wire touch`` of both; the obstacle of its contact records, in which each has its own normal, is ``wire``.

    Raises:
        ValueError: as for ``simulate``, and if bristles overlap at the start.
    """
    settings, stop_after = _checked(tool, settings, stop_after)
    row = Row(bristles, pitch, neighbour_friction, neighbour_restitution)
    begin = StartRelativeToHub(start_hub_angle)
    return _simulated(tool, settings, _start_relative_to_hub(tool, begin, row), row, stop_after)


def _start_relative_to_hub(tool: Tool, begin: StartRelativeToHub, row: Row) -> Start:
    """Return a start in which every wire has the same angle and rate relative to its root."""
    links = range(row.bristles * tool.bristle.links)
    angles = tuple(begin.hub_angle - link // tool.bristle.links * row.pitch + begin.relative_angle for link in links)
    return Start(begin.hub_angle, angles, (begin.relative_rate,) * len(links), described=dataclasses.asdict(begin))


def _simulated(
    tool: Tool, settings: Settings, begin: Start, row: Row, stop_after: str | None, step: float | None = None
) -> tuple[Trajectory, ...]:
    """Return the run of each bristle."""
    scene, units = build_tool(tool, hub_start=begin.hub_angle, row=row, accuracy=settings.accuracy)
    speed = scene.mechanism.hub_speed
    start = State(0.0, begin.angles, tuple(speed + rate * units.time for rate in begin.relative_rates))
    check_start(scene, tool, start)
    plan = _plan(scene, settings, stop_after)
    if step is None:
        stepper: Stepper = stepper_for(scene, settings, start, plan.end)
    else:
        stepper = PlainSteps(checked_step(scene, step, settings.samples, units) / units.time)
    wall, cpu, steps = clock.perf_counter(), clock.process_time(), scene.steps
    recording = run(scene, start, stepper, plan)
    recording.cost = (clock.perf_counter() - wall, clock.process_time() - cpu, scene.steps - steps)
    parameters = {
        "method": METHOD if row is LONE else ROW_METHOD,
        "tool": dataclasses.asdict(tool),
        "settings": dataclasses.asdict(settings),
        "start": begin.described,
        "stop_after": stop_after,
    }
    if row is not LONE:
        parameters["row"] = dataclasses.asdict(row)
    return tuple(
        trajectory_in_si(recording, scene, units, parameters, with_estimate=step is None, wire=wire)
        for wire in range(row.bristles)
    )


def _checked(tool: object, settings: object, stop_after: str | None) -> tuple[Settings, str | None]:
    """Return the settings, and the name of the event to stop after."""
    if not isinstance(tool, Tool):
        raise ValueError(f"tool = {shown(tool)}: must be a Tool")
    if not isinstance(settings, Settings | None):
        raise ValueError(f"settings = {shown(settings)}: must be Settings or None")
    name = None if stop_after is None else checked_name("stop_after", stop_after, EVENTS)
    return settings or Settings(), name


def _plan(scene: Scene, settings: Settings, stop_after: str | None) -> Plan:
    return Plan(
        end=_end(settings, scene.mechanism),
        accuracy=settings.accuracy,
        stop_after=stop_after,
        longest_interval=longest_interval(scene, settings.samples),
        maximum_steps=settings.maximum_steps,
        retraction_limit=RETRACTION_LIMIT,
        time_scale=time_scale(scene),
    )


REST_PERIODS = 3.0
"""Length of a run on a hub at rest, in the scene's periods."""


def _end(settings: Settings, mechanism: Mechanism) -> float:
    """Return the length of a run in the scene's unit of time: the last wire turns as far as requested."""
    if not mechanism.hub_speed:
        return REST_PERIODS * 2.0 * math.pi
    return (settings.hub_turn + (mechanism.wires - 1) * mechanism.pitch) / mechanism.hub_speed
