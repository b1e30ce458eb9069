"""Kinematics of chains of links against complex numbers, finite differences and quadrature."""

import cmath
import math

import numpy as np
import pytest

from bristle_sim.scene.mechanism import Link, Mechanism, Pose, State

STEP = 1e-5
"""Error of central differences: h^2/6 times third derivatives of order 10 is 2e-10, rounding 1e-11."""

BENT = Link(1.3, 0.2, (0.1, -0.45), (0.3, -0.9), ((0.0, -0.6),))


def chain(rng: np.random.Generator, links: int = 3) -> Mechanism:
    rods = tuple(Link.rod(float(rng.uniform(0.1, 3.0)), float(rng.uniform(0.2, 2.0))) for _ in range(links - 1))
    return Mechanism((*rods, BENT), 0.7, 1.3, -0.4)


def random_state(rng: np.random.Generator, links: int = 3) -> State:
    angles, rates = rng.uniform(-3.0, 3.0, (2, links))
    return State(float(rng.uniform(-1.0, 1.0)), tuple(angles.tolist()), tuple(rates.tolist()))


def moved(state: State, time: float) -> State:
    """Return the links a little later, at constant rates."""
    angles = tuple(angle + rate * time for angle, rate in zip(state.angles, state.rates, strict=True))
    return State(state.time + time, angles, state.rates)


def test_rod() -> None:
    rod = Link.rod(2.0, 3.0)
    assert (rod.inertia, rod.centre, rod.tip, rod.knees) == (1.5, (0.0, -1.5), (0.0, -3.0), ())


@pytest.mark.parametrize("seed", range(5))
def test_poses_are_turned_arms_one_after_the_other(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mechanism, state = chain(rng), random_state(rng)
    joint = -0.7j * cmath.exp(1j * (-0.4 + 1.3 * state.time))
    for link, pose, angle in zip(mechanism.links, mechanism.poses(state), state.angles, strict=True):
        turn = cmath.exp(1j * angle)
        # Rounding of numbers of order 1.
        assert complex(*pose.joint) == pytest.approx(joint, abs=1e-14)
        assert complex(*pose.centre) == pytest.approx(joint + complex(*link.centre) * turn, abs=1e-14)
        for knee, place in zip(link.knees, pose.knees, strict=True):
            assert complex(*place) == pytest.approx(joint + complex(*knee) * turn, abs=1e-14)
        joint += complex(*link.tip) * turn
        assert complex(*pose.tip) == pytest.approx(joint, abs=1e-14)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("point", ["joint", "centre", "tip"])
def test_velocities_are_derivatives_of_places(seed: int, point: str) -> None:
    rng = np.random.default_rng(100 + seed)
    mechanism, state = chain(rng), random_state(rng)

    def places(time: float) -> np.ndarray:
        return np.array([getattr(pose, point) for pose in mechanism.poses(moved(state, time))])

    velocities = [getattr(pose, f"{point}_velocity") for pose in mechanism.poses(state)]
    slope = (places(STEP) - places(-STEP)) / (2.0 * STEP)
    np.testing.assert_allclose(velocities, slope, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("links", [1, 2, 4])
def test_centre_line_runs_from_the_root_over_joints_and_knees_to_the_tip(links: int) -> None:
    """Compared with one turned arm after the other; its velocities with central differences of its places."""
    rng = np.random.default_rng(links)
    mechanism, state = chain(rng, links), random_state(rng, links)

    def line(time: float) -> tuple[np.ndarray, np.ndarray]:
        at = moved(state, time)
        return mechanism.centre_line(np.array([at.time]), np.array([at.angles]), np.array([at.rates]))

    (places,), (velocities,) = line(0.0)
    point = -0.7j * cmath.exp(1j * (-0.4 + 1.3 * state.time))
    expected = [point]
    for link, angle in zip(mechanism.links, state.angles, strict=True):
        expected += [point + complex(*corner) * cmath.exp(1j * angle) for corner in (*link.knees, link.tip)]
        point = expected[-1]
    assert places.shape == velocities.shape == (links + 2, 2)  # root, a tip for every link, and the last one's knee
    np.testing.assert_allclose(places @ [1.0, 1j], expected, atol=1e-14)
    (later,), _ = line(STEP)
    (earlier,), _ = line(-STEP)
    # Third derivatives of the root's and of each link's circle, radius times rate cubed, at most 2 x 27.
    np.testing.assert_allclose(velocities, (later - earlier) / (2.0 * STEP), atol=1e-8)


def test_kinetic_energy_is_that_of_the_rods_elements() -> None:
    """Three-point Gauss quadrature is exact for the square of a velocity that is linear along a rod."""
    rng = np.random.default_rng(7)
    rods = tuple(Link.rod(mass, length) for mass, length in rng.uniform(0.2, 2.0, (3, 2)).tolist())
    mechanism, state = Mechanism(rods, 0.7, 1.3), random_state(rng)
    nodes, weights = np.polynomial.legendre.leggauss(3)
    total = 0.0
    for link, pose in zip(rods, mechanism.poses(state), strict=True):
        ends = np.array([pose.joint_velocity, pose.tip_velocity])
        velocity = 0.5 * ((1.0 - nodes)[:, None] * ends[0] + (1.0 + nodes)[:, None] * ends[1])
        total += float(0.25 * link.mass * weights @ (velocity**2).sum(axis=1))
    assert mechanism.kinetic_energy(state) == pytest.approx(total, rel=1e-13)


@pytest.mark.parametrize("seed", range(20))
def test_no_point_is_faster_than_the_bound(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    mechanism, state = chain(rng), random_state(rng)
    fastest = max(math.hypot(*speed) for pose in mechanism.poses(state) for speed in velocities(pose))
    assert fastest <= mechanism.speed_bound(state) * (1.0 + 1e-15)


def velocities(pose: Pose) -> tuple[tuple[float, float], ...]:
    return (pose.joint_velocity, pose.centre_velocity, pose.tip_velocity)


def test_the_bound_is_reached_by_a_straight_chain() -> None:
    mechanism = Mechanism((Link.rod(1.0, 1.0), Link.rod(1.0, 2.0)), 0.5, 3.0, 0.2)
    state = State(0.0, (0.2, 0.2), (3.0, 5.0))
    assert math.hypot(*mechanism.poses(state)[-1].tip_velocity) == pytest.approx(0.5 * 3 + 3 + 10, rel=1e-14)
    assert mechanism.speed_bound(state) == 0.5 * 3 + 3 + 10


def test_without_a_hub_the_root_is_the_origin() -> None:
    pose = Mechanism((Link.rod(1.0, 1.0),)).poses(State(0.3, (0.5,), (2.0,)))[0]
    assert pose.joint == (0.0, 0.0)
    assert pose.joint_velocity == (0.0, 0.0)


def test_poses_of_a_state_are_computed_once() -> None:
    """Of the state itself: an equal one may be of another mechanism's making, and comparing costs more than computing."""
    mechanism, state = chain(np.random.default_rng(3)), random_state(np.random.default_rng(4))
    found = mechanism.poses(state)
    assert mechanism.poses(state) is found
    again = mechanism.poses(State(*state))
    assert again is not found
    assert again == found
