"""The engine's acceleration at a state is that of the equation of motion."""

import math

import pytest

from bristle_sim.parameters import Belt, Hub, Tool
from bristle_sim.scene.build import Scene
from bristle_sim.scene.integrate.time_scales import acceleration
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.tool import build_tool


def by_equation(scene: Scene, state: State) -> float:
    """alpha'' = -(k alpha + c alpha' + m r_h l Omega^2 sin alpha + m g l sin phi)/I, phi from the vertical."""
    mechanism, effects, link = scene.mechanism, scene.effects, scene.mechanism.links[0]
    angle, rate = state.angles[0] - mechanism.hub_angle(state.time), state.rates[0] - mechanism.hub_speed
    lever = link.mass * math.hypot(*link.centre)
    field = mechanism.hub_radius * mechanism.hub_speed**2 * math.sin(angle)
    moment = effects.stiffness * angle + effects.damping * rate + lever * field
    return -(moment + lever * effects.gravity * math.sin(state.angles[0])) / link.inertia_about_joint


@pytest.mark.parametrize("ratio", [0.0, 0.1, 1.0, 10.0, 100.0])
@pytest.mark.parametrize("swing", [0.7, 1e-5])
@pytest.mark.parametrize("gravity", [0.0, 2e3])
def test_equation_of_motion(ratio: float, swing: float, gravity: float) -> None:
    """1e-10 for rounding of rates of 1 over steps of 0.04 times the weights' 200, and times the damping's rate of 8 ratio."""
    tool = Tool(bar=None, workpart=None, belt=Belt(damping_ratio=ratio), gravity=gravity)
    scene, _ = build_tool(tool, hub_start=0.3)
    state = State(0.0, (0.3 - 0.3 * swing,), (scene.mechanism.hub_speed + 0.8 * swing / max(1.0, ratio),))
    assert acceleration(scene, state) == pytest.approx(by_equation(scene, state), abs=1e-10 * max(1.0, 8.0 * ratio))


def test_a_later_turn_of_the_hub() -> None:
    """A hundred turns later the angle is rounded a hundred times as much, which its spring turns into a moment."""
    scene, units = build_tool(Tool(bar=None, workpart=None, hub=Hub(speed=400.0)), hub_start=0.0)
    time = 200.0 * math.pi / (400.0 * units.time)
    state = State(time, (scene.mechanism.hub_angle(time) - 0.4,), (scene.mechanism.hub_speed,))
    assert acceleration(scene, state) == pytest.approx(by_equation(scene, state), abs=1e-10)
