"""Wires of several links beyond their strikes, in several contacts at once: the scene against the independent solution.

The tolerance is ten times the requested accuracy, of angles in rad and of instants; the end of a whole pass with its
rebounds gets ten times that.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from against_reference.test_tools import wire
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, ContactStiffness, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import Trajectory

ACCURACY = 1e-6

MANY = Settings(accuracy=ACCURACY, maximum_steps=5_000_000)


def times(run: Trajectory, ending: str) -> list[float]:
    return [each.time for each in run.events if each.name.endswith(ending) or each.name == "strike"]


def test_two_links_on_the_bar_at_once() -> None:
    """A limp wire wraps around a bar in the middle of it: neighbouring links are in contact at a time."""
    tool = wire(4, modulus=8.5e7, nearness=0.7528, friction=0.3)
    assert tool.bar is not None
    tool = replace(tool, bar=replace(tool.bar, radius=0.005557), workpart=None)
    scene = simulate(tool, replace(MANY, hub_turn=1.2))
    reference = simulate_reference(tool, hub_turn=1.2, accuracy=1e-8)
    for run in (scene, reference):
        lasting = [each for each in run.contacts if each.law == "sustained"]
        assert any(a.time < b.time < a.time + a.duration for a in lasting for b in lasting)
    assert scene.angles[-1] == pytest.approx(reference.angles[-1], abs=10.0 * ACCURACY)
    blows = [
        [each for each in run.contacts if each.impulse[0] > 1e-5 and not each.duration] for run in (scene, reference)
    ]
    assert [each.time for each in blows[0]] == pytest.approx([each.time for each in blows[1]], rel=10.0 * ACCURACY)
    assert [each.impulse[0] for each in blows[0]] == pytest.approx([each.impulse[0] for each in blows[1]], rel=1e-4)


@pytest.mark.nightly
def test_bar_and_workpart_at_once() -> None:
    """A bar low over the workpart: it meets the wire's last link while the tip drags along the surface."""
    tool = wire(3, modulus=3.1996e10, damping=0.3)
    bar = Bar(radius=0.00272879, horizontal=0.00957196, vertical=0.045664, friction=0.2)
    tool = replace(tool, bar=bar, workpart=Workpart(penetration=0.00277574, friction=0.0, restitution=0.0))
    scene = simulate(tool, replace(MANY, hub_turn=1.9))
    reference = simulate_reference(tool, hub_turn=1.9, accuracy=1e-8)
    for run in (scene, reference):
        lasting = [each for each in run.contacts if each.law == "sustained"]
        assert any(a.time < b.time < a.time + a.duration and a.obstacle != b.obstacle for a in lasting for b in lasting)
    assert scene.angles[-1] == pytest.approx(reference.angles[-1], abs=10.0 * ACCURACY)
    first, second = (times(run, " touch") for run in (scene, reference))
    assert first[:5] == pytest.approx(second[:5], rel=10.0 * ACCURACY)


def test_tip_that_sticks() -> None:
    """An inelastic strike with friction stops the tip of a straight wire, where stick and the root's pivot repeat each other."""
    tool = wire(3, modulus=3.2e10, damping=0.3)
    bar = Bar(radius=0.0015, horizontal=0.0096, vertical=0.0465, friction=0.2)
    tool = replace(tool, bar=bar, workpart=Workpart(penetration=0.0035, friction=0.2, restitution=0.0))
    scene = simulate(tool, replace(MANY, hub_turn=1.9))
    reference = simulate_reference(tool, hub_turn=1.9, accuracy=1e-8)
    assert scene.stop_reason == reference.stop_reason == "end of the planned time"
    assert scene.angles[-1] == pytest.approx(reference.angles[-1], abs=10.0 * ACCURACY)
    dragged = [next(each for each in run.contacts if each.law == "sustained") for run in (scene, reference)]
    assert dragged[0].impulse == pytest.approx(dragged[1].impulse, rel=10.0 * ACCURACY)


@pytest.mark.nightly
def test_stick_that_breaks_away() -> None:
    """After the inelastic strike the tip sticks while the wire bends, until that takes more than friction gives."""
    tool = replace(wire(3, damping=0.3, friction=0.2, restitution=0.42), belt=Belt())
    tool = replace(tool, workpart=Workpart(friction=0.8, restitution=0.0))
    scene = simulate(tool, replace(MANY, hub_turn=3.0))
    reference = simulate_reference(tool, hub_turn=3.0, accuracy=1e-8)
    touches = [[each.time for each in run.events if each.name == "workpart touch"] for run in (scene, reference)]
    assert touches[0] == pytest.approx(touches[1], rel=10.0 * ACCURACY)
    assert scene.angles[-1] == pytest.approx(reference.angles[-1], abs=10.0 * ACCURACY)


def test_whole_pass_of_two_links() -> None:
    """Strike, ever smaller rebounds, drag along the workpart with friction, release and swing."""
    tool = wire(2, damping=0.05)
    scene, reference = simulate(tool, MANY), simulate_reference(tool, accuracy=1e-8)
    touches = [times(run, " touch") for run in (scene, reference)]
    assert touches[0][:8] == pytest.approx(touches[1][:8], rel=10.0 * ACCURACY)
    assert scene.angles[-1] == pytest.approx(reference.angles[-1], abs=100.0 * ACCURACY)
    assert scene.total_energy[-1] == pytest.approx(reference.total_energy[-1], rel=1e3 * ACCURACY)


def test_touches_of_a_compliant_workpart() -> None:
    """Strikes, the later ones in the dent of the first, at the stiffness of the rigid bristle's first strike.

    A contact returns e*^2 of the work it took, whatever the bodies do.
    """
    duration = 7.1e-5
    tool = replace(wire(3, modulus=5e10, damping=0.1), contact=Contact("compliant", duration))
    scene = simulate(tool, replace(MANY, hub_turn=1.27))
    first = scene.first_contact("workpart")
    assert first is not None
    assert tool.workpart is not None
    tip = scene.tip[int(np.abs(scene.time - first.time).argmin())]
    lever = tip[0] - tool.hub.radius * math.sin(tool.hub.speed * first.time - 0.5 * math.pi)
    inverse_mass = lever**2 / tool.bristle.inertia_about_root
    stiffness = ContactStiffness(duration).stiffness(inverse_mass, tool.workpart.restitution)
    reference = simulate_reference(tool, hub_turn=1.27, accuracy=1e-8, contact_stiffness=stiffness)
    found, expected = ([c for c in run.contacts if c.obstacle == "workpart"][:3] for run in (scene, reference))
    assert [each.time for each in found] == pytest.approx([each.time for each in expected], rel=10.0 * ACCURACY)
    assert [each.impulse[0] for each in found] == pytest.approx([each.impulse[0] for each in expected], rel=1e-6)
    for each in (*found, *expected):
        assert each.compressive_work is not None
        assert each.restitutive_work is not None
        assert each.restitutive_work[0] == pytest.approx(-(0.42**2) * each.compressive_work[0], rel=1e-5)


class TestDent:
    """A contact resolved in time may end inside the workpart; the tip stays there until it comes out by itself."""

    @pytest.mark.parametrize(("knee", "friction"), [(0.0, 0.31), (30.0, 0.5), (-30.0, 0.5)])
    def test_no_jump(self, knee: float, friction: float) -> None:
        """Between two samples the tip moves no further than its largest speed takes it, but for curvature."""
        bristle = Bristle(knee_angle_deg=knee)
        contact = Tool().contact.__class__(law="compliant", duration=1e-4)
        run = simulate(Tool(bristle=bristle, workpart=Workpart(friction=friction), contact=contact))
        depth = run.tool.workpart_depth
        assert run.tip[:, 1].min() < -depth - 1e-4
        way, time = np.linalg.norm(np.diff(run.tip, axis=0), axis=1), np.diff(run.time)
        speed = np.linalg.norm(run.tip_velocity, axis=1)
        # An interval of sustained contact turns a belt's radian at most: the speed between its ends is less than twice theirs.
        assert (way <= 2.0 * np.maximum(speed[1:], speed[:-1]) * time + 1e-12 * math.hypot(*run.tip[0])).all()

    def test_out_of_the_dent_the_surface_counts_again(self) -> None:
        """After the tip has risen above the surface, its next touch is at the surface."""
        contact = Tool().contact.__class__(law="compliant", duration=1e-4)
        run = simulate(Tool(contact=contact))
        first, second = [each for each in run.contacts if each.obstacle == "workpart"][:2]
        left = run.time > first.time + first.duration
        height = run.tip[:, 1] + run.tool.workpart_depth
        assert height[left].max() > 0.0
        at_touch = int(np.flatnonzero(run.time >= second.time)[0])
        assert height[at_touch] == pytest.approx(0.0, abs=1e-11)
