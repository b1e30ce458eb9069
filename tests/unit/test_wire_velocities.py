"""The linear solve that keeps joints and contacts of a wire: its order, a contact without lever, one in a bend, and the way back."""

import itertools

import numpy as np
import pytest

from bristle_sim.parameters import Belt, Bristle, Tool
from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.pairs import BarPair, ClosedPair, WorkpartPair
from bristle_sim.scene.tool import build_tool


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_symmetric_steps_have_even_powers_of_the_step_alone(damping: float) -> None:
    """Halving the step leaves a quarter of the error, and a sixteenth of what extrapolation from two steps leaves."""
    tool = Tool(
        bristle=Bristle(links=3, bending_damping_ratio=damping), belt=Belt(damping_ratio=damping)
    )
    scene, _ = build_tool(tool)
    state = State(0.0, (-1.5, -1.4, -1.6), (1.0, 2.0, -1.0))
    duration = 0.02
    ends = []
    for count in (16, 32, 64, 128):
        step = duration / count
        scene.place(state, -0.5 * step)
        ends.append(np.array(scene.step(step, count, symmetric=True)[:6]))
    errors = np.abs(np.diff(ends, axis=0)).max(axis=1)
    finer = [(4.0 * b - a) / 3.0 for a, b in itertools.pairwise(ends)]
    left = np.abs(np.diff(finer, axis=0)).max(axis=1)
    # The next even power of a step a hundredth of the fastest mode's radian is below 1 % of the first.
    assert errors[:-1] / errors[1:] == pytest.approx([4.0, 4.0], rel=0.02)
    assert left[0] / left[1] == pytest.approx(16.0, rel=0.05)


def test_a_contact_without_lever_bears_nothing() -> None:
    """The tip of a wire that stands upright on the workpart can be pushed no way by turning: K_nn is 0."""
    upright = Mechanism((Link.rod(1.0, 0.4), Link.rod(0.3, 0.5)))
    part = WorkpartPair(0.9, 0.0, 0.0, 0.0, link=1)
    scene = Scene(upright, Effects(hinge=(5.0, 0.0), pairs=(part,)))
    scene.place(State(0.0, (0.0, 0.0), (0.3, -0.2)))
    scene.joint_solver.set_contacts((ClosedPair(part, None, None),))
    scene.joint_solver.solve(1.0)
    ((impulses,),) = scene.joint_solver.impulses
    assert impulses[:2] == [0.0, 0.0]
    rates = [body.angular_velocity for body in scene.links]
    assert rates == pytest.approx([0.3, -0.2], rel=1e-12)


@pytest.mark.parametrize("slip", [0, 1])
def test_a_wire_that_has_drifted_off_its_contact_is_set_back_onto_it(slip: int) -> None:
    """Its tip has sunk in by 1e-4: afterwards the gap is closed and stays so, and a tip that sticks stands still."""
    rods = Mechanism((Link.rod(1.0, 0.4), Link.rod(0.3, 0.5)))
    drifted = State(0.0, (0.4, 0.9), (0.3, -0.2))
    tip = WorkpartPair(-rods.poses(drifted)[1].corners[-1].imag - 1e-4, 0.3, 0.3, 0.0, link=1)
    scene = Scene(rods, Effects(pairs=(tip,)))
    scene.joint_solver.set_contacts((ClosedPair(tip, None, slip),))
    state = scene.joint_solver.set_back(drifted)
    touch = tip.closest(scene.mechanism.poses(state), state.rates)
    assert touch.gap == pytest.approx(0.0, abs=1e-13)
    assert touch.velocity[0] == pytest.approx(0.0, abs=1e-13)
    assert (abs(touch.velocity[1]) < 1e-13) == (slip == 0)


@pytest.mark.parametrize("piece", [0, 1])
def test_the_straight_segment_in_contact_remains_the_selected_one(piece: int) -> None:
    """A bar lies in the bend of a wire's last link, at the same distance from both of its segments."""
    bent = Link(0.5, 0.01, -0.2j, (0j, -0.3j, 0.1 - 0.5j))
    mechanism = Mechanism((Link.rod(1.0, 1.0), bent))
    angles = (0.4, 0.2)
    joint, knee, tip = mechanism.poses(State(0.0, angles, (0.0, 0.0)))[1].corners
    bisector = (joint - knee) / abs(joint - knee) + (tip - knee) / abs(tip - knee)
    pair = BarPair(knee + 0.1 * bisector / abs(bisector), 0.05, 0.0, 0.3, 0.0, link=1)
    scene = Scene(mechanism, Effects(hinge=(5.0, 0.0), pairs=(pair,)))
    scene.place(State(0.0, angles, (0.3, -0.2)))
    scene.joint_solver.set_contacts((ClosedPair(pair, piece, 1),))
    scene.joint_solver.solve(1e-3)
    after = State(0.0, angles, tuple(body.angular_velocity for body in scene.links))
    normal = [
        pair.closest(mechanism.poses(after), after.rates, each).velocity[0] for each in (0, 1)
    ]
    assert normal[piece] == pytest.approx(0.0, abs=1e-14)
    assert abs(normal[1 - piece]) > 1e-3
