"""Gaps, normals and contact velocities against brute force and finite differences, and the engine's shapes against them."""

import itertools

import numpy as np
import pytest

from bristle_sim.scene.contact.obstacles import BarObstacle, WorkpartObstacle
from bristle_sim.scene.mechanism import Link, Mechanism, Pose, State

STRAIGHT = Link.rod(1.0, 1.0)
KNEES = (0.05, -0.4), (-0.1, -0.7)
BENT = Link(1.0, 0.1, (0.02, -0.45), (0.15, -1.0), KNEES)
LINKS = {"straight": STRAIGHT, "bent": BENT}

BAR = BarObstacle((-0.9, -0.8), 0.2, 0.03, 0.3, 0.1)
WORKPART = WorkpartObstacle(1.6, 0.3, 0.2, 0.4)


def pose_of(link: Link, angle: float, rate: float = 0.0, time: float = 0.0) -> Pose:
    return Mechanism((link,), 0.8, 1.1, -1.0).poses(State(time, (angle,), (rate,)))[0]


def centre_line(pose: Pose) -> np.ndarray:
    """The wire's centre line as 40001 points; the nearest is within 1e-9 of the closest one's distance."""
    corners = np.array([pose.joint, *pose.knees, pose.tip])
    shares = np.linspace(0.0, 1.0, 20001)[:, None]
    return np.concatenate([a + shares * (b - a) for a, b in itertools.pairwise(corners)])


@pytest.mark.parametrize("shape", LINKS)
@pytest.mark.parametrize("seed", range(12))
def test_bar_gap_is_the_least_distance(shape: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    pose, bar = pose_of(LINKS[shape], rng.uniform(-3, 3)), BarObstacle(tuple(rng.uniform(-2, 2, 2)), 0.2, 0.03, 0, 0)
    least = np.linalg.norm(centre_line(pose) - bar.centre, axis=1).min()
    touch = bar.closest([pose], [0.0])
    # Half a spacing of 5e-5 off, the distance is longer by (2.5e-5)^2/2 over itself; distances here exceed 0.01.
    assert touch.gap == pytest.approx(least - 0.23, abs=1e-7)
    contact = np.add(pose.joint, touch.arm)
    assert np.hypot(*touch.normal) == pytest.approx(1.0, abs=1e-14)
    # The contact point is on the wire's surface: it is as far from the bar's surface as the gap.
    np.testing.assert_allclose(contact, np.add(bar.centre, np.multiply(touch.normal, 0.2 + touch.gap)), atol=1e-13)


@pytest.mark.parametrize("shape", LINKS)
@pytest.mark.parametrize("obstacle", [BAR, WORKPART], ids=["bar", "workpart"])
@pytest.mark.parametrize("seed", range(6))
def test_normal_velocity_is_the_gaps_rate(shape: str, obstacle: BarObstacle | WorkpartObstacle, seed: int) -> None:
    rng = np.random.default_rng(50 + seed)
    angle, rate = rng.uniform(-3, 3), rng.uniform(-3, 3)

    def gap(time: float) -> float:
        return obstacle.closest([pose_of(LINKS[shape], angle + rate * time, rate, time)], [rate]).gap

    velocity = obstacle.closest([pose_of(LINKS[shape], angle, rate)], [rate]).velocity[0]
    # Central differences over 1e-5: third derivatives of order 100 leave 2e-9, rounding 1e-11.
    assert velocity == pytest.approx((gap(1e-5) - gap(-1e-5)) / 2e-5, abs=1e-7)
