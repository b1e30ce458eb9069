"""The energetic law and the engine's own, against angular momentum and Newton's restitution."""

import math

import numpy as np
import pytest

from bristle_sim.contact_space.impulse import contact_space
from bristle_sim.contact_space.joints import joined
from bristle_sim.parameters import Bristle, Surface, Tool
from bristle_sim.scene import impacts
from bristle_sim.scene.impacts import EnergeticLaw, EngineLaw, contact_at
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.pairs import WorkpartPair
from bristle_sim.scene.strike import Chain, build_strike
from bristle_sim.scene.tool import build_tool


class TestEngineLaw:
    """Newton's restitution of one rod at 0.6: v_n is -e times what it was, whatever friction does (one freedom)."""

    @pytest.mark.parametrize(
        ("friction", "restitution"), [(0.0, 0.5), (0.3, 0.5), (0.0, 1.0), (0.0, 0.0)]
    )
    def test_one_rod(
        self, friction: float, restitution: float, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """Slip does not turn before the normal velocity does, so p_t = -mu p_n and p_n = -(1 + e) v_n/(K_nn + mu K_nt).

        With friction that is so in compression; the clamp then takes what is left of slip as it comes.
        """
        monkeypatch.setattr(impacts, "ENGINE_ITERATIONS", 100)
        chain = Chain((2.0,), (1.0,), (-0.6,), (1.0,))
        surface = Surface(friction, None, restitution)
        scene, state, obstacle, _ = build_strike(chain, surface)
        record = EngineLaw().resolve(scene, state, obstacle)
        assert (record.obstacle, record.law, record.duration, record.time) == (
            "workpart",
            "engine",
            0.0,
            0.0,
        )
        assert record.outcome == ("rebound" if restitution else "no rebound")
        assert (record.angles, record.rates_before) == (state.angles, state.rates)
        before = (-math.sin(0.6), math.cos(0.6))
        assert record.velocity_before == pytest.approx(before, rel=1e-14)
        # Iterations solve the joint to rounding; the engine's bias of a step of 1e-12 is below it.
        assert record.velocity_after == pytest.approx(
            [-restitution * each for each in before], abs=1e-9
        )
        sine, cosine = math.sin(0.6), math.cos(0.6)
        moment = sine * record.impulse[0] - cosine * record.impulse[1]
        assert moment == pytest.approx((1.0 + restitution) / 3.0, rel=1e-9), (
            "angular momentum about the root"
        )
        if not friction:
            assert record.impulse == pytest.approx(
                ((1.0 + restitution) / (3.0 * sine), 0.0), rel=1e-9, abs=1e-12
            )
        assert (record.compressive_impulse, record.compressive_work, record.restitutive_work) == (
            None,
            None,
            None,
        )


@pytest.mark.parametrize("bend", [-1e-10, -1e-12, 0.0, 1e-12, 1e-10])
def test_an_error_of_the_directions_does_not_let_a_straight_chain_stick(bend: float) -> None:
    """Slip and approach of a straight chain end at p = -v_n/(K_nn - mu s K_nt), with s the sense of slip.

    Bent by an error, its slip may end first. The remaining approach would need an impulse of 1e9 N s or more.
    """
    chain = Chain((1.0, 1.0), (1.0, 1.0), (-0.5 + bend, -0.5), (1.0, 2.0))
    scene, state, pair, _ = build_strike(chain, Surface(0.6, None, 0.0))
    point = contact_at(scene.mechanism, state, pair)
    record = EnergeticLaw(1e-8).resolve(scene, state, pair)
    normal, slip = point.touch.velocity
    inverse, coupling = point.inverse_mass[0]
    expected = -normal / (inverse - 0.6 * math.copysign(coupling, slip * coupling))
    assert record.outcome == "no rebound"
    assert record.impulse == pytest.approx(
        (expected, -0.6 * math.copysign(expected, slip)), rel=1e-8, abs=0.0
    )


def test_a_wire_flies_after_an_impact_of_the_engine_as_before_it() -> None:
    """The engine would scale the impulses of the impact's step of 1e-12 to that of the flight, by 1e9."""
    scene, _ = build_tool(Tool(bristle=Bristle(links=4)))
    state = State(0.0, (-0.3, -0.4, -0.2, -0.5), (1.0, 2.0, 1.0, 3.0))
    tip = scene.mechanism.poses(state)[-1].corners[-1]
    step = 1e-3

    def flight() -> list[float]:
        scene.place(state, -0.5 * step)
        return scene.step(step, 4, symmetric=True)[:8]

    before = flight()
    EngineLaw().resolve(scene, state, WorkpartPair(-tip.imag, 0.3, 0.3, 0.5, link=3))
    assert flight() == pytest.approx(before, rel=1e-12)


@pytest.mark.parametrize("angle", [-0.6, 0.0, 1.2, -math.pi / 2.0])
@pytest.mark.parametrize("links", [1, 2, 4])
def test_a_contact_point_is_that_of_bodies_and_joints(angle: float, links: int) -> None:
    """The inverse mass in the links' rates equals that of bodies with eliminated joints, to its rounding; at -90 degrees
    the tip of one link moves along the normal alone, so that it moves in stick too."""
    angles = tuple([angle + 0.2 * number for number in reversed(range(links))])
    chain = Chain(
        (2.0, 1.0, 0.5, 1.5)[:links],
        (1.5, 1.0, 2.0, 1.0)[:links],
        angles,
        (-1.0,) * links,
        hub_radius=0.7,
        hub_speed=0.4,
        hub_angle=0.2,
    )
    scene, state, pair, _ = build_strike(chain, Surface())
    found = contact_at(scene.mechanism, state, pair)
    scene.place(state)
    tip = scene.mechanism.poses(state)[-1].corners[-1]
    exact = contact_space([scene.links[-1]], tip, found.touch.normal, joined([scene.links[-1]]))
    turned = [exact.bodies.index(body) for body in scene.links]
    assert found.touch.velocity == pytest.approx(exact.velocity, rel=1e-12, abs=1e-12)
    assert np.array(found.inverse_mass) == pytest.approx(exact.inverse_mass, rel=1e-11, abs=1e-12)
    assert found.stick_compliance == pytest.approx(exact.stick_compliance, rel=1e-11, abs=1e-12)
    response = exact.response[2::3][turned]
    slips = exact.inverse_mass[1, 1] > 1e-12
    following = exact.inverse_mass[0, 1] / exact.inverse_mass[1, 1] if slips else 0.0
    in_stick = response @ (1.0, -following) if exact.stick_compliance else np.zeros(links)
    assert np.transpose(found.response) == pytest.approx(response, rel=1e-11, abs=1e-12)
    assert np.array(found.in_stick) == pytest.approx(in_stick, rel=1e-11, abs=1e-12)


def test_a_straight_chain_that_lies_on_the_surface_moves_its_tip_along_the_normal_alone() -> None:
    """So every impulse acts as in stick: K_nn = 24/7 of two rods of mass and length 1, by Lagrange's equations.

    The masses are (4/3, 1/2; 1/2, 1/3), both levers of the normal 1. Those of the tangent are rounding of a cosine.
    """
    mechanism = Mechanism((Link.rod(1.0, 1.0),) * 2)
    state = State(0.0, (math.pi / 2.0,) * 2, (-1.0,) * 2)
    point = contact_at(mechanism, state, WorkpartPair(0.0, 0.3, 0.3, 0.5))
    assert point.inverse_mass == ((pytest.approx(24.0 / 7.0), 0.0), (0.0, 0.0))
    assert point.stick_compliance == pytest.approx(24.0 / 7.0)
