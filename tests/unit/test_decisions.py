"""Which contacts begin, stay and end after an event."""

import math
from cmath import rect
from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.contact import ActiveContact, sums_of
from bristle_sim.scene.events import Happening, Kind
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.impacts import ENERGETIC
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.motion import Motion, accept, integrate
from bristle_sim.scene.pairs import BarPair, WorkpartPair
from bristle_sim.scene.run import begin_motion, decide, first_motion, run
from bristle_sim.scene.spring import SpringContact
from bristle_sim.scene.spring_phases import pressed_on
from bristle_sim.scene.system import SLOW_FRACTION, Plan, System
from bristle_sim.settings import StopReason


def bent_wire() -> tuple[System, BarPair, BarPair, WorkpartPair]:
    """Two rods that a bar meets at their hinge, and whose tip lies on the workpart; pairs of both rods and of the tip."""
    mechanism = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 1.0)))
    state = State(0.0, (0.4, -0.4), (1.0, 0.3))
    joint, tip = mechanism.poses(state)[1].corners
    lower, upper = (BarPair(joint + 0.2, 0.15, 0.05, 0.0, 0.5, link=link) for link in (0, 1))
    part = WorkpartPair(-tip.imag, 0.1, 0.1, 0.5, link=1)
    scene = Scene(mechanism, Effects(pairs=(lower, upper, part)))
    return System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9)), lower, upper, part


def test_a_touch_at_a_hinge_is_one_of_the_link_nearer_the_root() -> None:
    system, _, upper, _ = bent_wire()
    decide(system, Motion(), Happening(Kind.TOUCH, upper))
    assert [links for _, links in system.recording.contacts] == [(0,)]


def test_a_tip_that_parts_still_parts_as_another_contact_passes_to_the_next_link() -> None:
    system, lower, upper, part = bent_wire()
    contact = ActiveContact(lower, slip=1)
    motion = decide(
        system, Motion((contact,), (part,)), Happening(Kind.HAND_OVER, (contact, upper))
    )
    assert [each.pair for each in motion.contacts] == [upper]
    assert motion.separating == (part,)


def test_a_tip_that_parts_still_parts_as_another_contact_is_released() -> None:
    system, lower, _, part = bent_wire()
    contact = ActiveContact(lower, slip=1)
    motion = decide(system, Motion((contact,), (part,)), Happening(Kind.RELEASE, (contact,)))
    assert motion.contacts == ()
    assert motion.separating == (part, lower)


def test_a_tip_that_comes_to_rest_parts_no_more_and_leaves_other_contacts() -> None:
    system, lower, _, part = bent_wire()
    contact = ActiveContact(lower, slip=1)
    motion = decide(system, Motion((contact,), (part,)), Happening(Kind.REST, part))
    assert {each.pair for each in motion.contacts} == {lower, part}
    assert motion.separating == ()


def test_a_spring_pushes_while_a_rigid_contact_lasts() -> None:
    """The second rod turns; it presses the first one against a bar on its left, and its tip on the workpart."""
    mechanism = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 1.0)))
    state = State(0.0, (0.4, -0.4), (0.0, 0.3))
    joint, tip = mechanism.poses(state)[1].corners
    bar = BarPair(0.5 * joint - rect(0.2, 0.4), 0.15, 0.05, 0.0, 0.5, link=0)
    part = WorkpartPair(-tip.imag, 0.1, 0.1, 0.5, link=1)
    scene = Scene(mechanism, Effects(pairs=(bar, part)))
    law = CompliantLaw(1e-3, 1e-6)
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9), law=law)
    motion = decide(system, Motion((ActiveContact(bar),)), Happening(Kind.TOUCH, part))
    assert [each.pair for each in motion.contacts] == [bar, part]
    results = (integrate(system, motion) for _ in range(20))
    interval, event = next(each for each in results if each != (None, None))
    assert event is None
    assert interval is not None
    forces = [sums_of(interval.end.totals, index).normal for index in (0, 1)]
    assert min(forces) > 0.0


def test_forces_in_the_middle_of_an_interval_are_those_of_an_interval_that_ends_there() -> None:
    """The tip of three rods sticks as it is pressed in, and a bar holds the first rod.

    The tip moves down: w_2 cos a_2 + w_3 cos a_3 = 0. Neither its tangential force nor the bar's force follows from
    the penetration alone. The bar's force at the start of the first interval is unknown; a straight line stands for it.
    """
    mechanism = Mechanism((Link.rod(1.0, 1.0),) * 3)
    angles = (0.4, -0.9, 0.7)
    state = State(0.0, angles, (0.0, 0.3 * math.cos(0.7) / math.cos(0.9), -0.3))
    joint, tip = (mechanism.poses(state)[link].corners[1] for link in (0, 2))
    bar = BarPair(0.5 * joint - rect(0.2, 0.4), 0.15, 0.05, 0.0, 0.5, link=0)
    part = WorkpartPair(-tip.imag, 3.0, 3.0, 0.5, link=2)
    scene = Scene(mechanism, Effects(pairs=(bar, part)))
    system = System(
        scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9), law=CompliantLaw(1e-3, 1e-6)
    )
    motion = decide(system, Motion((ActiveContact(bar),)), Happening(Kind.TOUCH, part))
    (spring,) = motion.springs
    assert spring.slip == 0
    for tolerance in (2e-3, 3e-4, 3e-4, 3e-4):
        interval, _ = integrate(system, motion)
        assert interval is not None
        half = interval.integrate_to(0.5 * interval.length)
        at_bar, at_part = (sums_of(half.totals, index) for index in (0, 1))
        accept(system, motion, interval)
        time, normal, tangential, *_ = spring.rows[-2]
        assert time == pytest.approx(half.state.time, rel=1e-12)
        assert (normal, tangential) == pytest.approx(at_part[:2], rel=tolerance)
        (total,) = system.recording.forces[-2]
        assert total - at_part.normal == pytest.approx(at_bar.normal, rel=tolerance)


def test_a_run_that_its_first_touch_stops_has_no_other() -> None:
    """A level rod is wedged between a plane under its tip and a bar above its middle, and approaches both."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 1.0, np.pi / 2.0)
    tip = WorkpartPair(0.0, 0.0, 0.0, 0.5)
    bar = BarPair(1.5 + 0.2j, 0.15, 0.05, 0.0, 0.5)
    scene = Scene(mechanism, Effects(pairs=(tip, bar)))
    state = State(0.0, (np.pi / 2.0,), (-1.2,))
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9))
    assert [system.approach(pair) for pair in (tip, bar)] == pytest.approx([-0.2, -0.4])
    first_motion(system)
    assert system.recording.stop_reason is StopReason.JAM
    assert [event.name for event, _ in system.recording.events] == ["strike", "jam"]


def test_the_shortest_contact_sets_the_pace() -> None:
    system, _, _, part = bent_wire()
    other = WorkpartPair(part.depth, 0.1, 0.1, 0.5, link=1)
    state = system.state._replace(rates=(0.0, 0.3))
    slow, fast = (
        CompliantLaw(duration, 1e-6).spring(system.scene, state, pair)
        for duration, pair in ((1e-3, part), (1e-4, other))
    )
    assert slow is not None
    assert fast is not None
    for springs in ((slow, fast), (fast, slow)):
        begin_motion(system, Motion(springs))
        assert system.stepper is fast.stepper


@pytest.mark.parametrize(
    ("links", "touches", "listed"), [(1, False, True), (1, True, False), (2, False, False)]
)
def test_the_highest_speed_is_an_event_of_a_rigid_bristle_in_flight(
    links: int, touches: bool, listed: bool
) -> None:
    """A wire of several links vibrates, and in contact the speed is not that of the equation of flight."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),) * links)
    state = State(0.0, (0.4,) * links, (0.3,) * links)
    tip = mechanism.poses(state)[-1].corners[-1]
    part = WorkpartPair(-tip.imag, 0.1, 0.1, 0.5)
    scene = Scene(mechanism, Effects(stiffness=0.3, pairs=(part,)))
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9))
    motion = begin_motion(system, Motion((ActiveContact(part),) if touches else ()))
    kinds = [event.kind for event in motion.events]
    assert Kind.LARGEST_RETRACTION in kinds
    assert (Kind.HIGHEST_RELATIVE_SPEED in kinds) == listed


def test_a_contact_that_friction_locks_stops_the_run_beside_one_that_slips() -> None:
    """Friction of 4 locks the first rod's end in one sense of slip, whatever the tip of the second one does."""
    mechanism = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 1.0)))
    state = State(0.0, (0.4, 0.9), (0.3, -0.2))
    ends = [pose.corners[-1].imag for pose in mechanism.poses(state)]
    pairs = [
        WorkpartPair(-end, friction, friction, 0.5, link=link)
        for link, (end, friction) in enumerate(zip(ends, (4.0, 0.0), strict=True))
    ]
    reasons = []
    for slip in (1, -1):
        scene = Scene(mechanism, Effects(pairs=tuple(pairs)))
        system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9))
        begin_motion(system, Motion((ActiveContact(pairs[0], slip=slip), ActiveContact(pairs[1]))))
        reasons.append(system.recording.stop_reason)
    assert reasons == [StopReason.JAM, None]


def test_a_low_hop_of_a_wire_on_a_surface_with_springs_ends_in_a_spring() -> None:
    system, _, _, part = bent_wire()
    system.law = CompliantLaw(1e-3, 1e-6)
    system.state = system.state._replace(rates=(0.0, 0.3))
    motion = decide(system, Motion(), Happening(Kind.REST, part))
    assert [type(contact) for contact in motion.contacts] == [SpringContact]


def pressed_rod(speed: float) -> tuple[System, WorkpartPair, ActiveContact]:
    """A rod that a belt presses on the workpart, and a contact of it with a bar beside it.

    The tip approaches at ``speed`` times the least speed of an impact with restitution.
    """
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 1.0, 0.3)
    pose = mechanism.poses(State(0.0, (0.9,), (0.0,)))[0]
    slow = SLOW_FRACTION * mechanism.speed_bound(State(0.0, (0.9,), (0.0,)))
    rate = -(pose.velocity.imag + speed * slow) / math.sin(0.9)
    part = WorkpartPair(-pose.corners[-1].imag, 0.1, 0.1, 0.5)
    bar = BarPair(0.5 * sum(pose.corners) + rect(0.21, 0.9), 0.15, 0.05, 0.0, 0.5)
    scene = Scene(mechanism, Effects(stiffness=0.3, pairs=(part, bar)))
    law = CompliantLaw(1e-3, 1e-6, stiffness=1e6)
    state = State(0.0, (0.9,), (rate,))
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9), law=law)
    return system, part, ActiveContact(bar)


@pytest.mark.parametrize(("speed", "kind"), [(0.5, ActiveContact), (5.0, SpringContact)])
def test_a_touch_slower_than_the_least_speed_begins_no_spring(
    speed: float, kind: type[ActiveContact]
) -> None:
    system, part, _ = pressed_rod(speed)
    motion = decide(system, Motion(), Happening(Kind.TOUCH, part))
    assert [type(contact) for contact in motion.contacts] == [kind]


def test_a_resting_tip_is_pressed_on_by_the_belt_alone() -> None:
    """The force of another contact of the wire is not known before the spring's."""
    system, part, bar = pressed_rod(0.0)
    spring = pressed_on(system, Motion(), part)
    assert isinstance(spring, SpringContact)
    assert pressed_on(system, Motion((bar,)), part) is None


def test_a_contact_that_passes_to_another_segment_is_recorded_up_to_there() -> None:
    """The bar meets the same link once more, whose rebound is a release; the link is not released before."""
    system, lower, _, _ = bent_wire()
    before = system.state._replace(time=-0.1)
    contact = ActiveContact(lower, slip=1, start=before)
    decide(system, Motion((contact,)), Happening(Kind.TOUCH, lower))
    (first, _), *_ = system.recording.contacts
    assert (first.law, first.outcome, first.duration) == ("sustained", "bar", 0.1)
    assert [event.name for event, _ in system.recording.events] == ["bar touch", "bar release"]


def test_a_rigid_bristle_leaves_its_contact_as_it_touches_another_obstacle() -> None:
    system, part, bar = pressed_rod(5.0)
    system.law = ENERGETIC
    bar.start = system.state._replace(time=-0.1)
    motion = decide(system, Motion((bar,)), Happening(Kind.TOUCH, part))
    assert motion.contacts == ()
    (first, _), *_ = system.recording.contacts
    assert (first.law, first.outcome, first.duration) == ("sustained", "workpart", 0.1)
    assert [event.name for event, _ in system.recording.events] == ["strike", "bar release"]


def test_a_spring_outlasts_an_impact_elsewhere_on_its_wire_but_not_its_rest() -> None:
    system, lower, _, part = bent_wire()
    state = system.state._replace(rates=(0.0, 0.3))
    spring = CompliantLaw(1e-3, 1e-6).spring(system.scene, state, part)
    assert spring is not None
    spring.at_rest = True
    motion = decide(system, Motion((spring,)), Happening(Kind.TOUCH, lower))
    assert motion.contacts == (spring,)
    assert not spring.at_rest


def test_a_tip_that_leaves_its_dent_too_slowly_is_pressed_on_and_touches_anew() -> None:
    system, part, _ = pressed_rod(5.0)
    motion = decide(system, Motion(), Happening(Kind.TOUCH, part))
    (spring,) = motion.springs
    spring.start = spring.start._replace(time=-1e-3)
    system.state = pressed_rod(0.0)[0].state
    motion = decide(system, motion, Happening(Kind.UNLOADED, spring))
    (following,) = motion.springs
    assert following is not spring
    names = [event.name for event, _ in system.recording.events]
    assert names == ["strike", "workpart release", "workpart touch"]


def test_a_run_that_only_waits_for_its_contact_to_end_begins_no_other() -> None:
    system, part, _ = pressed_rod(5.0)
    system.plan.stop_after = "strike"
    motion = decide(system, Motion(), Happening(Kind.TOUCH, part))
    (spring,) = motion.springs
    system.state = pressed_rod(0.0)[0].state
    motion = decide(system, motion, Happening(Kind.UNLOADED, spring))
    assert motion.springs == []
    assert system.recording.stop_reason is StopReason.EVENT
    assert [event.name for event, _ in system.recording.events] == ["strike"]


@pytest.mark.parametrize(("duration", "stays"), [(None, True), (1e-3, False)])
def test_a_tip_without_restitution_stays_on_the_surface_in_the_rigid_limit_only(
    duration: float | None, stays: bool
) -> None:
    """A spring lets go of it at the bottom of a dent."""
    system, _, _ = pressed_rod(5.0)
    (part, _) = system.pairs
    system.pairs[0] = part = replace(part, restitution=0.0)
    system.state = system.state._replace(rates=(-2.0,))
    system.law = CompliantLaw(duration, 1e-6)
    motion = decide(system, Motion(), Happening(Kind.TOUCH, part))
    (spring,) = motion.springs
    motion = decide(system, motion, Happening(Kind.COMPRESSION_ENDS, spring))
    assert [type(contact) for contact in motion.contacts] == ([ActiveContact] if stays else [])
    assert motion.separating == (() if stays else (part,))


@pytest.mark.parametrize(("duration", "error"), [(None, 1e-3), (1e-3, 0.0)])
def test_a_contact_in_the_rigid_limit_is_as_wrong_as_it_ends_beside_the_impact_law(
    duration: float | None, error: float
) -> None:
    """A rod without friction rebounds with e* = 0.5 of its rate; a contact of given duration is no limit."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),))
    part = WorkpartPair(math.cos(0.9), 0.0, 0.0, 0.5)
    scene = Scene(mechanism, Effects(pairs=(part,)))
    state = State(0.0, (0.9,), (-1.0,))
    law = CompliantLaw(duration, 1e-6)
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9), law=law)
    motion = decide(system, Motion(), Happening(Kind.TOUCH, part))
    (spring,) = motion.springs
    system.state = state._replace(rates=(0.5 + 1e-3,))
    decide(system, motion, Happening(Kind.UNLOADED, spring))
    assert system.recording.error == pytest.approx(error, rel=1e-9)


def flying_rod(rate: float = -1.0) -> tuple[System, WorkpartPair]:
    """A rod under gravity 1 whose tip touches a plane without friction and restitution."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),))
    part = WorkpartPair(math.cos(0.9), 0.0, 0.0, 0.0)
    scene = Scene(mechanism, Effects(pairs=(part,), gravity=1.0))
    plan = Plan(1.0, 1e-6, longest_interval=0.1, maximum_steps=100_000)
    return System(scene, State(0.0, (0.9,), (rate,)), Extrapolation(1e-9), plan), part


@pytest.mark.parametrize(("time", "closed"), [(1e-12, True), (1e-3, False)])
def test_a_pair_parts_until_its_gap_is_open(time: float, closed: bool) -> None:
    """It opens at sin 0.9; 1e-11 counts as closed. A pair that has parted would take part in impacts elsewhere."""
    system, part = flying_rod(1.0)
    motion = begin_motion(system, Motion((), (part,)))
    motion.limit = time
    interval, _ = integrate(system, motion)
    assert interval is not None
    accept(system, motion, interval)
    assert motion.separating == ((part,) if closed else ())


def test_a_contact_of_a_rod_keeps_the_errors_of_intervals_alone() -> None:
    """Geometry determines its motion from there on, whatever the error of impacts was; a slip has the errors of intervals."""
    system, part = flying_rod(1.0)
    motion = begin_motion(system, Motion((), (part,)))
    errors = 0.0
    for _ in range(2):
        interval, _ = integrate(system, motion)
        assert interval is not None
        accept(system, motion, interval)
        errors += interval.end.error
    assert errors > 0.0
    system.recording.error = 1.0
    begin_motion(system, Motion((ActiveContact(part),)))
    assert system.recording.error == pytest.approx(errors, abs=0.0)


def test_a_motion_so_fast_that_rounding_exceeds_the_tolerance_ends_for_lack_of_accuracy() -> None:
    """A rate of 1e9 has a rounding error of 1e-7 in an interval of any length; 1e-9 is permitted."""
    system, _ = flying_rod(1e9)
    system.pairs.clear()
    for _ in run(system):
        pass
    assert system.recording.stop_reason is StopReason.ACCURACY
