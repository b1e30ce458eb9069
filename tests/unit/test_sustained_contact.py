"""Rigid sustained contacts, against geometry and values by hand."""

import math
from cmath import rect
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bristle_sim.parameters import Tool
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.contact import ActiveContact, RigidContacts, Sums, sums_of
from bristle_sim.scene.events import Kind
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.motion import Motion, integrate
from bristle_sim.scene.pairs import (
    BarPair,
    ClosedPair,
    ClosestApproach,
    ContactPair,
    WirePair,
    WorkpartPair,
)
from bristle_sim.scene.run import begin_motion, decide, run
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.system import Plan, System

ROD = Mechanism((Link.rod(2.0, 1.0),))
"""A rod that hangs from the origin: moment of inertia m/3 about the root, m/12 about the centre."""


def closed(
    mechanism: Mechanism, pair: ContactPair, state: State
) -> tuple[ClosedPair, RigidContacts]:
    """A closed contact, and the forces that keep it closed."""
    contact = ClosedPair(pair)
    rigid = RigidContacts(Scene(mechanism, Effects(pairs=(pair,))), [contact])
    rigid.engage(state)
    return contact, rigid


@pytest.mark.parametrize(("rate", "sense"), [(0.5, 1), (-0.5, -1), (0.0, None)])
def test_friction_on_a_lone_link_acts_against_a_given_slip(rate: float, sense: int | None) -> None:
    """The tip of a rod at 0.7 slips by its rate times cos 0.7; at rest it has no sense."""
    state = State(0.0, (0.7,), (rate,))
    contact, rigid = closed(ROD, WorkpartPair(math.cos(0.7), 0.4, 0.4, 0.5), state)
    rigid.set_slip(state, contact, 1e-6)
    assert contact.slip == sense


def test_a_tip_without_slip_begins_to_slip_where_its_hub_carries_it() -> None:
    """Radial at 0.4 on a hub of radius 1 that turns by 2, the tip at rest on a plane: of either rounding the sense is that of its acceleration.

    With the root at (sin, -cos) psi and the rod at angle a, y = -cos psi - cos a stays, so a' = -2 sin psi/sin a = -2 at
    psi = a, and x' = 2 cos psi + a' cos a = 0 there. x'' = -4 sin psi + a'' cos a - a'^2 sin a with
    a'' sin a = -4 cos psi - a'^2 cos a: -8 (sin + cos^2/sin) = -8/sin 0.4 = -20.5.
    """
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 2.0, 0.4)
    part = WorkpartPair(2.0 * math.cos(0.4), 0.3, 0.3, 0.0)
    for rounding in (1e-8, -1e-8):
        state = State(0.0, (0.4,), (-2.0 + rounding,))
        contact, rigid = closed(mechanism, part, state)
        assert rigid.slip_acceleration(contact, state) == pytest.approx(
            -8.0 / math.sin(0.4), rel=1e-4
        )
        rigid.set_slip(state, contact, 1e-6)
        assert contact.slip == -1


def lagrange(angles: Any, rates: Any) -> tuple[np.ndarray, np.ndarray]:
    """Inverse mass and free acceleration, (normal, tangential), of the tip of rods of mass and length 1 under gravity 1."""
    links = len(angles)
    number = np.arange(links)
    beyond = links - 0.5 - np.maximum.outer(number, number)
    between = np.subtract.outer(angles, angles)
    mass = beyond * np.cos(between) - np.eye(links) / 6.0
    load = -(beyond * np.sin(between)) @ np.square(rates) - np.diag(beyond) * np.sin(angles)
    levers = np.array([np.sin(angles), np.cos(angles)])
    centripetal = np.array([np.cos(angles), -np.sin(angles)]) @ np.square(rates)
    moved = np.linalg.solve(mass, levers.T)
    return levers @ moved, load @ moved + centripetal


def on_a_plane(
    angles: tuple[float, ...], rates: tuple[float, ...], friction: float
) -> tuple[System, WorkpartPair]:
    """Rods of mass and length 1 under gravity 1 whose tip lies on a plane without restitution."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),) * len(angles))
    pair = WorkpartPair(sum(map(math.cos, angles)), friction, friction, 0.0)
    scene = Scene(mechanism, Effects(pairs=(pair,), gravity=1.0))
    state = State(0.0, angles, rates)
    return System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-6)), pair


def test_forces_on_several_links_are_read_after_an_odd_number_of_plain_steps() -> None:
    system, pair = on_a_plane((0.7, 0.2), (0.0, 0.0), 0.0)
    scene = system.scene
    rigid = RigidContacts(scene, [ClosedPair(pair)])
    rigid.engage(system.state)
    scene.place(system.state)
    scene.step(1e-6, 3)
    inverse_mass, free = lagrange(system.state.angles, system.state.rates)
    # The steps move the rods by 1e-11.
    assert sums_of(rigid.totals(1e-6), 0).normal == pytest.approx(
        -free[0] / inverse_mass[0, 0], rel=1e-6
    )


def test_a_tip_that_would_have_to_pull_in_stick_slips_and_pushes() -> None:
    """At rest. In stick the forces are -K^-1 a, in slip of sense s the normal one is -a_n/(K_nn - mu s K_nt)."""
    angles = (0.4, 0.8)
    inverse_mass, free = lagrange(angles, (0.0, 0.0))
    assert -np.linalg.solve(inverse_mass, free)[0] < 0.0
    system, pair = on_a_plane(angles, (0.0, 0.0), 0.3)
    motion = begin_motion(system, Motion((ActiveContact(pair),)))
    results = (integrate(system, motion) for _ in range(20))
    _, event = next(each for each in results if each != (None, None))
    assert event == (Kind.BREAKS_AWAY, motion.contacts[0])
    motion = decide(system, motion, event)
    assert motion.contacts[0].slip == math.copysign(1.0, free[1])
    results = (integrate(system, motion) for _ in range(20))
    interval, _ = next(each for each in results if each != (None, None))
    assert interval is not None
    force = -free[0] / (inverse_mass[0, 0] + 0.3 * inverse_mass[0, 1])
    # The rods slip from rest by 1e-4 at most.
    assert sums_of(interval.end.totals, 0).normal == pytest.approx(force, rel=1e-3)


def test_a_tip_sticks_until_its_force_leaves_the_friction_cone() -> None:
    """Three rods turn about their tip at rest: at first 0.53 of the normal force would do, after 0.01 only 0.72."""
    angles = (-0.3, -0.2, 1.3)
    rates = 2.0 * np.cross(np.sin(angles), np.cos(angles))
    system, _ = on_a_plane(angles, tuple(rates.tolist()), 0.6)
    event = next(event for _, event in run(system) if event and event.kind is not Kind.TOUCH)
    assert event.kind is Kind.BREAKS_AWAY
    normal, tangential = -np.linalg.solve(
        *lagrange(system.state.angles, np.array(system.state.rates))
    )
    # The accuracy is 1e-6; in a thousandth of the time the ratio changes by 2 %.
    assert abs(tangential) == pytest.approx(0.6 * normal, rel=1e-5)


@pytest.mark.parametrize("slip", [1, -1])
def test_the_compliance_in_slip_is_that_over_a_free_rods(slip: int) -> None:
    """The tip of a rod at the angle a has the levers sin a and cos a: (sin - mu s cos) sin/(m L^2/3) with the joint, and
    (1 + 12 sin^2/4)/m without."""
    angle = 0.7
    state = State(0.0, (angle,), (0.0,))
    pair = WorkpartPair(math.cos(angle), 0.4, 0.4, 0.0)
    contact, rigid = closed(ROD, pair, state)
    contact.slip = slip
    sine = math.sin(angle)
    joined = 1.5 * sine * (sine - 0.4 * slip * math.cos(angle))
    free = 0.5 * (1.0 + 3.0 * sine**2)
    assert rigid.compliance_in_slip(state, 0) == pytest.approx(joined / free, rel=1e-12)


@pytest.mark.parametrize(
    ("pushes", "force"), [((3.0, 4.0, 5.0), 5.0), ((3.0, -1.0, 5.0), -1.0), ((-2.0, -1.0), -1.0)]
)
def test_the_normal_force_is_the_last_or_the_last_that_would_pull(
    pushes: tuple[float, ...], force: float
) -> None:
    """Per step of 0.5 the impulses are half the forces; the contact fails if one would pull."""
    state = State(0.0, (0.7,), (0.0,))
    _, rigid = closed(ROD, WorkpartPair(math.cos(0.7), 0.4, 0.4, 0.0), state)
    rigid.scene.joint_solver.impulses += [[(0.5 * push, -0.1 * push, 0.2)] for push in pushes]
    totals = rigid.totals(0.5)
    assert sums_of(totals, 0).normal == pytest.approx(force)
    assert rigid.fails(totals) is (force < 0.0)
    sums = sums_of(totals, 0)
    assert sums.tangential == pytest.approx(-0.2 * pushes[-1])
    assert sums.impulse_normal == pytest.approx(0.5 * sum(pushes))
    assert sums.work_tangential == pytest.approx(-0.02 * sum(pushes))


@pytest.mark.parametrize("friction", [0.3, 1.0])
def test_the_force_of_the_bar_jumps_where_its_slip_reverses(friction: float) -> None:
    """The moment N (s + mu r), with the wire's radius r and the contact at s from the root, becomes N (s - mu r)."""
    tool = Tool()
    horizontal = tool.bar.horizontal - 0.002
    bar = replace(tool.bar, friction=friction, horizontal=horizontal)
    run = simulate(replace(tool, bar=bar, workpart=None), stop_after="bar release")
    pushed = (run.normal_force[:-1] > 0.0) & (run.normal_force[1:] > 0.0)
    jump = int(np.flatnonzero((np.diff(run.time) == 0.0) & pushed)[0])
    hub = float(run.hub_angle[jump])
    root = tool.hub.radius * np.array([math.sin(hub), -math.cos(hub)])
    radius = 0.5 * tool.bristle.wire_diameter
    distance = float(np.linalg.norm(np.array(bar.centre) - root))
    place = math.sqrt(distance**2 - (bar.radius + radius) ** 2)
    ratio = (place - friction * radius) / (place + friction * radius)
    forces = run.normal_force[jump : jump + 2]
    assert forces[1] / forces[0] == pytest.approx(ratio, rel=1e-4)


def test_a_contact_adds_impulse_and_work_and_keeps_its_last_force() -> None:
    """Its record has the slip before and after; a sustained contact has no normal velocity."""
    start = State(0.0, (0.7,), (0.5,))
    last = State(0.1, (0.75,), (0.3,))
    pair = WorkpartPair(math.cos(0.7), 0.4, 0.4, 0.5)
    contact = ActiveContact(pair, start=start)
    contact.add(Sums(5.0, -1.0, 0.5, -0.1, 0.0, -0.2))
    contact.add(Sums(4.0, 2.0, 0.3, 0.1, 0.0, -0.1))
    assert (contact.force, contact.tangential) == (4.0, 2.0)

    def closest(of: WorkpartPair, state: State) -> ClosestApproach:
        return of.closest(ROD.poses(state), state.rates)

    record = contact.record(closest, last, "release")
    assert record is not None
    assert record.impulse == pytest.approx((0.8, 0.0))
    assert record.compressive_work == pytest.approx((0.0, -0.3))
    assert record.velocity_before == (0.0, pytest.approx(0.5 * math.cos(0.7)))
    assert record.velocity_after == (0.0, pytest.approx(0.3 * math.cos(0.75)))


@pytest.mark.parametrize("known", [True, False])
def test_the_release_is_expected_at_the_zero_of_a_parabola(known: bool) -> None:
    """N = 3 - t - t^2 falls to 1 at t = 1, with the impulse 13/6. Without the first force, N is a line with this impulse."""
    contact = ActiveContact(WorkpartPair(1.0, 0.4, 0.4, 0.5), force=3.0 if known else None)
    first, left = contact.expect_release(Sums(1.0, 0.0, 13.0 / 6.0), 1.0)
    if known:
        assert first == pytest.approx(3.0)
        assert left == pytest.approx(0.5 * (math.sqrt(13.0) - 1.0) - 1.0)
    else:
        assert first == pytest.approx(10.0 / 3.0)
        assert left == pytest.approx(3.0 / 7.0)


def test_contacts_fail_if_one_of_them_would_have_to_pull() -> None:
    contacts = [ClosedPair(WorkpartPair(1.0, 0.4, 0.4, 0.5)) for _ in range(2)]
    rigid = RigidContacts(Scene(ROD, Effects()), contacts)
    assert not rigid.fails([*Sums(1.0), *Sums(2.0)])
    assert rigid.fails([*Sums(1.0), *Sums(-2.0)])
    assert rigid.fails([*Sums(-1.0), *Sums(2.0)])


def test_a_tip_of_several_links_without_slip_sticks() -> None:
    mechanism = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 1.0)))
    state = State(0.0, (0.7, 0.2), (0.0, 0.0))
    pair = WorkpartPair(math.cos(0.7) + math.cos(0.2), 0.4, 0.4, 0.0, link=1)
    contact, rigid = closed(mechanism, pair, state)
    rigid.set_slip(state, contact, 1e-6)
    assert contact.slip == 0


def test_the_compliance_of_two_wires_is_that_over_both_free_rods() -> None:
    """The tip of a rod of mass 1 touches its like across: K = (lever^2 + lever'^2)/(1/3), and both would move if free."""
    mechanism = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 1.0)), 1.0, 0.0, 0.0, 2, 0.5)
    state = State(0.0, (-0.6, 0.1), (0.0, 0.0))
    pair = WirePair(0, 1, 1, 0, 0.01, 0.0, 0.0)
    contact = ClosedPair(pair)
    rigid = RigidContacts(Scene(mechanism, Effects(pairs=(pair,))), [contact])
    touch = pair.closest(mechanism.poses(state), state.rates)
    assert touch.partner_arm is not None
    joined = free = 0.0
    for arm, pose in zip((touch.arm, touch.partner_arm), mechanism.poses(state), strict=True):
        lever, about_centre = (
            (each * touch.normal.conjugate()).imag for each in (arm, arm - pose.to_centre)
        )
        joined += 3.0 * lever**2
        free += 1.0 + 12.0 * about_centre**2
    assert rigid.compliance_in_slip(state, 0) == pytest.approx(joined / free, rel=1e-6)


@pytest.mark.parametrize("bend", [0.5, -0.5])
@pytest.mark.parametrize("piece", [0, 1])
def test_a_contact_at_a_knee_is_one_of_the_segment_onto_which_the_bar_slides(
    bend: float, piece: int
) -> None:
    """The normal is across this segment, whose end at the knee touches. Of both senses in which the hub carries the link one slides onto it."""
    link = Link(1.0, 0.1, -0.5j, (0j, -0.5j, -0.5j - 0.5j * rect(1.0, bend)))
    slides = 0
    for speed in (1.0, -1.0):
        mechanism = Mechanism((link,), 1.0, speed, 0.3)
        pose = mechanism.poses(State(0.0, (0.4,), (0.0,)))[0]
        joint, knee, tip = pose.corners
        along = tip - knee if piece else knee - joint
        normal = math.copysign(1.0, bend) * 1j * along / abs(along)
        pair = BarPair(knee - 0.1 * normal, 0.08, 0.02, 0.0, 0.0, link=0)
        arm = 1j * (knee - joint)
        rate = -(pose.velocity * normal.conjugate()).real / (arm * normal.conjugate()).real
        state = State(0.0, (0.4,), (rate,))
        contact, _ = closed(mechanism, pair, state)
        joint, knee, tip = mechanism.poses(State(1e-4, (0.4 + 1e-4 * rate,), (rate,)))[0].corners
        along = tip - knee if piece else joint - knee
        if ((pair.centre - knee) / along).real > 0.0:
            slides += 1
            assert contact.piece == piece
    assert slides == 1
