"""A single contact of a chain of rods or of a flexible wire, and the wire's natural frequencies."""

from __future__ import annotations

import dataclasses
import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Contact, Surface, Tool
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.compliant import SAMPLES_OF_A_COURSE, CompliantLaw
from bristle_sim.scene.extrapolation import Extrapolation, damped_interval
from bristle_sim.scene.impacts import ENERGETIC, ContactLaw
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.pairs import WorkpartPair
from bristle_sim.scene.results import contact_in_si, motion_in_si
from bristle_sim.scene.run import run
from bristle_sim.scene.system import SLOW_FRACTION, Plan, System
from bristle_sim.scene.tool import Units, build_tool, contact_law
from bristle_sim.settings import Settings, StopReason
from bristle_sim.trajectory import ContactRecord
from bristle_sim.units import shown


@dataclass(frozen=True, slots=True)
class Chain:
    """A chain of uniform rods at the instant of impact; SI units.

    Angles and angular velocities are absolute, and positive in the hub's sense of rotation. At
    angle 0 a rod points straight at the surface.

    Attributes:
        masses: masses of the rods (kg) in order from the root.
        lengths: lengths of the rods, m.
        angles: angles of the rods, rad.
        rates: angular velocities of the rods, rad/s.
        hub_radius: radius of the hub that carries the root, m; 0 for a fixed root.
        hub_speed: angular velocity of the hub, rad/s.
        hub_angle: angle of the radius from the hub's centre to the root, rad.
    """

    masses: tuple[float, ...]
    lengths: tuple[float, ...]
    angles: tuple[float, ...]
    rates: tuple[float, ...]
    hub_radius: float = 0.0
    hub_speed: float = 0.0
    hub_angle: float = 0.0


@dataclass(frozen=True, slots=True)
class ChainStrike:
    """A contact of a chain of rods or of a wire, with the motion since the first touch; SI units.

    Attributes:
        contact: the contact record, with its history if the contact is simulated over its duration.
        time: times of the samples, s.
        angles: absolute angles of the links (rad), shape (samples, links).
        centre_line: positions of root, knee, joints and tip at each sample, (x, y) from the hub's
            centre (m), shape (samples, corners, 2).
        kinetic_energy: kinetic energy at each sample, J.
        steps: number of engine steps.
        wall_s: wall time, s.
    """

    contact: ContactRecord
    time: Array
    angles: Array
    centre_line: Array
    kinetic_energy: Array
    steps: int
    wall_s: float

    @property
    def kinetic_energy_ratio(self) -> float | None:
        """Final kinetic energy divided by that at the first touch; None for a chain at rest."""
        first, last = self.kinetic_energy[[0, -1]].tolist()
        return last / first if first else None


def strike(chain: Chain, surface: Surface, contact: Contact, settings: Settings) -> ChainStrike:
    """Simulate the impact of a chain whose last rod touches a surface with its tip.

    A tip that does not approach the surface leaves it at once, whatever the contact law.

    Args:
        chain: the rods at the instant of impact.
        surface: friction and restitution.
        contact: parameters of the contact, with the contact law.
        settings: numerical settings.

    Raises:
        ValueError: if a compliant contact does not end.
    """
    begin = clock.perf_counter()
    scene, start, pair, units = build_strike(chain, surface)
    law = contact_law(contact, settings.accuracy, units.time)
    record, states = struck(scene, start, pair, settings, law)
    return _in_si(scene, units, record, states, begin)


def _in_si(
    scene: Scene, units: Units, record: ContactRecord, states: Sequence[State], begin: float
) -> ChainStrike:
    """Return a simulated contact in SI units; ``begin`` is the wall clock at its beginning, s."""
    motion = motion_in_si(scene, units, states)
    return ChainStrike(
        contact=contact_in_si(record, units),
        time=motion["time"],
        angles=motion["angles"],
        centre_line=motion["centre_line"],
        kinetic_energy=motion["kinetic_energy"],
        steps=scene.steps,
        wall_s=clock.perf_counter() - begin,
    )


# Least angular velocity of a rod before an impact (rad/s) that is distinguished from rest. A smaller
# value has few digits, and its reciprocal, a unit of time, may be no floating-point number.
SLOWEST_RATE = 1e-300


def build_strike(chain: Chain, surface: Surface) -> tuple[Scene, State, WorkpartPair, Units]:
    """Build the scene of a chain whose tip is on the surface.

    Returns:
        The scene.
        The state at the instant of the impact.
        The pair of tip and surface.
        The units of the scene.

    Raises:
        ValueError: if a rod moves so slowly that rounding hides its motion.
    """
    fastest = max(*(abs(rate) for rate in chain.rates), abs(chain.hub_speed))
    for rate in chain.rates:
        if 0.0 < abs(rate) < SLOWEST_RATE:
            raise ValueError(
                f"rate before the impact = {rate:.3g}: must be 0 or at least {SLOWEST_RATE:g} in magnitude, or rounding"
                " hides the motion (in rad/s)"
            )
    time = 1.0 / max(fastest, SLOWEST_RATE) if fastest else 1.0
    units = Units(chain.lengths[-1], chain.masses[-1], time)
    rods = zip(chain.masses, chain.lengths, strict=True)
    links = tuple(Link.rod(mass / units.mass, length / units.length) for mass, length in rods)
    mechanism = Mechanism(
        links, chain.hub_radius / units.length, chain.hub_speed * units.time, chain.hub_angle
    )
    start = State(0.0, chain.angles, tuple(rate * units.time for rate in chain.rates))
    pair = _below(mechanism, start, surface)
    return Scene(mechanism, Effects(pairs=(pair,))), start, pair, units


def _below(mechanism: Mechanism, start: State, part: Surface) -> WorkpartPair:
    """Return the pair of the last link's tip and a workpart surface that passes through the tip."""
    height = mechanism.poses(start)[-1].corners[-1].imag
    return WorkpartPair(-height, part.friction, part.friction_in_restitution, part.restitution)


UNSOLVED = {
    StopReason.STEP_BUDGET: "contact: step budget spent before it is over; must have more steps, a larger accuracy or a"
    " shorter contact_duration",
    StopReason.ACCURACY: "contact: no interval of its motion is short enough for the requested accuracy; accuracy must be"
    " larger, or friction further from the jam",
}


def struck(
    scene: Scene, start: State, pair: WorkpartPair, settings: Settings, law: ContactLaw
) -> tuple[ContactRecord, list[State]]:
    """Simulate one contact from its first touch to its end.

    Args:
        scene: the scene.
        start: state at the first touch.
        pair: the tip and the surface that it touches.
        settings: numerical settings.
        law: contact law.

    Returns:
        The contact record.
        The samples of the motion from the first touch to the end of the contact.

    Raises:
        ValueError: if a contact with a spring does not end.
    """
    approach = -pair.closest(scene.mechanism.poses(start), start.rates).velocity[0]
    law = law if approach > 0.0 else ENERGETIC
    if law.instantaneous or approach <= SLOW_FRACTION * scene.mechanism.speed_bound(start):
        record = law.resolve(scene, start, pair)
        return record, [start, start._replace(rates=record.rates_after)]
    plan = Plan(
        math.inf,
        settings.accuracy,
        "strike",
        maximum_steps=settings.maximum_steps,
        single_contact=True,
    )
    system = System(scene, start, Extrapolation(settings.accuracy), plan, [pair], law)
    for _ in run(system):
        pass
    recording = system.recording
    if recording.stop_reason in UNSOLVED:
        raise ValueError(UNSOLVED[recording.stop_reason])
    ((record, _), *_) = recording.contacts
    # A contact with a duration begins with a second sample of the start.
    return record, recording.states[1:] if record.duration else recording.states


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
) -> ChainStrike:
    """Simulate the contact of a wire whose tip strikes a workpart of finite contact stiffness.

    The contact is a spring of stiffness k in compression and of stiffness k/e*^2 in restitution,
    where e* is the energetic coefficient of restitution. The belt and the bending of the wire act
    during the contact.

    Args:
        tool: tool with a workpart, whose surface is moved to the wire's tip. The tool's bar is
            ignored.
        hub_angle: angle psi of the hub at the first touch, rad.
        angles: absolute angles of the links at the first touch, rad.
        rates: absolute angular velocities of the links at the first touch, rad/s.
        stiffness: stiffness k of the contact in compression, N/m.
        settings: numerical settings.
        duration: expected duration of the contact, s. The samples are at most 1/24 of this duration
            apart. If a rigid bristle is still in contact after ten times this duration, the contact
            ends there, with the outcome that the rigid-body law predicts, or with stiction if that
            law predicts a rebound.
        flight: duration of the free motion that is simulated after the contact, s.

    Returns:
        The contact, and the motion during the contact and the free motion.

    Raises:
        ValueError: if the wire's tip does not approach the workpart, or the contact does not end.
    """
    begin = clock.perf_counter()
    part = tool.workpart
    assert part is not None
    scene, units = build_tool(dataclasses.replace(tool, bar=None), hub_start=hub_angle)
    start = State(0.0, tuple(angles), tuple(rate * units.time for rate in rates))
    pair = _below(scene.mechanism, start, part)
    approach = pair.closest(scene.mechanism.poses(start), start.rates).velocity[0]
    if approach >= 0.0:
        raise ValueError(
            f"rates = {shown(rates[-1])}: must let the wire's end approach the workpart, its normal velocity is"
            f" {approach * units.velocity:g} m/s (in rad/s)"
        )
    law = CompliantLaw(
        duration / units.time,
        settings.accuracy,
        stiffness=stiffness * units.time**2 / units.mass,
        time_unit=units.time,
    )
    record, states = struck(scene, start, pair, settings, law)
    if flight > 0.0:
        after = states[-1]
        # The free motion has the same sampling interval as the contact, and takes at most a tenth
        # of the permitted number of steps.
        longest = min(duration / units.time / SAMPLES_OF_A_COURSE, damped_interval(scene))
        fastest = max(1.0, *map(abs, after.rates))
        stepper = Extrapolation(0.1 * settings.accuracy * fastest, longest=longest)
        end = after.time + flight / units.time
        plan = Plan(
            end,
            settings.accuracy,
            longest_interval=longest,
            maximum_steps=settings.maximum_steps // 10,
            single_contact=True,
        )
        system = System(scene, after, stepper, plan, [])
        for _ in run(system):
            pass
        states += system.recording.states[1:]
    return _in_si(scene, units, record, states, begin)


# Angle (rad) by which one link is rotated. The rotation changes the mass matrix by the fraction
# 5e-17, which is less than rounding error.
SMALL_ANGLE = 1e-8
SHORT_STEP = 1e-8
"""Length of the single step from rest, in scene time units. The step is so short that the angular
velocities after the step are proportional to its length."""


def wire_frequencies(tool: Tool) -> Array:
    """Return the natural frequencies (Hz) of a tool's undamped wire on a hub at rest.

    The frequencies follow from the eigenvalues of M^-1 K, with the mass matrix M and the stiffness
    matrix K in the links' angles. Each link in turn is set at a small angle, and one engine step is
    taken from rest. The engine moves the links by their old velocities, which are zero. The angular
    velocities of all links after the step, divided by the angle and by the step's length, are
    therefore a column of -M^-1 K.

    Returns:
        The frequencies in ascending order, shape (links,).
    """
    straight = (0.0,) * tool.bristle.links
    undamped = dataclasses.replace(tool.bristle, bending_damping_ratio=0.0)
    still = tool.replace(hub_speed=0.0, belt_damping_ratio=0.0, bristle=undamped, gravity=0.0)
    scene, units = build_tool(still, hub_start=0.0)
    changes = []
    for angles in SMALL_ANGLE * np.eye(tool.bristle.links):
        scene.place(State(0.0, tuple(angles.tolist()), straight))
        rates = scene.step(SHORT_STEP, 1)[len(angles) : 2 * len(angles)]
        changes.append(np.array(rates) / (SMALL_ANGLE * SHORT_STEP))
    squares = np.sort(-np.linalg.eigvals(np.array(changes).T).real)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (math.tau * units.time))
