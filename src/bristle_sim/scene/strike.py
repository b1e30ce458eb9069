"""One impact of a chain of rods, or of a wire that bends, on a flat surface, through the scene."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bristle_sim.parameters import Contact, Surface, Tool
from bristle_sim.quantity import Range, shown
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.contact_laws import Coefficients, ContactLaw, EnergeticLaw
from bristle_sim.scene.contact_motion import SAMPLES
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.obstacles import WorkpartObstacle
from bristle_sim.scene.repetitions import WIDE
from bristle_sim.scene.results import contact_in_si
from bristle_sim.scene.time_scales import damped_interval
from bristle_sim.scene.tool import contact_law
from bristle_sim.scene.units import Units
from bristle_sim.scene.wire_links import wire_hinges, wire_links
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord

__all__ = ["Chain", "ChainStrike", "WireStrike", "build_strike", "strike", "strike_wire", "wire_frequencies"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Chain:
    """Rods in order from the root, at the instant of impact; SI units.

    Angles are measured from the direction that points at the surface, rates are absolute, both positive in the hub's
    sense of rotation; a root on a hub stands at ``hub_angle``.

    Raises:
        ValueError: for numbers out of range, or masses, lengths, angles and rates that are not equally many.
    """

    masses: tuple[float, ...]
    lengths: tuple[float, ...]
    angles: tuple[float, ...]
    rates: tuple[float, ...]
    hub_radius: float = 0.0
    hub_speed: float = 0.0
    hub_angle: float = 0.0

    def __post_init__(self) -> None:
        """Check every number: a mass that is none ends the process inside the engine."""
        for name in ("masses", "lengths", "angles", "rates"):
            if not isinstance(getattr(self, name), tuple | list):
                raise ValueError(f"{name} = {shown(getattr(self, name))}: must be one number for each rod")
        counts = [len(column) for column in (self.masses, self.lengths, self.angles, self.rates)]
        if len(set(counts)) > 1 or not counts[0]:
            raise ValueError(
                f"masses, lengths, angles, rates: {', '.join(map(str, counts))} of them; must be equally many of each, at"
                " least one"
            )
        for declared, column in zip(_RODS, (self.masses, self.lengths, self.angles, self.rates), strict=True):
            for value in column:
                declared.check(value)
        for declared, value in zip(_HUB, (self.hub_radius, self.hub_speed, self.hub_angle), strict=True):
            declared.check(value)
        for mass, following in itertools.pairwise(self.masses):
            _RATIO.check(mass / following)


_RODS = (
    Range("mass", "kg", 1e-60, 1e21, lowest_allowed=True, source="chosen: 1e15 times the heaviest bristle"),
    Range("length", "m", 1e-30, 1e6, lowest_allowed=True, source="chosen: 1e3 times the longest bristle"),
    Range("angle", "rad", -1e6, 1e6, lowest_allowed=True, source="chosen: beyond it an angle has no digits to spare"),
    Range("rate", "rad/s", -1e15, 1e15, lowest_allowed=True, source="chosen: beyond any hub's"),
)
_HUB = (
    Range("hub_radius", "m", 0.0, 1e3, lowest_allowed=True, source="chosen: the largest hub"),
    Range("hub_speed", "rad/s", -1e9, 1e9, lowest_allowed=True, source="chosen: beyond any hub's, in either sense"),
    Range("hub_angle", "rad", -1e6, 1e6, lowest_allowed=True, source="as for the rods"),
)
_RATIO = Range(
    "mass_ratio", "1", 1e-9, 1e15, lowest_allowed=True, source="chosen: 1e15 is the last at which the heavier yields"
)


@dataclass(frozen=True, slots=True)
class ChainStrike:
    """An impact and what it did to the kinetic energy, J.

    ``centre_line`` is root, hinges and tip at the first touch, (x, y) from the hub's centre, shape (corners, 2), m.
    """

    contact: ContactRecord
    centre_line: Array
    kinetic_energy_before: float
    kinetic_energy_after: float
    steps: int
    wall_s: float

    @property
    def kinetic_energy_ratio(self) -> float | None:
        """After over before; None for a chain at rest."""
        return self.kinetic_energy_after / self.kinetic_energy_before if self.kinetic_energy_before else None


def strike(chain: Chain, surface: Surface, contact: Contact, settings: Settings) -> ChainStrike:
    """Let the last rod's tip strike a surface that it touches, by the requested contact law.

    A tip that does not approach leaves at once, whatever the law.

    Raises:
        ValueError: if a compliant contact comes to no end.
    """
    kinds: dict[str, tuple[object, type]] = {
        "chain": (chain, Chain),
        "surface": (surface, Surface),
        "contact": (contact, Contact),
        "settings": (settings, Settings),
    }
    for name, (value, kind) in kinds.items():
        if not isinstance(value, kind):
            raise ValueError(f"{name} = {shown(value)}: must be a {kind.__name__}")
    begin = clock.perf_counter()
    scene, start, obstacle, units = build_strike(chain, surface)
    approach = obstacle.touch(scene.mechanism.poses(start)[-1], start.rates[-1]).velocity[0]
    law: ContactLaw = contact_law(contact, settings, units) if approach < 0.0 else EnergeticLaw()
    after, record = law.resolve(scene, start, obstacle, Coefficients.of(obstacle))
    sample = (np.array([start.time]), np.array([start.angles]), np.array([start.rates]))
    return ChainStrike(
        contact=contact_in_si(record, units),
        centre_line=scene.mechanism.centre_line(*sample)[0][0] * units.length,
        kinetic_energy_before=scene.mechanism.kinetic_energy(start) * units.energy,
        kinetic_energy_after=scene.mechanism.kinetic_energy(after) * units.energy,
        steps=scene.steps,
        wall_s=clock.perf_counter() - begin,
    )


SLOWEST = 1e-300
"""Rates below this, in rad/s, have no reciprocal to serve as a unit of time, and are small in that of this one."""


def build_strike(chain: Chain, surface: Surface) -> tuple[Scene, State, WorkpartObstacle, Units]:
    """Return the chain's scene with its tip on the surface, the state at that instant, and the scene's units."""
    fastest = max(*(abs(rate) for rate in chain.rates), abs(chain.hub_speed))
    units = Units(chain.lengths[-1], chain.masses[-1], 1.0 / max(fastest, SLOWEST) if fastest else 1.0)
    links = tuple(
        Link.rod(mass / units.mass, length / units.length)
        for mass, length in zip(chain.masses, chain.lengths, strict=True)
    )
    mechanism = Mechanism(links, chain.hub_radius / units.length, chain.hub_speed * units.time, chain.hub_angle)
    start = State(0.0, chain.angles, tuple(rate * units.time for rate in chain.rates))
    height = mechanism.poses(start)[-1].tip[1]
    obstacle = WorkpartObstacle(-height, surface.friction, surface.friction_in_restitution, surface.restitution)
    return Scene(mechanism, Effects(obstacles=(obstacle,))), start, obstacle, units


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
        duration: expected of the contact, s, of which samples are at most a 24th apart; one ten times as long ends there.
        flight: time of free motion after the release, s.

    Raises:
        ValueError: if the wire's end does not approach the workpart, the numbers are not one for each link, the wire has too
            many links for the scene, or the contact comes to no end.
    """
    begin = clock.perf_counter()
    scene, units, obstacle = _build_wire(tool, hub_angle, angles, rates)
    states = [State(0.0, tuple(angles), tuple(rate * units.time for rate in rates))]
    approach = obstacle.touch(scene.mechanism.poses(states[0])[-1], states[0].rates[-1]).velocity[0]
    if approach >= 0.0:
        raise ValueError(
            f"rates = {shown(rates[-1])}: must let the wire's end approach the workpart, its normal velocity is"
            f" {approach * units.velocity:g} m/s (in rad/s)"
        )
    law = CompliantLaw(
        duration / units.time,
        settings.accuracy,
        maximum_steps=settings.maximum_steps,
        stiffness=stiffness * units.time**2 / units.mass,
        observe=states.append,
    )
    after, record = law.resolve(scene, states[0], obstacle, Coefficients.of(obstacle))
    states = [state for state in states[1:] if state.time <= after.time]
    states += _flight(scene, after, flight / units.time, duration / units.time, settings)
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


def _build_wire(
    tool: Tool, hub_angle: float, angles: Sequence[float], rates: Sequence[float]
) -> tuple[Scene, Units, WorkpartObstacle]:
    """Return the scene of a tool's wire, its units, and the workpart through the wire's end."""
    bristle, part = tool.bristle, tool.workpart
    if part is None:
        raise ValueError("workpart = None: must be a Workpart, or nothing is struck")
    if len(angles) != bristle.links or len(rates) != bristle.links:
        raise ValueError(
            f"angles, rates: {len(angles)}, {len(rates)} of them; must be one for each of the {bristle.links} links"
        )
    fastest = max(*(abs(rate) for rate in rates), tool.hub.speed) or 1.0
    units = Units(bristle.length, bristle.mass, 1.0 / max(fastest, SLOWEST))
    mechanism = Mechanism(
        wire_links(bristle), tool.hub.radius / units.length, tool.hub.speed * units.time, hub_start=hub_angle
    )
    start = State(0.0, tuple(angles), (0.0,) * bristle.links)
    obstacle = WorkpartObstacle(
        -mechanism.poses(start)[-1].tip[1], part.friction, part.friction_in_restitution, part.restitution
    )
    effects = Effects(
        stiffness=tool.belt.stiffness / units.energy if tool.belt.stiffness else None,
        damping=tool.belt_damping / units.angular_damping,
        gravity=tool.gravity / units.acceleration,
        obstacles=(obstacle,),
        hinges=wire_hinges(bristle, tool.belt.stiffness, units),
    )
    scene = Scene(mechanism, effects)
    if not scene.solves_joints:
        raise ValueError(
            f"wire_links = {bristle.links}: must be fewer, the engine's solver takes too many iterations (dimensionless)"
        )
    return scene, units, obstacle


SMALL_ANGLE = 1e-8
"""Angle of a link, rad, at which its mass matrix differs from that of the straight wire by 5e-17 of itself."""


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
    scene, units, _ = _build_wire(still, 0.0, straight, straight)
    step, columns = SMALL_ANGLE, []
    for turned in range(tool.bristle.links):
        angles = tuple(SMALL_ANGLE * (link == turned) for link in range(tool.bristle.links))
        scene.place(State(0.0, angles, straight))
        scene.step(step, 1)
        columns.append(np.array(scene.rates()) / (SMALL_ANGLE * step))
    squares = np.sort(-np.linalg.eigvals(np.array(columns).T).real)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (math.tau * units.time))


def _flight(scene: Scene, start: State, duration: float, contact: float, settings: Settings) -> list[State]:
    """Return samples of the free motion after a contact, as far apart as in it."""
    longest = min(contact / SAMPLES, damped_interval(scene))
    stepper = Extrapolation(0.1 * settings.accuracy, max(1.0, *map(abs, start.rates)), WIDE, longest)
    found, end = [start], start.time + duration
    while (left := end - found[-1].time) > 1e-9 * contact:
        length = stepper.propose(left)
        result = stepper.advance(scene, found[-1], length)
        if stepper.accepts(result, length):
            found.append(result.state)
    return found[1:]
