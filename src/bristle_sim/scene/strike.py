"""One impact of a chain of rods on a flat surface, through the scene."""

from __future__ import annotations

import dataclasses
import itertools
import math
import time as clock
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact.compliant import contact_law
from bristle_sim.scene.contact.laws import ENERGETIC, Coefficients
from bristle_sim.scene.contact.obstacles import Obstacle, WorkpartObstacle
from bristle_sim.scene.integrate.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.progress import SLOW_FRACTION, Plan
from bristle_sim.scene.results import contact_in_si
from bristle_sim.scene.run import run
from bristle_sim.scene.tool import Units
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import ContactRecord
from bristle_sim.units import Range, shown


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
    law = contact_law(contact, settings.accuracy, units.time)
    after, record, _ = struck(scene, start, dataclasses.replace(obstacle, law=law), settings)
    poses = scene.mechanism.poses(start)
    return ChainStrike(
        contact=contact_in_si(record, units),
        centre_line=np.array([poses[0].joint, *(pose.tip for pose in poses)]) * units.length,
        kinetic_energy_before=scene.mechanism.kinetic_energy(start) * units.energy,
        kinetic_energy_after=scene.mechanism.kinetic_energy(after) * units.energy,
        steps=scene.steps,
        wall_s=clock.perf_counter() - begin,
    )


OUT_OF_STEPS = "contact: step budget spent before it is over; must have more steps, a larger accuracy or a shorter contact_duration"
TOO_ACCURATE = (
    "contact: no interval of its motion is short enough for the requested accuracy; accuracy must be larger, or friction"
    " further from the jam"
)


def struck(
    scene: Scene, start: State, obstacle: Obstacle, settings: Settings
) -> tuple[State, ContactRecord, list[State]]:
    """Carry a scene through one contact with an obstacle that it touches, by the obstacle's law.

    Returns:
        The state after the contact, its record, and the states at its samples.

    Raises:
        ValueError: if a contact with a spring comes to no end.
    """
    approach = -obstacle.closest(scene.mechanism.poses(start), start.rates).velocity[0]
    law = obstacle.law if approach > 0.0 else ENERGETIC
    if law.at_once or approach <= SLOW_FRACTION * scene.mechanism.speed_bound(start):
        after, record = law.resolve(scene, start, obstacle, Coefficients.of(obstacle))
        return after, record, [start, after]
    stepper = Extrapolation(settings.accuracy)
    plan = Plan(math.inf, settings.accuracy, "strike", maximum_steps=settings.maximum_steps, single_contact=True)
    recording = run(scene, start, stepper, plan, [obstacle])
    if recording.stop_reason in (StopReason.STEP_BUDGET, StopReason.ACCURACY):
        raise ValueError(OUT_OF_STEPS if recording.stop_reason is StopReason.STEP_BUDGET else TOO_ACCURATE)
    ((record, _), *_) = recording.contacts
    return recording.states[-1], record, recording.states


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
