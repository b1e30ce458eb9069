"""How many iterations of the engine's solver are enough: by hand for one link, by the engine itself for several."""

import math

import pytest

from bristle_sim.scene.build import Effects, Scene
from bristle_sim.scene.gaps import Gaps
from bristle_sim.scene.mechanism import Link, Mechanism, State
from bristle_sim.scene.obstacles import WorkpartObstacle
from bristle_sim.scene.solver_rounds import contact_rounds


@pytest.mark.parametrize("angle", [0.5, 0.9, 1.3])
def test_one_rod_on_the_workpart(angle: float) -> None:
    """Each iteration leaves 1 - 3 s^2/(1 + 3 s^2) of the error, s = sin(angle): the grip of a rod's end; down to 1e-17."""
    rod = Mechanism((Link.rod(2.0, 1.0),))
    obstacle = WorkpartObstacle(math.cos(angle), 0.0, 0.0, 0.0)
    state = State(0.0, (angle,), (0.0,))
    gaps = Gaps(rod)
    left = 1.0 / (1.0 + 3.0 * math.sin(angle) ** 2)
    rounds, solvable = contact_rounds(rod, gaps.poses(state), [obstacle], [gaps.touch(obstacle, state)], [None])
    assert solvable
    assert rounds == 2 + math.ceil(math.log(1e-17) / math.log(left))


@pytest.mark.parametrize("slip", [0, 1])
def test_chain_on_the_workpart(slip: int) -> None:
    """More iterations change the impulse by rounding only, a quarter of them leave more."""
    chain = Mechanism(tuple(Link.rod(1.0, 1.0) for _ in range(4)))
    angles, rates = (0.2, 0.5, 0.9, 0.4), (-0.1, 0.0, -0.3, -0.5)
    height = -chain.poses(State(0.0, angles, rates))[-1].tip[1]
    obstacle = WorkpartObstacle(height, 0.3, 0.3, 0.0, link=3)
    state = State(0.0, angles, rates)
    gaps = Gaps(chain)
    touch = gaps.touch(obstacle, state)
    rounds, solvable = contact_rounds(chain, gaps.poses(state), [obstacle], [touch], [slip])
    assert solvable

    def impulse(iterations: int) -> float:
        fresh = Scene(chain, Effects(obstacles=(obstacle,)))
        fresh.place(state)
        fresh.contacts.engage(obstacle, friction=0.3, elasticity=0.0, iterations=iterations)
        fresh.contacts.direct_friction(obstacle, slip, touch.tangent)
        fresh.step(1e-9, 1)
        return fresh.contacts.totals(obstacle)[0]

    enough = impulse(10 * rounds)
    assert impulse(rounds) == pytest.approx(enough, rel=1e-12)
    assert impulse(rounds // 4) != pytest.approx(enough, rel=1e-9)
