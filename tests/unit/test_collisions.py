"""What impacts leave: the error of a run beside neighbouring runs, and the contacts after impacts at one instant."""

import numpy as np
import pytest

from bristle_sim.scene import collisions
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.collisions import resolve_impacts
from bristle_sim.scene.contact import ActiveContact
from bristle_sim.scene.events import Happening, Kind
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.impacts import EnergeticLaw
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.motion import Motion
from bristle_sim.scene.pairs import BarPair, WorkpartPair
from bristle_sim.scene.run import decide, run
from bristle_sim.scene.system import SLOW_FRACTION, Plan, Recording, System
from bristle_sim.settings import StopReason

ERROR = 1e-6
"""Error of angle and rate before an impact; terms of second order change its growth by 1e-5 or so."""


@pytest.mark.parametrize(
    ("angle", "rate", "hub", "speed", "restitution", "friction"),
    [
        (1.03, 0.79, 1.24, -0.95, 0.54, 0.3),
        (-0.38, 1.56, -1.89, -0.32, 0.37, 0.3),
        (-0.97, 0.06, -1.42, 1.3, 0.28, 0.0),
        (0.7, -0.34, -1.16, 2.43, 0.02, 0.3),
        (-1.1, 0.8, -0.48, 1.35, 0.65, 0.0),
    ],
)
def test_an_error_grows_over_an_impact_as_neighbouring_runs_part(
    angle: float, rate: float, hub: float, speed: float, restitution: float, friction: float
) -> None:
    """Within the thousandth by which the motion of 2e-4 before and after the impact changes it; up to eightfold."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, speed, hub)
    simulated, parted = parting(mechanism, (angle,), (rate,), friction, restitution)
    assert len(simulated.contacts) == 1
    assert simulated.error == pytest.approx(parted, rel=2e-3)


def parting(
    mechanism: Mechanism,
    angles: tuple[float, ...],
    rates: tuple[float, ...],
    friction: float,
    restitution: float,
) -> tuple[Recording, float]:
    """A run over an impact of a tip with these angles and rates, and how far neighbouring runs part from it."""
    height = mechanism.poses(State(0.0, angles, rates))[-1].corners[-1].imag
    pair = WorkpartPair(-height, friction, friction, restitution)
    scene = Scene(mechanism, Effects(pairs=(pair,)))
    time = 2e-4

    def impacted(angle_error: float, rate_error: float, known: float = 0.0) -> System:
        earlier = [a - time * u + angle_error for a, u in zip(angles, rates, strict=True)]
        start = State(-time, tuple(earlier), tuple([u + rate_error for u in rates]))
        plan = Plan(time, 1e-10, longest_interval=time / 8.0)
        system = System(scene, start, Extrapolation(1e-13), plan)
        system.recording.error = known
        for _ in run(system):
            pass
        return system

    simulated = impacted(0.0, 0.0, ERROR)
    parted = max(
        abs(ours - theirs)
        for neighbour in (impacted(ERROR, ERROR), impacted(ERROR, -ERROR), impacted(-ERROR, ERROR))
        for ours, theirs in zip(
            (*simulated.state.angles, *simulated.state.rates),
            (*neighbour.state.angles, *neighbour.state.rates),
            strict=True,
        )
    )
    return simulated.recording, parted


@pytest.mark.parametrize(
    ("angles", "stays"), [((0.2, 1.1), True), ((0.1, 0.6), False)], ids=["stays", "parts"]
)
def test_an_error_grows_over_a_slow_impact_without_rebound(
    angles: tuple[float, float], stays: bool
) -> None:
    """An error delays a touch at 0.05 by twenty times its size. Meanwhile the acceleration changes the approach speed:
    for good if it parts the rods from the surface, but not against the force of a contact that stays.

    The estimate leaves out the change of the levers, of the order of the approach speed.
    """
    mechanism = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 1.0)))
    simulated, parted = parting(mechanism, angles, (0.7, -0.21), 0.3, 0.0)
    assert [record.law for record, _ in simulated.contacts] == ["energetic", "sustained"][
        : 1 + stays
    ]
    assert simulated.error == pytest.approx(parted, rel=0.1)


@pytest.mark.parametrize(("friction", "known"), [(0.1, True), (3.0, False)])
def test_the_error_is_unknown_where_it_decides_between_stick_and_jam(
    friction: float, known: bool
) -> None:
    """Slip and approach of a rod end together, but for a hub that turns by less than the error. Friction of 3 stops both."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 1e-5, 0.3)
    state = State(0.0, (0.9,), (-1.0,))
    height = mechanism.poses(state)[0].corners[-1].imag
    pair = WorkpartPair(-height, friction, friction, 0.5)
    scene = Scene(mechanism, Effects(pairs=(pair,)))
    law = EnergeticLaw(accuracy=1e-3)
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9), law=law)
    system.recording.error = 1e-4
    resolve_impacts(system, Motion(), pair, "strike", rests=False)
    assert (system.recording.lost is None) == known


def two_rods(
    rates: tuple[float, float],
    restitution: float,
    angles: tuple[float, float] = (0.7, 1.2),
    frictions: tuple[float, float] = (0.1, 0.1),
    hub: tuple[float, ...] = (),
) -> tuple[System, WorkpartPair]:
    """Two hinged rods whose hinge and tip both touch planes, and the pair of the tip; ``hub`` is its radius, speed and angle."""
    mechanism = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 1.0)), *hub)
    state = State(0.0, angles, rates)
    ends = [pose.corners[-1].imag for pose in mechanism.poses(state)]
    pairs = [
        WorkpartPair(-end, friction, friction, restitution, link=link)
        for link, (end, friction) in enumerate(zip(ends, frictions, strict=True))
    ]
    scene = Scene(mechanism, Effects(pairs=tuple(pairs)))
    return System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9)), pairs[1]


def test_an_impact_that_drives_a_parting_contact_together_is_followed_by_one_there() -> None:
    """The hinge has just parted; the blow at the tip drives it down again."""
    system, tip = two_rods((0.05, -3.0), 0.5)
    hinge = system.pairs[0]
    assert system.approach(hinge) > 0.0 > system.approach(tip)
    motion = resolve_impacts(system, Motion((), (hinge,)), tip, "strike", rests=False)
    assert {record.obstacle for record, _ in system.recording.contacts} == {"workpart"}
    assert {links for _, links in system.recording.contacts} == {(0,), (1,)}
    assert min(system.approach(pair) for pair in system.pairs) >= -system.slow
    assert motion.contacts == ()
    assert set(motion.separating) == {hinge, tip}


def test_the_fastest_approach_is_resolved_first() -> None:
    """A blow at the tip of three rods drives both hinges down, the first one faster."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),) * 3)
    state = State(0.0, (-1.1, 0.2, -1.2), (-0.1, 0.2, 2.7))
    first, second, tip = (
        WorkpartPair(-pose.corners[-1].imag, 0.1, 0.1, 0.5, link=link)
        for link, pose in enumerate(mechanism.poses(state))
    )
    scene = Scene(mechanism, Effects(pairs=(first, second, tip)))
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9))
    assert system.approach(tip) < 0.0 < min(system.approach(first), system.approach(second))
    resolve_impacts(system, Motion((), (second, first)), tip, "strike", rests=False)
    (blow, _), (_, links), *_ = system.recording.contacts
    after = state._replace(rates=blow.rates_after)
    assert system.closest(first, after).velocity[0] < system.closest(second, after).velocity[0] < 0
    assert links == (0,)


def test_a_blow_at_the_tip_that_jams_the_hinge_stops_the_run() -> None:
    """The blow drives the hinge down, and the turning hub pushes the first rod along: friction of 4 locks it."""
    system, tip = two_rods((1.0, -3.0), 0.5, (0.4, 0.9), (4.0, 0.1), (1.0, 1.0, -0.2))
    hinge = system.pairs[0]
    assert system.approach(hinge) > 0.0 > system.approach(tip)
    resolve_impacts(system, Motion((), (hinge,)), tip, "strike", rests=False)
    outcomes = [(links, record.outcome) for record, links in system.recording.contacts]
    assert outcomes == [((1,), "rebound"), ((0,), "jam")]
    assert system.recording.stop_reason is StopReason.JAM
    assert [event.name for event, _ in system.recording.events] == ["strike", "jam"]


def test_impacts_that_never_end_jam(monkeypatch: pytest.MonkeyPatch) -> None:
    """The hinge sticks between the rods' eleven impacts; where four are permitted after the first, this one is a jam."""

    def struck() -> System:
        system, tip = two_rods((0.05, -3.0), 0.5, (0.3, 0.7), (2.0, 2.0))
        resolve_impacts(system, Motion((), (system.pairs[0],)), tip, "strike", rests=False)
        return system

    assert len(struck().recording.contacts) == 11
    monkeypatch.setattr(collisions, "MOST_IMPACTS_AT_ONCE", 1)
    system = struck()
    assert [record.outcome for record, _ in system.recording.contacts] == ["jam"]
    assert [state.rates for state in system.recording.states] == [(0.05, -3.0)]
    assert system.state is system.recording.states[0]
    assert system.recording.stop_reason is StopReason.JAM
    assert [event.name for event, _ in system.recording.events] == ["strike", "jam"]


@pytest.mark.parametrize(("speed", "rate"), [(1.0, -1.2), (1.0, -3.0), (-1.0, 0.0), (-1.0, -1.0)])
def test_a_rod_between_two_obstacles_is_wedged_if_its_joint_rises(
    speed: float, rate: float
) -> None:
    """A level rod of length 1 lies on a plane at its tip and under a bar at its middle; U is its joint's speed upwards.

    The gaps open at U + w and -(U + w/2), so that at any w the least opening rate is U + w - 2 U - w = -U.
    """
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, speed, np.pi / 2.0)
    tip = WorkpartPair(0.0, 0.0, 0.0, 0.5)
    bar = BarPair(1.5 + 0.2j, 0.15, 0.05, 0.0, 0.5)
    scene = Scene(mechanism, Effects(pairs=(tip, bar)))
    state = State(0.0, (np.pi / 2.0,), (rate,))
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9))
    assert system.approach(tip) == pytest.approx(speed + rate)
    assert system.approach(bar) == pytest.approx(-(speed + 0.5 * rate))
    resolve_impacts(system, Motion(), tip, "strike", rests=False)
    wedged = system.recording.stop_reason is StopReason.JAM
    assert wedged == (speed > 0.0)


def test_slip_is_looked_up_anew_in_a_contact_that_outlasts_an_impact() -> None:
    """The blow at the tip presses the hinge down, which has no restitution: it stays, and may slip the other way."""
    system, tip = two_rods((0.0, -3.0), 0.0)
    lasting = ActiveContact(system.pairs[0], slip=1)
    motion = resolve_impacts(system, Motion((lasting,)), tip, "strike", rests=False)
    assert lasting in motion.contacts
    assert lasting.slip is None


@pytest.mark.parametrize(
    ("speed", "left", "lasts"), [(0.5, 0.0, True), (1.5, 0.75, True), (10.0, 5.0, False)]
)
def test_a_rebound_that_is_too_slow_to_leave_lasts(speed: float, left: float, lasts: bool) -> None:
    """Speeds are in units of the least one, below which an impact has no restitution; e* is 0.5."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 1.0, 0.3)
    angle = 0.9
    at_rest = State(0.0, (angle,), (0.0,))
    pose = mechanism.poses(at_rest)[0]
    pair = WorkpartPair(-pose.corners[-1].imag, 0.0, 0.0, 0.5)
    slow = SLOW_FRACTION * mechanism.speed_bound(at_rest)
    rate = -(pose.velocity.imag + speed * slow) / np.sin(angle)
    state = State(0.0, (angle,), (float(rate),))
    scene = Scene(mechanism, Effects(pairs=(pair,)))
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9))
    assert system.approach(pair) == pytest.approx(-speed * slow, rel=1e-6)
    motion = resolve_impacts(system, Motion(), pair, "strike", rests=False)
    ((record, _),) = system.recording.contacts
    assert record.velocity_after[0] == pytest.approx(left * slow, abs=1e-6 * slow)
    assert [contact.pair for contact in motion.contacts] == ([pair] if lasts else [])
    assert motion.separating == (() if lasts else (pair,))


def test_a_tip_that_no_impulse_can_part_lasts_with_a_trace_of_speed() -> None:
    """Friction of twice the tangent of a rod's slope lets no tip rebound. Slip stops 4e-8 after compression, as the hub turns at 1e-7."""
    mechanism = Mechanism((Link.rod(1.0, 1.0),), 1.0, 1e-7, 0.0)
    state = State(0.0, (-0.4,), (1.0,))
    friction = 2.0 * np.tan(0.4)
    height = mechanism.poses(state)[0].corners[-1].imag
    pair = WorkpartPair(-height, friction, friction, 0.5)
    scene = Scene(mechanism, Effects(pairs=(pair,)))
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9))
    motion = resolve_impacts(system, Motion(), pair, "strike", rests=False)
    ((record, _),) = system.recording.contacts
    assert record.velocity_after[0] > system.slow
    assert [contact.pair for contact in motion.contacts] == [pair]


def test_a_link_of_several_that_comes_to_rest_has_an_impact_without_restitution() -> None:
    system, tip = two_rods((0.5, -0.7), 0.5)
    before = system.approach(tip)
    motion = decide(system, Motion(), Happening(Kind.REST, tip))
    assert [contact.pair for contact in motion.contacts] == [tip]
    ((record, links),) = system.recording.contacts
    assert (record.velocity_before[0], links) == (pytest.approx(before), (1,))
    assert record.impulse[0] > 0.0
    assert system.approach(tip) == pytest.approx(0.0, abs=1e-12)


def test_a_single_link_that_comes_to_rest_has_an_impact_without_restitution() -> None:
    mechanism = Mechanism((Link.rod(1.0, 1.0),))
    state = State(0.0, (0.9,), (-0.5,))
    pair = WorkpartPair(-mechanism.poses(state)[0].corners[-1].imag, 0.0, 0.0, 0.5)
    scene = Scene(mechanism, Effects(pairs=(pair,)))
    system = System(scene, state, Extrapolation(1e-9), Plan(1.0, 1e-9))
    motion = decide(system, Motion(), Happening(Kind.REST, pair))
    assert [contact.pair for contact in motion.contacts] == [pair]
    ((record, _),) = system.recording.contacts
    assert record.velocity_before[0] == pytest.approx(-0.5 * np.sin(0.9))
    assert record.velocity_after[0] == pytest.approx(0.0, abs=1e-15)
