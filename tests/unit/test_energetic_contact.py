"""The energetic law in a user's own pymunk space."""

import math

import pymunk
import pytest

from bristle_sim.scene.energetic_contact import EnergeticContact
from bristle_sim.theory.impact import Impact


def kinetic_energy(*bodies: pymunk.Body) -> float:
    """Half of what the engine's property of that name returns, which is m v^2 + I w^2."""
    return sum(0.5 * b.mass * b.velocity.dot(b.velocity) + 0.5 * b.moment * b.angular_velocity**2 for b in bodies)


def falling_rod(
    angle: float, restitution: float, friction: float
) -> tuple[EnergeticContact, pymunk.Body, list[Impact]]:
    """A free rod of 1 m and 1 kg, inclined, that moves down at 2 m/s onto a floor."""
    space = pymunk.Space()
    floor = pymunk.Segment(space.static_body, (-5, -1), (5, -1), 1.0)
    rod = pymunk.Body(1.0, 1.0 / 12.0)
    rod.angle, rod.velocity = angle, (0.0, -2.0)
    rod.position = (0.0, 0.5 * math.cos(angle) + 0.011)
    shape = pymunk.Segment(rod, (0, -0.5), (0, 0.5), 0.01)
    floor.collision_type, shape.collision_type = 1, 2
    space.add(floor, rod, shape)
    impacts: list[Impact] = []
    return (
        EnergeticContact(space, 1, 2, friction=friction, restitution=restitution, report=impacts.append),
        rod,
        impacts,
    )


def test_frictionless_rod_against_the_textbook() -> None:
    """A rod that falls at v without friction: p = (1 + e) v / (1/m + r^2/I) with the lever r of the contact.

    Energetic, Newton's and Poisson's coefficients agree without friction. 2e-3: the engine puts the contact point in the
    middle of the overlap, up to 2e-3 m off along the rod at this step.
    """
    contact, rod, impacts = falling_rod(0.4, 0.6, 0.0)
    for _ in range(40):
        contact.step(1e-4)
    lever = 0.5 * math.sin(0.4)
    impulse = 1.6 * 2.0 / (1.0 + 12.0 * lever**2)
    assert len(impacts) == 1
    assert impacts[0].impulse_normal == pytest.approx(impulse, rel=2e-3)
    assert rod.velocity.y == pytest.approx(impulse - 2.0, rel=2e-3)
    assert rod.velocity.x == 0.0


def test_energy_of_the_bodies_changes_by_the_works() -> None:
    """The impact's own ledger and the engine's bodies agree; no gravity here, so nothing else acts."""
    contact, rod, impacts = falling_rod(0.9, 0.6, 0.3)
    before = kinetic_energy(rod)
    for _ in range(60):
        contact.step(1e-4)
    assert impacts
    assert impacts[0].phase_work_tangential.sum() < 0.0
    assert kinetic_energy(rod) - before == pytest.approx(sum(float(each.energy_change) for each in impacts), rel=1e-12)


def test_jointed_rods_never_gain_energy() -> None:
    """Two hinged rods tumble on a floor for a second: total energy falls at impacts and is kept between them.

    The engine moves by the old velocity, so falling for 1.2 s adds m g^2 dt t/2 = 1.2e-2 J in all to 25 J.
    """
    space = pymunk.Space()
    space.gravity = (0, -9.81)
    floor = pymunk.Segment(space.static_body, (-9, -1), (9, -1), 1.0)
    bodies = [pymunk.Body(1.0, 1.0 / 12.0) for _ in range(2)]
    bodies[0].position = (0.0, 1.8)
    bodies[1].position = (math.sin(0.15), 1.8 - math.cos(0.15))
    shapes = []
    for body in bodies:
        body.angle = 0.15
        shapes.append(pymunk.Segment(body, (0, -0.5), (0, 0.5), 0.01))
        shapes[-1].collision_type = 2
    hinge = pymunk.PivotJoint(*bodies, (0, -0.5), (0, 0.5))
    hinge.collide_bodies, hinge.error_bias = False, 0.0
    floor.collision_type = 1
    space.add(floor, *bodies, *shapes, hinge)
    impacts: list[Impact] = []
    contact = EnergeticContact(space, 1, 2, friction=0.4, restitution=0.6, resting_speed=0.01, report=impacts.append)

    def energy() -> float:
        return kinetic_energy(*bodies) + 9.81 * sum(body.position.y for body in bodies)

    start, lowest = energy(), energy()
    for _ in range(12_000):
        contact.step(1e-4)
        assert energy() <= lowest + 2e-2
        lowest = min(lowest, energy())
    assert len(impacts) >= 3
    assert any("stick" in phase or "reverse" in phase for impact in impacts for phase in impact.phases)
    assert energy() < 0.9 * start
    assert all(float(impact.energy_change) <= 0.0 for impact in impacts)


def test_resting_speed_brings_a_rod_to_rest() -> None:
    """Approaches slower than the resting speed take no restitution, so the rod lies still."""
    contact, rod, _ = falling_rod(1.5, 0.5, 0.5)
    contact.space.gravity = (0, -9.81)
    contact.resting_speed = 0.05
    for _ in range(5_000):
        contact.step(1e-4)
    # One step of gravity is what a resting contact takes away each time.
    assert rod.velocity.length < 2e-3
    assert rod.position.y == pytest.approx(0.01, abs=2e-3)


@pytest.mark.parametrize(
    ("name", "value"),
    [("friction", -0.1), ("friction", math.nan), ("restitution", 1.5), ("restitution_friction", -1.0)],
)
def test_bad_coefficients_are_refused(name: str, value: float) -> None:
    values = {"friction": 0.3, "restitution": 0.5} | {name: value}
    with pytest.raises(ValueError, match=rf"^{name} = "):
        EnergeticContact(pymunk.Space(), 1, 2, **values)


def test_unsupported_joint_is_named() -> None:
    contact, rod, _ = falling_rod(0.4, 0.6, 0.0)
    other = pymunk.Body(1.0, 1.0)
    contact.space.add(other, pymunk.GearJoint(rod, other, 0.0, 1.0))
    rod.position += (0.0, -0.005)
    with pytest.raises(ValueError, match="GearJoint"):
        contact.step(1e-4)


@pytest.mark.parametrize("ratio", [1.0, 1e9, 1e12])
def test_a_tip_that_sticks_under_a_heavy_rod(ratio: float) -> None:
    """Two hinged rods, the upper one hung up at rest: the bodies lose what the impact's ledger says.

    To 1e-9 of the light rod's energy: impulses that cancel but for the last digits would leave 1e-8 at a ratio of 1e9
    and 1e-6 at 1e12.
    """
    space = pymunk.Space()
    angle, rate = math.radians(30.0), 0.2
    upper, lower = pymunk.Body(ratio, ratio / 12.0), pymunk.Body(1.0, 1.0 / 12.0)
    upper.position, lower.angle = (0.0, -0.5), -angle
    lower.position = (-0.5 * math.sin(angle), -1.0 - 0.5 * math.cos(angle))
    lower.angular_velocity = rate
    lower.velocity = (0.5 * rate * math.cos(angle), -0.5 * rate * math.sin(angle))
    tip = -1.0 - math.cos(angle)
    floor, ball = (
        pymunk.Segment(space.static_body, (-5, tip - 1), (5, tip - 1), 1.0),
        pymunk.Circle(lower, 1e-9, (0, -0.5)),
    )
    floor.collision_type, ball.collision_type = 1, 2
    space.add(upper, lower, floor, ball)
    space.add(pymunk.PivotJoint(space.static_body, upper, (0, 0), (0, 0.5)))
    space.add(pymunk.PivotJoint(upper, lower, (0, -0.5), (0, 0.5)))
    impacts: list[Impact] = []
    contact = EnergeticContact(space, 1, 2, friction=5.0, restitution=1.0, report=impacts.append)
    before = kinetic_energy(lower)
    contact.step(1e-12)
    assert len(impacts) == 1
    gained = kinetic_energy(lower) + kinetic_energy(upper) - before
    assert gained == pytest.approx(float(impacts[0].energy_change), abs=1e-9 * before)
