"""A bristle thrown by its own inertia: energy, quadrature, and the scene and the reference beside them."""

import dataclasses
import math

import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.inertia_driven import _answer, inertia_driven
from bristle_sim.theory.inertia_drive import largest_retraction, time_to_radial

INERTIA = 8.387e-5 * 0.027**2 / 3.0
STIFFNESS = math.degrees(0.00041)
SPEED = 261.8
FIELD = 8.387e-5 * 0.0275 * 0.0135 * SPEED**2
FINE = Settings(accuracy=1e-9)


def values(tool=None, *, side="simulated", **options):
    found = inertia_driven(tool or Tool(), FINE, **options)
    return {each.name: getattr(each, side) for each in found.quantities}, found


def integrated(damping=0.0):
    """The equation of motion by scipy until the bristle is radial again: time, rate and largest lag."""

    def slope(_, state):
        angle, rate = state
        return rate, -(damping * rate + STIFFNESS * angle + FIELD * math.sin(angle)) / INERTIA

    def radial(_, state):
        return state[0]

    def turning(_, state):
        return state[1]

    radial.terminal = True
    radial.direction = 1.0
    run = solve_ivp(
        slope,
        (0.0, 0.1),
        (0.0, -SPEED),
        method="DOP853",
        rtol=1e-13,
        atol=1e-16,
        events=(radial, turning),
    )
    return run.t_events[0][-1], run.y_events[0][-1][1], -run.y_events[1][0][0]


def test_the_field_alone_is_a_pendulum():
    """sin(A/2) = omega/2 sqrt(I/g), half a period 2 sqrt(I/g) K(sin(A/2)^2)."""
    modulus = 0.5 * SPEED * math.sqrt(INERTIA / FIELD)
    assert largest_retraction(INERTIA, 0.0, FIELD, SPEED) == pytest.approx(
        2.0 * math.asin(modulus), rel=1e-14
    )
    half = 2.0 * math.sqrt(INERTIA / FIELD) * ellipk(modulus**2)
    assert time_to_radial(INERTIA, 0.0, FIELD, SPEED) == pytest.approx(half, rel=1e-13)


def test_a_bristle_that_would_lie_down_is_refused():
    limit = math.sqrt(STIFFNESS / INERTIA) * math.pi / 2.0
    assert largest_retraction(INERTIA, STIFFNESS, 0.0, 0.999 * limit) == pytest.approx(
        0.999 * math.pi / 2.0
    )
    with pytest.raises(
        ValueError, match=r"^stiffness = .*: must be enough to stop the bristle within 90 deg"
    ):
        largest_retraction(INERTIA, STIFFNESS, 0.0, 1.001 * limit)


@pytest.mark.parametrize("ratio", [0.0, 0.05])
def test_scene_theory_and_reference_agree_with_an_integration(ratio):
    tool = Tool(belt=Belt(stiffness=STIFFNESS, damping_ratio=ratio))
    simulated, found = values(tool)
    assert [each.ok for each in found.quantities] == [True] * 5
    time, rate, lag = integrated(tool.belt_damping)
    expected = {
        "time_to_radial": time,
        "relative_speed_at_radial": rate,
        "largest_retraction_deg": math.degrees(lag),
    }
    for each in found.quantities[:4]:
        # Requested: 1e-9; promised: 1e-8 of either. Theory, for an undamped belt, is good to rounding.
        assert each.simulated == pytest.approx(each.reference, rel=1e-8)
        assert each.simulated == pytest.approx(expected.get(each.name, each.simulated), rel=1e-8)
        assert (each.theory is None) is (ratio > 0.0)
        assert ratio > 0.0 or each.theory == pytest.approx(
            expected.get(each.name, each.theory), rel=1e-10
        )
    if ratio == 0.0:
        assert simulated["hub_speed_for_equal_tip_speed"] == pytest.approx(465.6, abs=0.1)
        assert found.answer == (
            "Without a bar the tip reaches 21.3 m/s after 2.8 ms, 56 % of the 37.9 m/s with a bar; to reach that speed the"
            " pulley must turn at 4446 rpm (465.6 rad/s)."
        )


def test_the_tip_of_a_bent_bristle_is_where_its_knee_puts_it():
    """Three quarters of the length, then a quarter at 30 deg: its end turns about the root at 2 omega, as a straight one does."""
    found = inertia_driven(Tool(bristle=Bristle(knee_angle_deg=30.0)), FINE, with_reference=False)
    tip = 0.027 * complex(0.75 + 0.25 * math.cos(math.pi / 6.0), 0.25 * math.sin(math.pi / 6.0))
    speed = next(each for each in found.quantities if each.name == "tip_speed_at_radial")
    assert speed.simulated == pytest.approx(SPEED * abs(0.0275 + 2.0 * tip), rel=1e-8)
    assert speed.ok


def test_an_overdamped_bristle_creeps_and_a_fast_one_lies_down():
    for tool in (
        Tool(belt=Belt(stiffness=STIFFNESS, damping_ratio=1.5)),
        Tool(
            hub=Hub(radius=0.001, speed=3000.0),
            bristle=Bristle(),
            bar=Bar(horizontal=0.05, vertical=0.0),
        ),
    ):
        simulated, found = values(tool, with_reference=False)
        assert set(simulated.values()) == {None}
        assert found.answer.startswith("The bristle does not come back to the radial direction")


def test_without_a_strike_there_is_nothing_to_equal():
    workpart = dataclasses.replace(Tool().workpart, penetration=1e-6)
    simulated, found = values(Tool(workpart=workpart), with_reference=False)
    assert simulated["hub_speed_for_equal_tip_speed"] is None
    assert "with the bar there is no strike to compare with (" in found.answer
    assert "at no pulley speed is it as fast" in _answer(simulated, 1e3, "")
