"""The reference's wire of links: the power of its hub, contacts at the edge of what they can bear, compliant strikes."""

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid

from bristle_sim.parameters import Bristle, Contact, Surface, Tool, Workpart
from bristle_sim.reference import simulate_reference, strike_reference
from bristle_sim.reference.contacts import Point, Touch, WirePairs, obstacles_of
from bristle_sim.reference.forces import Acting, acting
from bristle_sim.reference.mechanics import Chain
from bristle_sim.theory.impact import energetic_impact

GAMMA = math.radians(23.4)
RATIO = 3.23
RESTITUTION = 0.42
SPEED = 261.8


class TestFreeWire:
    def test_power_of_the_hub(self):
        """Without gravity the drive's torque is h', h being the angular momentum about the hub's centre.

        Its power is omega h', so that E - omega h is constant. A hundred times the accuracy of 1e-12, of the energy that
        changes.
        """
        tool = Tool(bristle=Bristle(links=3, modulus=1e10), bar=None, workpart=None)
        run = simulate_reference(tool, start_relative_angle=-0.5, duration=0.003, accuracy=1e-12)
        chain = Chain(tool, -0.5 * math.pi)
        motion = chain.kinematics(run.time, run.angles, run.rates)
        place, velocity = chain.points(motion, chain.pieces.links, chain.middles)
        turning = run.rates[:, chain.pieces.links]
        moment = (chain.masses * (np.conj(place) * velocity).imag + chain.inertias * turning).sum(
            axis=1
        )
        balance = run.total_energy - SPEED * moment
        assert np.ptp(balance) < 1e-10 * np.ptp(run.kinetic_energy)


def strike(links, duration, friction=0.0, accuracy=1e-9, longest=None):
    """The radial wire that turns as one when it strikes, model of the rigid bristle's contact of a given duration."""
    depth = 0.0545 * math.cos(GAMMA)
    workpart = Workpart(friction=friction, restitution=RESTITUTION, penetration=0.0545 - depth)
    tool = Tool(bristle=Bristle(links=links), bar=None, workpart=workpart)
    inverse_mass = 3.0 * math.sin(GAMMA) ** 2 / tool.bristle.mass
    stiffness = (math.pi * (1.0 + RESTITUTION) / (2.0 * duration)) ** 2 / inverse_mass
    angles = [-GAMMA] * links
    rates = [RATIO * SPEED] * links
    return strike_reference(
        tool, -GAMMA, angles, rates, stiffness, longest=longest or 3.0 * duration, accuracy=accuracy
    )


class TestCompliantStrike:
    @pytest.mark.parametrize(
        ("links", "impulse", "force", "duration"),
        [(1, 3.154e-3, 66.8, 73.7e-6), (8, 1.473e-3, 29.6, 104e-6)],
    )
    def test_rigid_bristle_gives_twice_the_impulse_of_the_wire(
        self, links, impulse, force, duration
    ):
        """Numbers of an independent prototype; half of their last digits, and the peak lies between two samples of 1 us."""
        contact = strike(links, 71e-6)
        assert contact.impulse[0] == pytest.approx(impulse, abs=0.51e-6)
        assert contact.history.normal_force.max() == pytest.approx(force, abs=0.06)
        assert contact.duration == pytest.approx(duration, rel=5e-3)

    def test_history_gives_the_impulse(self):
        """Trapezoids of h = 1.07 us leave (h w)^2/12 of a force that varies at the rate w, pi (1 + e*)/(2 T e*) = 7.5e4/s.

        That is the rate of restitution of a rigid bristle, 5e-4; the struck link's mass is less than half as large. The
        spring returns e*^2 of the work it took, as the integrator sums it up.
        """
        contact = strike(2, 71e-6)
        history = contact.history
        assert trapezoid(history.normal_force, history.time) == pytest.approx(
            contact.impulse[0], rel=1e-3
        )
        assert history.penetration[0] == pytest.approx(0.0, abs=1e-16)
        assert contact.restitutive_work[0] == pytest.approx(
            -(RESTITUTION**2) * contact.compressive_work[0], rel=1e-8
        )

    def test_a_contact_that_does_not_end_is_refused(self):
        with pytest.raises(
            ValueError, match=r"^longest = .*: must be a time in which the contact ends"
        ):
            strike(1, 71e-6, longest=1e-6)


class TestContacts:
    def test_an_end_on_an_end(self):
        """The normal turns with the line from end to end: central differences over 1e-7 s of a contact that does not open."""
        chain = Chain(Tool(), -1.0, -1.3)
        angles = np.array([-1.3, -1.05])
        wires = WirePairs(chain, Tool().bristle.wire_diameter, Surface())
        point = Point("wire", 0, False)
        at_rest = wires.touch(
            chain, chain.kinematics(1e-3, angles, np.array([400.0, 250.0])), point
        )
        row = at_rest.rows[0]
        rates = np.array([400.0, 250.0]) - row * at_rest.velocity[0] / (row @ row)
        wires.diameter += at_rest.gap
        before, touch, after = (
            wires.touch(chain, chain.kinematics(1e-3 + step, angles + rates * step, rates), point)
            for step in (-1e-7, 0.0, 1e-7)
        )
        changes = [
            (later - earlier) / 2e-7
            for earlier, later in zip(before.velocity, after.velocity, strict=True)
        ]
        assert changes == pytest.approx(touch.bias, rel=1e-6, abs=0.1)

    def test_one_of_two_contacts_at_one_place_bears(self):
        """Both together would have no unique forces."""
        touch = Touch(0.0, np.array([[1.0], [0.0]]), np.array([0.0, 1.0]), np.zeros(2))
        assert len(acting(np.eye(1), np.array([-1.0]), [Acting(touch, 0.0, 1)] * 2, 1e-9)) == 1

    def test_friction_that_locks_a_contact_leaves_no_force(self):
        """Pushed on with 1 N, slip presses it on by 2 - 3 < 0 per newton of normal force; it can neither bear nor open."""
        rows = np.array([[1.0, 0.0], [0.5, 1.0]])
        touch = Touch(0.0, rows, np.array([0.0, 1.0]), np.zeros(2))
        assert acting(np.eye(2), np.array([-1.0, 0.0]), [Acting(touch, 3.0, 1)], 1e-9) is None


class TestTangentialSpring:
    """The spring beside the normal one: with a contact's duration the law's answer, of K alone, is approached in first order."""

    @pytest.mark.parametrize(
        ("links", "squared", "friction", "restitution"),
        [
            (1, 1.21, (0.33, 0.33), 1.0),
            (1, 0.2, (0.22, 0.39), 0.8),
            (2, 0.05, (0.42, 0.42), 0.8),
            (2, 1.5, (0.73, 0.73), 0.0),
            (2, 6.7, (0.09, 0.63), 0.42),
            (3, 0.93, (0.3, 0.17), 0.42),
        ],
    )
    def test_tends_to_the_law(self, links, squared, friction, restitution):
        """A hundred times the stiffness, a tenth of the error, but for a fiftieth of it: no other limit is as near."""
        rng = np.random.default_rng(links)
        angles = -GAMMA + 0.1 * rng.normal(size=links)
        rates = RATIO * SPEED * (1.0 + 0.1 * rng.normal(size=links))
        bristle = Bristle(links=links)
        tip = Chain(Tool(bristle=bristle), -GAMMA).centre_line(0.0, angles, rates)[0][-1]
        part = Workpart(friction[0], friction[1], restitution, 0.0545 + tip.imag)
        tool = Tool(
            bristle=bristle, bar=None, workpart=part, contact=Contact(tangential_compliance=squared)
        )
        chain = Chain(tool, -GAMMA)
        motion = chain.kinematics(0.0, angles, rates)
        touch = obstacles_of(tool)["workpart"].touch(
            chain, motion, Point("workpart", links - 1, True)
        )
        inverse_mass = touch.rows @ np.linalg.solve(chain.mass_matrix(motion.turn), touch.rows.T)
        law = energetic_impact(
            0.5 * (inverse_mass + inverse_mass.T),
            touch.velocity,
            friction[0],
            restitution,
            friction[1],
            None,
            squared,
        )
        errors = []
        for stiffness in (1e9, 1e11):
            longest = 1e-2 / math.sqrt(stiffness / 1e5)
            found = strike_reference(
                tool, -GAMMA, angles.tolist(), rates.tolist(), stiffness, longest=longest
            )
            errors.append(
                np.subtract(found.impulse, (law.impulse_normal, law.impulse_tangential))
                / law.impulse_normal
            )
        assert np.abs(errors[1]).max() < 0.12 * np.abs(errors[0]).max() < 0.01
