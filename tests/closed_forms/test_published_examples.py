"""The impact laws on examples from the literature.

Each docstring says where the example is from and how its numbers were obtained: read in the source named, or derived
there and then from the source's statement. No number comes from this program.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from bristle_sim.theory.impact import energetic_impact, newton_impact, poisson_impact
from bristle_sim.theory.pendulums import double_pendulum_impact, single_pendulum_impact

LAWS = [energetic_impact, poisson_impact, newton_impact]
STRONGE = {"angle_1": math.radians(20), "angle_2": math.radians(30), "rate_1": -0.1, "rate_2": -0.2}


def double_pendulum(angle_1: float, angle_2: float, rate_1: float, rate_2: float):
    """Identical rods of unit mass and length: mass matrix, contact Jacobian (normal, tangential) and rates."""
    coupled = math.cos(angle_1 - angle_2) / 2
    mass = np.array([[4 / 3, coupled], [coupled, 1 / 3]])
    jacobian = np.array(
        [[math.sin(angle_1), math.sin(angle_2)], [-math.cos(angle_1), -math.cos(angle_2)]]
    )
    return mass, jacobian, np.array([rate_1, rate_2])


def relative_gain(law, friction: float, restitution: float) -> float:
    """Energy gained over the energy before, for Stronge's double pendulum."""
    mass, jacobian, rates = double_pendulum(**STRONGE)
    matrix = jacobian @ np.linalg.solve(mass, jacobian.T)
    result = law((matrix + matrix.T) / 2, jacobian @ rates, friction, restitution)
    return result.energy_change / (0.5 * rates @ mass @ rates)


# Double pendulum: Kane and Levinson's paradox


def test_newtons_law_makes_energy_on_the_double_pendulum():
    """The paradox of the double pendulum whose tip ends in stick, and that the other two laws do without it.

    Kane and Levinson (*Dynamics: Theory and Applications*, 1985) showed for a double pendulum that Newton's coefficient
    with friction gives energetically inconsistent results (so Marghitu and Zhao, Mathematics 8 (2020) 1202, sec. 1).
    Stronge, *Unraveling paradoxical theories for rigid body collisions*, J. Appl. Mech. 58 (1991) 1049, abstract:
    Newton's law "results in calculations of paradoxical increases in energy for collisions where slip reverses", and with
    the energetic one "both normal and tangential components of the impulsive reaction always dissipate energy".

    The number is derived: a tip that ends in stick under Newton's law has v_C = (0, -e v_y), and v_C gives both rates.
    """
    mass, jacobian, rates = double_pendulum(**STRONGE)
    normal = (jacobian @ rates)[0]
    for e in (0.5, 0.7, 0.9, 1.0):
        after = np.linalg.solve(jacobian, [-e * normal, 0.0])
        derived = (after @ mass @ after) / (rates @ mass @ rates) - 1
        assert derived > 0.5
        for friction in (0.7, 1.0, 2.0):
            # Roundings times the condition of the Jacobian, 40.
            assert relative_gain(newton_impact, friction, e) == pytest.approx(derived, rel=1e-12)
            assert relative_gain(energetic_impact, friction, e) < -0.3
            assert relative_gain(poisson_impact, friction, e) < -0.3


def test_all_three_laws_lose_the_same_without_friction():
    """Frictionless, the loss is (1 - e^2) v_y^2/(2 K_yy) whichever the coefficient: derived, textbook result."""
    mass, jacobian, rates = double_pendulum(**STRONGE)
    normal = (jacobian @ rates)[0]
    compliance = jacobian[0] @ np.linalg.solve(mass, jacobian[0])
    derived = -(1 - 0.5**2) * normal**2 / compliance / (rates @ mass @ rates)
    for law in LAWS:
        assert relative_gain(law, 0.0, 0.5) == pytest.approx(derived, rel=1e-13)


def test_energetic_and_poisson_part_only_where_slip_stops():
    """Stronge (1991) and Wang and Mason, J. Appl. Mech. 59 (1992) 635: the laws agree while slip keeps its direction.

    The contact is that of Stronge's pendulum, the velocity of its tip is set so that slip lasts or stops.
    """
    mass, jacobian, _ = double_pendulum(**STRONGE)
    matrix = jacobian @ np.linalg.solve(mass, jacobian.T)
    for tangential, lasts in ((5.0, True), (0.5, False)):
        results = [law((matrix + matrix.T) / 2, [-1.0, tangential], 0.3, 0.5) for law in LAWS]
        impulses = [result.impulse_normal for result in results]
        assert all(math.isinf(result.slip_stop_impulse) is lasts for result in results)
        assert (max(impulses) - min(impulses) < 1e-13) is lasts


def test_double_pendulum_of_zhang_2020():
    """Zhang 2020, figs. 2.28 and 2.29: rod OB keeps its -0.1 rad/s as n grows, the figures' parameters with n = 1e4.

    -0.1000230 and 0.1212083 rad/s were evaluated from eqs. 2.98-2.108 apart from this program.
    """
    result = double_pendulum_impact(5.0, 1e4, 1.0, **STRONGE, friction=0.5, restitution=0.5)
    assert (result.final_rate_1, result.final_rate_2) == pytest.approx(
        (-0.1000230, 0.1212083), abs=5e-8
    )
    assert result.kinetic_energy_ratio < 1.0


@pytest.mark.parametrize("angle_deg", [5.0, 23.4, 45.0, 80.0])
def test_single_pendulum_of_stronge(angle_deg):
    """Zhang 2020, sec. 2.4.1, after Stronge: -e* sqrt((1 - mu cot gamma)/(1 + mu cot gamma)), no rebound from tan gamma on.

    The formula is derived in ``pendulums``; here it is read off the law by the energy that is left, which is its square.
    """
    angle = math.radians(angle_deg)
    lever = np.array([math.sin(angle), -math.cos(angle)])
    matrix = 3.0 * np.outer(lever, lever)
    velocity = -2.0 * lever
    for share in (0.0, 0.3, 0.99, 1.01, 3.0):
        friction = share * math.tan(angle)
        result = energetic_impact(matrix, velocity, friction, 0.42)
        left = 1 + result.energy_change / (2.0**2 / 6)
        expected = 0.42**2 * (1 - share) / (1 + share) if share < 1 else 0.0
        # Of the order of rounding of 1 + energy_change, more where tan gamma magnifies it.
        assert left == pytest.approx(expected, abs=1e-12)
        ratio = single_pendulum_impact(1.0, 1.0, angle, -2.0, friction, 0.42).rebound_ratio
        assert ratio**2 == pytest.approx(expected, abs=1e-12)


# Two free bodies: the orders of events in a published program


def polygon_and_ellipse(velocity: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """K and v of a polygon struck by an elliptic bat at one vertex, from the data in ``ep_impact_test.m`` (see below).

    Polygon: 0.180 kg, vertices below, struck at the origin, spin -30 rad/s. Bat: 0.252 kg, half axes 70 and 45 mm, spin
    9.011 rad/s, struck at the polar angle -2.944 of its surface point.
    """
    corners = np.array([[0, 0], [0.01, 0.03], [0.07, 0.05], [0.07, 0], [0.05, -0.02]])
    following = np.roll(corners, -1, axis=0)
    cross = corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1]
    area = cross.sum() / 2
    centre = ((corners + following) * cross[:, None]).sum(axis=0) / (6 * area)
    second = ((corners**2 + following**2 + corners * following).sum(axis=1) * cross).sum() / 12
    polygon = 0.180
    bat = 0.252
    polygon_inertia = polygon * (second / area - centre @ centre)
    long = 0.070
    short = 0.045
    polar = -2.944
    bat_inertia = bat * (long**2 + short**2) / 4

    # The point of the ellipse at that polar angle, and its tangent turned so that the bat's centre lies along -x.
    slope = math.tan(polar)
    x = -long * short / math.sqrt(long**2 * slope**2 + short**2) * math.copysign(1.0, slope)
    y = -slope * x
    turn = np.array([[math.cos(polar), -math.sin(polar)], [math.sin(polar), math.cos(polar)]])
    tangent = turn @ [1.0, -x * short**2 / (y * long**2)]
    tangent /= np.linalg.norm(tangent)
    normal = np.array([-tangent[1], tangent[0]])

    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    arms = quarter @ -centre, quarter @ [math.hypot(x, y), 0.0]
    inverse = np.eye(2) * (1 / polygon + 1 / bat)
    inverse += (
        np.outer(arms[0], arms[0]) / polygon_inertia + np.outer(arms[1], arms[1]) / bat_inertia
    )
    relative = velocity - 30.0 * arms[0] - np.array([2.345, 4.339]) - 9.011 * arms[1]
    axes = np.stack([normal, tangent])
    matrix = axes @ inverse @ axes.T
    return (matrix + matrix.T) / 2, axes @ relative


@pytest.mark.parametrize(
    ("velocity", "friction", "phases"),
    [
        ([-1.52, -2.75], 0.5, ("compression slip", "restitution slip")),
        ([-1.52, -2.75], 0.95, ("compression slip", "compression stick", "restitution stick")),
        ([-1.52, -2.75], 0.8, ("compression slip", "restitution slip", "restitution stick")),
        (
            [0.0, 7.5],
            0.3,
            ("compression slip", "compression reverse slip", "restitution reverse slip"),
        ),
        ([0.0, 7.5], 0.01, ("compression slip", "restitution slip", "restitution reverse slip")),
    ],
)
def test_orders_of_events_of_a_published_program(velocity, friction, phases):
    """Five impacts with e* = 0.95 and the order of stop (s), end of compression (c) and of restitution (r) they show.

    Data and orders were read in ``2D Impact/ep_impact_test.m`` of github.com/xqmu/2D-Frictional-Impact, which says of
    itself that it makes fig. 3 (b)-(f) of http://robotics.cs.iastate.edu/papers/IJRR19.pdf: mu = 0.5 <c, r>, 0.95
    <s, c, r> sticking, 0.8 <c, s, r> sticking; and, with another velocity, 0.3 <s, c, r> and 0.01 <c, s, r> reverse
    sliding.
    """
    matrix, contact_velocity = polygon_and_ellipse(velocity)
    assert contact_velocity[0] < 0.0
    result = energetic_impact(matrix, contact_velocity, friction, 0.95)
    assert result.phases == phases
    assert result.restitutive_work[0] == pytest.approx(
        -(0.95**2) * result.compressive_work[0], rel=1e-13
    )


# Sphere and rod


def sphere_contact(normal: float, tangential: float) -> tuple[np.ndarray, list[float]]:
    """Solid sphere of unit mass without spin: K = diag(1, 1 + 5/2), since the inertia is 2/5 of m r^2."""
    return np.diag([1.0, 3.5]), [-normal, tangential]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("incidence_deg", [70.0, 80.0, 88.0])
def test_skidding_sphere(law, incidence_deg):
    """Textbook problem, read at physicsforums.com/threads/922403: |tan theta - tan Phi| = 2 mu, spin 5 mu v cos theta/a.

    For a solid sphere of radius a that strikes at the speed v and the angle theta to the normal, skids throughout and
    keeps its normal speed (e = 1); Phi is the angle of reflection of its centre.
    """
    friction = 0.2
    speed = 3.0
    angle = math.radians(incidence_deg)
    matrix, velocity = sphere_contact(speed * math.cos(angle), speed * math.sin(angle))
    result = law(matrix, velocity, friction, 1.0)
    assert result.phases == ("compression slip", "restitution slip")
    centre = velocity[1] + result.impulse_tangential
    assert math.tan(angle) - centre / result.velocity_normal == pytest.approx(
        2 * friction, rel=1e-12
    )
    spin = -2.5 * result.impulse_tangential
    assert spin == pytest.approx(5 * friction * speed * math.cos(angle), rel=1e-13)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("e", [0.0, 0.6, 1.0])
def test_sphere_that_rolls_off(law, e):
    """A solid sphere skids throughout if tan theta > 7 mu (1 + e)/2 and else leaves rolling, with 5/7 of its v_t.

    Derived: K is diagonal, so slip stops at p = v_t/(3.5 mu) of the (1 + e) v_n there is, and angular momentum about the
    contact, v_t + (2/5) a omega, is kept.
    """
    friction = 0.15
    border = 3.5 * friction * (1 + e)
    for tangent, rolls in ((0.99 * border, True), (1.01 * border, False)):
        matrix, velocity = sphere_contact(1.0, tangent)
        result = law(matrix, velocity, friction, e)
        assert (result.velocity_tangential == 0.0) is rolls
        centre = tangent + result.impulse_tangential
        expected = 5 / 7 * tangent if rolls else tangent - friction * (1 + e)
        assert centre == pytest.approx(expected, rel=1e-13)


def rod_contact(angle: float) -> np.ndarray:
    """K of the end of a free uniform rod of unit mass at an angle to the surface, its centre ahead of the contact.

    Half length h, inertia h^2/3, arm h (cos, sin): K = ((1 + 3 cos^2, -3 sin cos), (-3 sin cos, 1 + 3 sin^2)).
    """
    sine, cosine = math.sin(angle), math.cos(angle)
    return np.array(
        [[1 + 3 * cosine**2, -3 * sine * cosine], [-3 * sine * cosine, 1 + 3 * sine**2]]
    )


def test_painleve_rod():
    """Painleve's rod: a uniform rod that slips towards its centre can be pressed on only if mu >= 4/3, at tan theta = 2.

    Derived: K_nn - mu |K_nt| < 0 needs mu > (1 + 3 cos^2)/(3 sin cos) = (4 + tan^2)/(3 tan), least 4/3 at tan = 2. At
    that point slip leaves v_n unchanged, just beyond it the end of the rod speeds up into the surface until slip stops.
    """
    angle = math.atan(2.0)
    tightest = [
        matrix[0, 0] / abs(matrix[0, 1])
        for matrix in map(rod_contact, np.linspace(0.01, 1.56, 2000))
    ]
    # The minimum is flat: a grid of 8e-4 rad misses it by (8e-4)^2.
    assert min(tightest) == pytest.approx(4 / 3, rel=1e-6)
    matrix = rod_contact(angle)
    for friction, works in ((4 / 3 * 1.01, -1), (4 / 3 * 0.99, 1)):
        # Slip against the coupling, K_nt < 0.
        result = energetic_impact(matrix, [-1.0, -0.1], friction, 0.5)
        assert result.phases[0] == "compression slip"
        first = result.phase_impulse[0]
        end = 2 * result.phase_work_normal[0] / first + 1.0
        assert math.copysign(1.0, end + 1.0) == works
        assert result.velocity_normal > 0.0
