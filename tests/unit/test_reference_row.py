"""The reference's row of bristles: Jacobians, balances of impacts and of a sustained contact, and the least pitch."""

import functools
import math

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Surface, Tool
from bristle_sim.reference import simulate_reference, simulate_row_reference
from bristle_sim.reference.contacts import Point, WirePairs
from bristle_sim.reference.mechanics import Chain
from bristle_sim.studies.least_pitch import least_pitch

DIAMETER = Tool().bristle.wire_diameter

IN_FLIGHT = Tool(
    hub=Hub(speed=326.0, radius=0.0283),
    belt=Belt(stiffness=0.031, damping_ratio=0.042),
    bristle=Bristle(mass=8.1e-5, wire_diameter=7.5e-4),
    bar=Bar(horizontal=0.05, vertical=0.021),
)
"""Its wires touch each other in flight, not at the bar as those of the operating point."""


@functools.cache
def row(pitch_deg, friction=0.31, restitution=0.42, hub_turn=1.3):
    return simulate_row_reference(
        Tool(),
        bristles=2,
        pitch=math.radians(pitch_deg),
        neighbour_friction=friction,
        neighbour_restitution=restitution,
        hub_turn=hub_turn,
        accuracy=1e-8,
        sample_interval=2e-5,
    )


def cross(first, second):
    return first[0] * second[1] - first[1] * second[0]


def touching(lines):
    """Place of contact and normal, from the second wire to the first, of two capsules: an end is on the other's flank."""
    for sign, (line, other) in ((1.0, lines), (-1.0, lines[::-1])):
        along = other[1] - other[0]
        foot = other[0] + along * np.clip(along @ (line[1] - other[0]) / (along @ along), 0.0, 1.0)
        if np.hypot(*(line[1] - foot)) == pytest.approx(DIAMETER, rel=1e-6):
            return 0.5 * (line[1] + foot), sign * (line[1] - foot) / np.hypot(*(line[1] - foot))
    raise AssertionError("the wires do not touch")


class TestTouch:
    @pytest.mark.parametrize("angles", [(-1.0, -1.6), (-1.6, -1.0), (-1.3, -1.05)], ids=["end", "flank", "ends"])
    def test_rows_and_biases_are_derivatives(self, angles):
        """Central differences over 1e-7 s, as for the contacts of the lone wire, of a contact that does not open."""
        chain = Chain(Tool(), -1.0, -1.3)
        wires, point = WirePairs(2, DIAMETER, Surface(0.0, 0.0, 1.0)), Point("wire", 0, False)
        accelerations, rates = np.array([7e4, -1e5]), np.array([400.0, 250.0])
        at_rest = wires.touch(chain, chain.kinematics(1e-3, np.array(angles), rates), point)
        rates = rates - at_rest.normal_row * at_rest.velocity[0] / (at_rest.normal_row @ at_rest.normal_row)
        # The surfaces must be in touch, or the place of contact is not one.
        wires.diameter += at_rest.gap

        def after(step):
            moved = np.array(angles) + rates * step + 0.5 * accelerations * step**2
            return wires.touch(chain, chain.kinematics(1e-3 + step, moved, rates + accelerations * step), point)

        before, touch, later = after(-1e-7), after(0.0), after(1e-7)
        assert (later.gap - before.gap) / 2e-7 == pytest.approx(touch.velocity[0], abs=1e-5)
        for i, jacobian in enumerate((touch.normal_row, touch.tangential_row)):
            change = (later.velocity[i] - before.velocity[i]) / 2e-7
            assert change == pytest.approx(jacobian @ accelerations + touch.bias[i], rel=1e-6, abs=0.1)


class TestImpact:
    @pytest.mark.parametrize("pitch_deg", [15.0, 17.0])
    def test_moments_and_energy_balance(self, pitch_deg):
        """About its own root, which the hub carries, each rod gets I dphi' = r x P, the other one with -P.

        So the impulse works I d(phi'^2)/2 on each rod relative to its root, and P.(v_1 - v_2) in all. Angles at the touch
        are good to 1e-8, and 1e-10 of the impacts is left out where many follow each other at one instant.
        """
        first, second = row(pitch_deg)
        records = [[each for each in run.contacts if each.obstacle == "wire"] for run in (first, second)]
        assert len(records[0]) == len(records[1]) > 0
        inertia = Tool().bristle.inertia_about_root
        for front, behind in zip(*records, strict=True):
            assert (front.time, front.impulse) == (behind.time, behind.impulse)
            at = int(abs(first.time - front.time).argmin())
            lines = [run.centre_line[at] for run in (first, second)]
            place, normal = touching(lines)
            impulse = front.impulse[0] * normal + front.impulse[1] * np.array([normal[1], -normal[0]])
            size = inertia * max(abs(front.rates_after[0] - front.rates_before[0]), 1.0)
            for sign, record, line in ((1.0, front, lines[0]), (-1.0, behind, lines[1])):
                change = inertia * (record.rates_after[0] - record.rates_before[0])
                assert change == pytest.approx(sign * cross(place - line[0], impulse), abs=1e-6 * size)
            works = front.compressive_work[0] + front.compressive_work[1] + sum(front.restitutive_work)
            gained = sum(
                0.5 * inertia * (each.rates_after[0] ** 2 - each.rates_before[0] ** 2) for each in (front, behind)
            )
            turn = np.array([[0.0, -1.0], [1.0, 0.0]]) * Tool().hub.speed
            carried = impulse @ (turn @ (lines[0][0] - lines[1][0]))
            assert works == pytest.approx(gained + carried, abs=1e-10 * inertia * front.rates_before[0] ** 2)
            # Stronge's coefficient: what restitution returns of the normal work.
            assert front.restitutive_work[0] == pytest.approx(-(0.42**2) * front.compressive_work[0], rel=1e-9)


class TestRow:
    def test_wires_touch_below_the_least_pitch_by_theory_and_not_above(self):
        """Within 0.05 deg; at the operating point: test_neighbours.py."""
        tool = IN_FLIGHT
        lone = simulate_reference(tool, accuracy=1e-7, stop_after="strike")
        strike = lone.first_contact("workpart").time
        theory = math.degrees(least_pitch(lone, tool.bristle.wire_diameter, until=strike, largest=0.5))
        touched = []
        for pitch in np.radians([theory - 0.05, theory + 0.05]):
            turn = tool.hub.speed * strike - pitch
            runs = simulate_row_reference(tool, bristles=2, pitch=pitch, hub_turn=turn, accuracy=1e-5)
            touched.append(any(each.name == "wire touch" for each in runs[1].events))
        assert touched == [True, False]
