"""Contact-space inverse mass of pymunk bodies against formulas worked out by hand, for mass ratios from 1e-6 to 1e6."""

import math

import numpy as np
import pymunk
import pytest

from bristle_sim.contact_space.impulse import contact_space

ROUNDING = 1e-13
"""A dozen operations on numbers of order 1."""

RATIOS = [1e-6, 1e-3, 0.3, 1.0, 7.0, 1e3, 1e6]


def rod(mass: float, length: float, root: tuple[float, float], angle: float) -> pymunk.Body:
    """A slender rod that hangs from its root at an angle from -y."""
    body = pymunk.Body(mass, mass * length**2 / 12.0)
    body.angle = angle
    body.position = (root[0] + 0.5 * length * math.sin(angle), root[1] - 0.5 * length * math.cos(angle))
    return body


def hinge(space: pymunk.Space, first: pymunk.Body, second: pymunk.Body, at: tuple[float, float]) -> None:
    space.add(*(each for each in (first, second) if each.space is None), pymunk.PivotJoint(first, second, at))


def unit(angle: float) -> tuple[float, float]:
    return (math.cos(angle), math.sin(angle))


def turned(matrix: np.ndarray, normal_angle: float) -> np.ndarray:
    """A matrix of xy components, seen along a normal and the tangent that is the normal turned clockwise."""
    normal = np.array(unit(normal_angle))
    axes = np.stack([normal, [normal[1], -normal[0]]])
    return axes @ matrix @ axes.T


def double_rods(ratio: float, angle_1: float, angle_2: float) -> np.ndarray:
    """K of the second rod's tip, rods of length 1 and masses n and 1, order (x, y), from q = (theta_1', theta_2').

    T = (n/3 + 1) q_1^2/2 + (1/3) q_2^2/2 + cos(theta_1 - theta_2) q_1 q_2/2; the tip moves at q_1 (cos theta_1, sin
    theta_1) + q_2 (cos theta_2, sin theta_2).
    """
    coupling = 0.5 * math.cos(angle_1 - angle_2)
    diagonal = ratio / 3.0 + 1.0, 1.0 / 3.0
    determinant = diagonal[0] * diagonal[1] - coupling**2
    inverse = np.array([[diagonal[1], -coupling], [-coupling, diagonal[0]]]) / determinant
    tip = np.array([unit(angle_1), unit(angle_2)]).T
    return tip @ inverse @ tip.T


class TestSingleRod:
    @pytest.mark.parametrize("angle", [0.0, 0.4, -1.2, 2.9])
    @pytest.mark.parametrize("share", [1.0, 0.6])
    def test_rod_on_a_fixed_hinge(self, angle: float, share: float) -> None:
        """One degree of freedom: K = J J^T/(m L^2/3) with J = share L along the turn."""
        space, body = pymunk.Space(), rod(2.0, 3.0, (1.0, 2.0), angle)
        hinge(space, space.static_body, body, (1.0, 2.0))
        point = (1.0 + 3.0 * share * math.sin(angle), 2.0 - 3.0 * share * math.cos(angle))
        found = contact_space(body, point, unit(0.7))
        lever = 3.0 * share * np.array(unit(angle))
        expected = turned(np.outer(lever, lever) / (2.0 * 9.0 / 3.0), 0.7)
        np.testing.assert_allclose(found.inverse_mass, expected, atol=ROUNDING)
        # Rank one, to rounding.
        assert abs(np.linalg.det(found.inverse_mass)) < ROUNDING


class TestChains:
    @pytest.mark.parametrize("ratio", RATIOS)
    @pytest.mark.parametrize("seed", range(8))
    def test_double_rods(self, ratio: float, seed: int) -> None:
        angle_1, angle_2, normal = np.random.default_rng(seed).uniform(-math.pi, math.pi, 3).tolist()
        space, first = pymunk.Space(), rod(ratio, 1.0, (0.0, 0.0), angle_1)
        knee = (math.sin(angle_1), -math.cos(angle_1))
        second = rod(1.0, 1.0, knee, angle_2)
        hinge(space, space.static_body, first, (0.0, 0.0))
        hinge(space, first, second, knee)
        tip = (knee[0] + math.sin(angle_2), knee[1] - math.cos(angle_2))
        found = contact_space(second, tip, unit(normal)).inverse_mass
        expected = turned(double_rods(ratio, angle_1, angle_2), normal)
        # Rounding times the root of the mass ratio, 1e3, by which the bodies' scales differ.
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
        assert np.array_equal(found, found.T)
        assert np.linalg.eigvalsh(found).min() >= -1e-15 * np.abs(found).max()


class TestApply:
    @pytest.mark.parametrize("ratio", RATIOS)
    def test_impulse_moves_the_contact_by_k_and_leaves_joints_closed(self, ratio: float) -> None:
        """dv = K p at the contact; T changes by p.v + p.K p/2, the work of p along the way."""
        space, first = pymunk.Space(), rod(ratio, 1.0, (0.0, 0.0), 0.5)
        knee = (math.sin(0.5), -math.cos(0.5))
        second = rod(1.0, 1.0, knee, -0.8)
        hinge(space, space.static_body, first, (0.0, 0.0))
        hinge(space, first, second, knee)
        set_turning(first, second, knee, (0.3, -0.7))
        tip, impulse = (knee[0] + math.sin(-0.8), knee[1] - math.cos(-0.8)), np.array([0.4, -0.9])
        found = contact_space(second, tip, unit(1.1))
        before = kinetic(first, second)
        found.apply(impulse)
        after = contact_space(second, tip, unit(1.1)).velocity
        # Rounding times the root of the mass ratio.
        change = found.inverse_mass @ impulse
        np.testing.assert_allclose(
            np.subtract(after, found.velocity), change, atol=1e-12 * max(1.0, np.abs(change).max())
        )
        work = impulse @ found.velocity + 0.5 * impulse @ change
        assert kinetic(first, second) - before == pytest.approx(work, rel=1e-11, abs=1e-12 * max(1.0, ratio))
        opening = first.velocity_at_world_point(knee) - second.velocity_at_world_point(knee)
        assert abs(opening) < 1e-12 * max(1.0, abs(second.velocity))


def set_turning(first: pymunk.Body, second: pymunk.Body, knee: tuple[float, float], rates: tuple[float, float]) -> None:
    """Velocities of two rods of length 1 that turn about the origin and their knee."""
    first.angular_velocity, second.angular_velocity = rates
    first.velocity = (-rates[0] * first.position.y, rates[0] * first.position.x)
    arm = second.position - knee
    second.velocity = (-rates[0] * knee[1] - rates[1] * arm.y, rates[0] * knee[0] + rates[1] * arm.x)


def kinetic(*bodies: pymunk.Body) -> float:
    return sum(0.5 * b.mass * b.velocity.dot(b.velocity) + 0.5 * b.moment * b.angular_velocity**2 for b in bodies)
