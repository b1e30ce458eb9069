"""One strike of a wire that bends on a workpart of finite contact stiffness, through the scene, and the wire's frequencies."""

from __future__ import annotations

import dataclasses
import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.scene.build import Scene
from bristle_sim.scene.contact.compliant import SAMPLES_OF_A_COURSE, CompliantLaw
from bristle_sim.scene.contact.obstacles import WorkpartObstacle
from bristle_sim.scene.integrate.extrapolation import WIDE, Extrapolation
from bristle_sim.scene.integrate.time_scales import damped_interval
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.results import contact_in_si
from bristle_sim.scene.strike import struck
from bristle_sim.scene.tool import Units, build_tool
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord
from bristle_sim.units import shown


@dataclass(frozen=True, slots=True)
class WireStrike:
    """A contact of a wire that bends, resolved in time, and its free motion afterwards; SI units.

    Attributes:
        contact: from the first touch to the release, with its history.
        time, angles, rates: samples from the first touch on, s, and of the links' absolute angles and rates, shape
            (samples, links), rad and rad/s.
        centre_line: root, knee, joints and tip from the hub's centre, shape (samples, corners, 2), m.
        steps, wall_s: cost.
    """

    contact: ContactRecord
    time: Array
    angles: Array
    rates: Array
    centre_line: Array
    steps: int
    wall_s: float


def strike_wire(
    tool: Tool,
    hub_angle: float,
    angles: Sequence[float],
    rates: Sequence[float],
    stiffness: float,
    settings: Settings,
    *,
    duration: float,
    flight: float = 0.0,
) -> WireStrike:
    """Let the end of a wire strike a workpart of finite contact stiffness, which it touches.

    The contact is a spring of stiffness k while the penetration grows and k/e*^2 otherwise. Belt and hinges act meanwhile.

    Args:
        tool: with a workpart, whose surface passes through the wire's end; its bar is left out.
        hub_angle: psi at the first touch, rad.
        angles, rates: absolute angles and rates of the links then, rad and rad/s.
        stiffness: of the contact in compression, N/m.
        settings: of the scene.
        duration: expected duration of the contact, s. Samples are at most a 24th of it apart, and the contact of a rigid bristle
            is ended after ten times that long.
        flight: time of free motion after the release, s.

    Raises:
        ValueError: if the wire's end does not approach the workpart, the numbers are not one for each link, or the contact
            comes to no end.
    """
    begin = clock.perf_counter()
    scene, units, obstacle = build_wire(tool, hub_angle, angles, rates)
    start = State(0.0, tuple(angles), tuple(rate * units.time for rate in rates))
    approach = obstacle.closest(scene.mechanism.poses(start), start.rates).velocity[0]
    if approach >= 0.0:
        raise ValueError(
            f"rates = {shown(rates[-1])}: must let the wire's end approach the workpart, its normal velocity is"
            f" {approach * units.velocity:g} m/s (in rad/s)"
        )
    law = CompliantLaw(duration / units.time, settings.accuracy, stiffness=stiffness * units.time**2 / units.mass)
    after, record, states = struck(scene, start, dataclasses.replace(obstacle, law=law), settings)
    states = states[1:] + free_flight(scene, after, flight / units.time, duration / units.time, settings)
    time, angles_, rates_ = (np.array(column) for column in zip(*states, strict=True))
    return WireStrike(
        contact=contact_in_si(record, units),
        time=time * units.time,
        angles=angles_,
        rates=rates_ / units.time,
        centre_line=scene.mechanism.centre_line(time, angles_, rates_)[0] * units.length,
        steps=scene.steps,
        wall_s=clock.perf_counter() - begin,
    )


def build_wire(
    tool: Tool, hub_angle: float, angles: Sequence[float], rates: Sequence[float]
) -> tuple[Scene, Units, WorkpartObstacle]:
    """Return the scene of a tool's wire, its units, and the workpart through the wire's end."""
    links, part = tool.bristle.links, tool.workpart
    if part is None:
        raise ValueError("workpart = None: must be a Workpart, or nothing is struck")
    if len(angles) != links or len(rates) != links:
        raise ValueError(
            f"angles, rates: {len(angles)}, {len(rates)} of them; must be one for each of the {links} links"
        )
    scene, units = build_tool(dataclasses.replace(tool, bar=None), hub_start=hub_angle)
    height = scene.mechanism.poses(State(0.0, tuple(angles), (0.0,) * links))[-1].tip[1]
    return scene, units, WorkpartObstacle(-height, part.friction, part.friction_in_restitution, part.restitution)


SMALL_ANGLE = 1e-8
"""Angle of a link, rad, at which its mass matrix differs from that of the straight wire by 5e-17 of itself."""

SHORT_STEP = 1e-8
"""Length of the step from rest, in the scene's time units; the rates it gives are in proportion to it."""


def wire_frequencies(tool: Tool) -> Array:
    """Return the natural frequencies of a tool's undamped wire on a hub at rest, in Hz, ascending, shape (links,).

    One engine step from rest with one link turned by a small angle gives every link a rate, which is a column of the matrix
    -M^-1 K times angle and step: nothing moves before the rates change.
    """
    straight = (0.0,) * tool.bristle.links
    bristle = dataclasses.replace(tool.bristle, bending_damping_ratio=0.0)
    still = dataclasses.replace(
        tool,
        hub=dataclasses.replace(tool.hub, speed=0.0),
        belt=dataclasses.replace(tool.belt, damping_ratio=0.0),
        bristle=bristle,
        gravity=0.0,
    )
    scene, units, _ = build_wire(still, 0.0, straight, straight)
    columns = []
    for turned in range(tool.bristle.links):
        angles = tuple(SMALL_ANGLE * (link == turned) for link in range(tool.bristle.links))
        scene.place(State(0.0, angles, straight))
        scene.step(SHORT_STEP, 1)
        columns.append(np.array(scene.rates()) / (SMALL_ANGLE * SHORT_STEP))
    squares = np.sort(-np.linalg.eigvals(np.array(columns).T).real)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (math.tau * units.time))


def free_flight(scene: Scene, start: State, duration: float, contact: float, settings: Settings) -> list[State]:
    """Return samples of the free motion after a contact, as far apart as in it, while a tenth of the budget of steps lasts."""
    longest = min(contact / SAMPLES_OF_A_COURSE, damped_interval(scene))
    stepper = Extrapolation(0.1 * settings.accuracy, max(1.0, *map(abs, start.rates)), WIDE, longest)
    found, end, last = [start], start.time + duration, scene.work + settings.maximum_steps // 10
    while (left := end - found[-1].time) > 1e-9 * contact and scene.work < last:
        length = min(stepper.propose(left), longest)
        result = stepper.advance(scene, found[-1], length)
        if stepper.accepts(result, length):
            found.append(result.state)
    return found[1:]
