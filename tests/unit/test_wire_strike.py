"""A wire that bends strikes through the scene: against the independent solution, closed forms and balances."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.parameters import (
    Belt,
    Bristle,
    Contact,
    ContactStiffness,
    Hub,
    Surface,
    Tool,
    Workpart,
)
from bristle_sim.reference import TooStiffError, strike_reference
from bristle_sim.reference.mechanics import Chain as Links
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import strike_wire, wire_frequencies
from bristle_sim.settings import Settings
from bristle_sim.theory.wire import chain_frequencies
from bristle_sim.trajectory import ContactRecord

GAMMA = math.radians(23.4)
RATE = 3.23 * 261.8
DURATION = 71e-6


def radial(bristle: Bristle, surface: Surface, hub_angle: float, angles: list[float]) -> Tool:
    """The tool whose workpart is at the end of a wire."""
    tip = Links(Tool(bristle=bristle, bar=None), hub_angle).centre_line(
        0.0, np.array(angles), np.zeros(len(angles))
    )
    x, y = bristle.path[-1]
    reach = math.hypot(x, Hub().radius - y)
    part = Workpart(
        surface.friction,
        surface.restitution_friction,
        surface.restitution,
        penetration=reach + float(tip[0][-1].imag),
    )
    return Tool(bristle=bristle, bar=None, workpart=part)


def stiffness(tool: Tool, duration: float) -> float:
    """That of the rigid bristle's frictionless contact of the duration: (pi (1 + e*)/(2 T))^2/K_nn, K_nn = 3 sin^2/m."""
    restitution = tool.workpart.restitution
    return (
        (math.pi * (1.0 + restitution) / (2.0 * duration)) ** 2
        * tool.bristle.mass
        / (3.0 * math.sin(GAMMA) ** 2)
    )


def both(
    tool: Tool,
    hub_angle: float,
    angles: list[float],
    rates: list[float],
    duration: float = DURATION,
) -> tuple[ContactRecord, ContactRecord]:
    """A strike through the scene and by the independent solution."""
    start = (tool, hub_angle, angles, rates, stiffness(tool, duration))
    return (
        strike_wire(*start, Settings(), duration=duration).contact,
        strike_reference(*start, longest=10.0 * duration),
    )


def assert_equal(scene: ContactRecord, reference: ContactRecord) -> None:
    """To ten times the accuracy of 1e-6, impulses and works relative to the normal ones."""
    size = reference.impulse[0]
    assert scene.impulse == pytest.approx(reference.impulse, rel=0.0, abs=1e-5 * size)
    assert scene.compressive_impulse == pytest.approx(
        reference.compressive_impulse, rel=0.0, abs=1e-5 * size
    )
    assert scene.duration == pytest.approx(reference.duration, rel=1e-5)
    assert scene.history.normal_force.max() == pytest.approx(
        reference.history.normal_force.max(), rel=1e-5
    )
    fastest = np.abs(reference.rates_after).max()
    assert scene.rates_after == pytest.approx(reference.rates_after, rel=0.0, abs=1e-5 * fastest)


CASES = {
    "frictionless": (Bristle(links=2), Surface(0.0), 0.0),
    "with friction": (Bristle(links=4), Surface(0.31), 0.0),
    "friction that sticks": (Bristle(links=4), Surface(0.9), 0.1),
    "damped": (Bristle(links=2, bending_damping_ratio=0.1), Surface(0.2), 0.1),
    "with a knee": (Bristle(links=3, knee_angle_deg=30.0), Surface(0.4, None, 0.7), 0.1),
    "rougher in restitution": (Bristle(links=3), Surface(0.2, 0.6), 0.1),
    "smoother in restitution": (Bristle(links=3), Surface(0.9, 0.1), 0.1),
    "soft": (Bristle(links=5, modulus=2e9), Surface(0.3), 0.0),
}


@pytest.mark.parametrize("name", CASES)
def test_scene_and_reference_agree(name: str) -> None:
    bristle, surface, spread = CASES[name]
    chance = np.random.default_rng(1)
    angles = (-GAMMA + spread * chance.normal(size=bristle.links)).tolist()
    rates = (RATE * (1.0 + spread * chance.normal(size=bristle.links))).tolist()
    tool = radial(bristle, surface, -GAMMA, angles)
    if name == "damped":
        tool = replace(tool, belt=Belt(damping_ratio=0.2))
    assert_equal(*both(tool, -GAMMA, angles, rates))


def test_slip_that_stops_and_resumes_within_an_interval() -> None:
    """Vibration takes the slip through zero and back in a microsecond: two of eight phases are that short."""
    angles = [-0.25, -0.31, -0.42, -0.29]
    rates = [950.0, 920.0, 810.0, 1020.0]
    tool = radial(Bristle(links=4), Surface(0.57), -0.36, angles)
    assert_equal(*both(tool, -0.36, angles, rates, 1.711e-4))


def test_a_spring_that_is_loaded_again_returns_its_part_of_the_work() -> None:
    """Compression ends several times; W_r = -e*^2 W_c holds for the last end, where the spring is deepest."""
    tool = radial(Bristle(links=4), Surface(0.0, None, 0.6), -GAMMA, [-GAMMA] * 4)
    for duration in (100e-6, 200e-6):
        scene, reference = both(tool, -GAMMA, [-GAMMA] * 4, [RATE] * 4, duration)
        for record in (scene, reference):
            assert record.restitutive_work[0] == pytest.approx(
                -(0.6**2) * record.compressive_work[0], rel=1e-6
            )
    assert (
        scene.phases.count("compression slip") + scene.phases.count("compression reverse slip") > 1
    )


def test_slip_between_two_frictions_stays_at_rest_where_the_wire_presses_on() -> None:
    """Friction pushes this tip up: with mu_1 it parts at the deepest point, with the smaller mu_2 the wire presses it on.

    So v_n = 0 under a friction between the two, and penetration and normal force stay. Unloading and loading by turns takes
    some 600 steps for 1e-6 of that time. The two accuracies agree to ten times the coarser one; friction is within its limits
    to rounding, which it reaches where rest begins and ends.
    """
    surface = Surface(0.87, 0.04, 0.26)
    angles = [-GAMMA] * 6
    tool = radial(Bristle(links=6), surface, -GAMMA, angles)
    coarse, fine = (
        strike_wire(
            tool,
            -GAMMA,
            angles,
            [RATE] * 6,
            stiffness(tool, DURATION),
            Settings(accuracy=accuracy, maximum_steps=20_000),
            duration=DURATION,
        ).contact
        for accuracy in (1e-4, 1e-7)
    )
    assert coarse.impulse == pytest.approx(fine.impulse, rel=0.0, abs=1e-3 * fine.impulse[0])
    assert coarse.rates_after == pytest.approx(
        fine.rates_after, rel=0.0, abs=1e-3 * max(map(abs, fine.rates_after))
    )
    history = fine.history
    normal = history.normal_force
    friction = np.abs(history.tangential_force)
    rests = (np.abs(history.normal_velocity) < 1e-6) & (history.tangential_velocity > 1.0)
    assert np.count_nonzero(rests) > 3
    assert (friction[rests] >= 0.04 * normal[rests] * (1.0 - 1e-6)).all()
    assert (friction[rests] <= 0.87 * normal[rests] * (1.0 + 1e-6)).all()


@pytest.mark.parametrize("accuracy", [3e-6, 1e-6])
def test_a_spring_that_lets_go_for_a_moment_within_an_interval(accuracy: float) -> None:
    """The wire leaves with a tenth of the speed at which it vibrates: 0.06 of 3.5 us later it would be back.

    At e* = 0.078 restitution is 166 times as stiff as compression; at an accuracy a hundred times as fine the contact lasts
    100.6282 us, and by the independent solution.
    """
    angle = math.radians(10.09)
    links = 8
    tool = radial(Bristle(links=links), Surface(0.0, None, 0.07754), -angle, [-angle] * links)
    impact = (tool, -angle, [-angle] * links, [RATE] * links)
    inverse_mass = 3.0 * math.sin(angle) ** 2 / tool.bristle.mass
    spring = ContactStiffness().stiffness(inverse_mass, 0.07754)
    reference = strike_reference(*impact, spring, longest=1e-3)
    scene = strike_wire(
        *impact, spring, Settings(accuracy=accuracy), duration=ContactStiffness().duration
    ).contact
    assert scene.impulse[0] == pytest.approx(reference.impulse[0], rel=10.0 * accuracy)
    assert scene.duration == pytest.approx(reference.duration, rel=10.0 * accuracy)


@pytest.mark.parametrize("links", [1, 2, 8])
def test_frequencies_are_those_of_the_chain(links: int) -> None:
    """The slowest of n modes is found to the rounding of the fastest one's square, 1e-16 (2e5 Hz/167 Hz)^2."""
    bristle = Bristle(links=links, bending_damping_ratio=0.3)
    wire = (bristle.mass, bristle.length, bristle.wire_diameter, bristle.modulus, Belt().stiffness)
    found = wire_frequencies(Tool(bristle=bristle, belt=Belt(damping_ratio=0.2)))
    assert found == pytest.approx(chain_frequencies(*wire, links), rel=1e-9)


def test_an_end_that_does_not_approach_is_refused() -> None:
    tool = Tool(bristle=Bristle(links=2), bar=None)
    with pytest.raises(ValueError, match="must let the wire's end approach"):
        strike_wire(tool, -GAMMA, [-GAMMA] * 2, [-RATE] * 2, 1e5, Settings(), duration=DURATION)


def test_too_many_evaluations_are_refused() -> None:
    """A step of the integrator takes twelve, and a contact some steps."""
    tool = radial(Bristle(links=2), Surface(0.0), -GAMMA, [-GAMMA] * 2)
    impact = (tool, -GAMMA, [-GAMMA] * 2, [RATE] * 2, stiffness(tool, DURATION))
    with pytest.raises(
        TooStiffError, match=r"stiffness = .*: must be less for the independent solution"
    ):
        strike_reference(*impact, longest=10.0 * DURATION, most_evaluations=24)


def test_a_contact_that_is_pressed_on_again_returns_its_share_of_the_work() -> None:
    """A vibrating wire presses its tip deeper while the spring unloads: the spring returns e*^2 of all that it took."""
    tool = Tool(
        bristle=Bristle(links=2, modulus=2e10),
        workpart=Workpart(friction=0.31, restitution=0.42),
        contact=Contact("compliant", 1e-3),
    )
    contact = simulate(tool, Settings(accuracy=1e-6), stop_after="strike").first_contact("workpart")
    loading = [phase.startswith("compression") for phase in contact.phases]
    assert sorted(loading, reverse=True) != loading
    assert contact.restitutive_work[0] == pytest.approx(
        -(0.42**2) * contact.compressive_work[0], rel=1e-6
    )
