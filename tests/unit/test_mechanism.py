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


@pytest.mark.parametrize("seed", range(20))
def test_no_point_is_faster_than_the_bound(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    mechanism, state = chain(rng), random_state(rng)
    fastest = max(math.hypot(*speed) for pose in mechanism.poses(state) for speed in velocities(pose))
    assert fastest <= mechanism.speed_bound(state) * (1.0 + 1e-15)


def velocities(pose: Pose) -> tuple[tuple[float, float], ...]:
    return (pose.joint_velocity, pose.centre_velocity, pose.tip_velocity)
