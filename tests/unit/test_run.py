"""Runs: starts, limits, scale in powers of two, and the advice of a law that gives up."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases.contact import between
from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool, Workpart
from bristle_sim.passes.ensemble import ensemble
from bristle_sim.scene.extrapolation import CLOSE
from bristle_sim.scene.impacts import EnergeticLaw
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.snapshots import snapshots
from bristle_sim.settings import Settings, StopReason

TOOL = Tool()
BARE = replace(TOOL, bar=None)


def with_bar_at(distance: float, radius: float, angle: float = 1.2, **surface: float) -> Tool:
    """A bar at a distance from the hub's centre, in a direction ``angle`` before the workpart, and a thin wire."""
    bar = Bar(
        radius=radius,
        horizontal=distance * math.sin(angle),
        vertical=distance * math.cos(angle),
        **surface,
    )
    return replace(TOOL, bar=bar, bristle=Bristle(wire_diameter=0.0, mass=8.387e-5))


class TestStarts:
    GAMMA = math.acos(50.0 / 54.5)

    def test_in_contact_and_approaching(self) -> None:
        run = simulate(
            BARE, start_hub_angle=-self.GAMMA, start_relative_rate=583.8, stop_after="strike"
        )
        assert run.event_time("strike") == 0.0
        assert run.contacts[0].rates_before[0] == pytest.approx(845.6, rel=1e-15)
        with pytest.raises(
            ValueError, match="must have samples of two different instants to be interpolated"
        ):
            run.at(0.0)

    def test_in_contact_and_parting(self) -> None:
        """The tip leaves the surface at once, so that no contact begins at the start."""
        run = simulate(
            BARE, start_hub_angle=-self.GAMMA, start_relative_rate=-583.8, stop_after="strike"
        )
        assert run.event_time("strike") == pytest.approx(1.32e-3, rel=1e-2)
        assert [contact.time for contact in run.contacts] == [run.event_time("strike")]

    def test_in_contact_and_at_rest(self) -> None:
        """Hub at rest, the belt pulls the tip onto the surface: it stays there, by k a = N L sin a."""
        tool = replace(BARE, hub=Hub(speed=0.0), workpart=Workpart(penetration=0.003, friction=0.0))
        angle = -math.acos(24.0 / 27.0)
        run = simulate(tool, start_hub_angle=0.0, start_relative_angle=angle)
        assert np.ptp(run.angles) < 1e-12
        force = tool.belt.stiffness * angle / (0.027 * math.sin(angle))
        # The engine's iterations leave rounding.
        assert run.normal_force[-1] == pytest.approx(force, rel=1e-9)

    @pytest.mark.parametrize(("start", "obstacle"), [(0.0, "workpart"), (-1.2, "bar")])
    def test_overlapping(self, start: float, obstacle: str) -> None:
        with pytest.raises(ValueError, match=f"the {obstacle} must be clear of the bristle"):
            simulate(TOOL, start_hub_angle=start)

    @pytest.mark.parametrize(
        ("tool", "start", "keys"),
        [
            (replace(between(-0.4, -0.7, gap=-2.7e-12), bar=None), (-0.4, -0.3), "penetration = "),
            (
                replace(between(-0.6, -1.0, bar_gap=-2.7e-12), workpart=None),
                (-0.6, -0.4),
                "bar_horizontal = .*, bar_vertical = ",
            ),
        ],
    )
    def test_overlapping_by_a_fraction_of_1e_10_of_the_length(
        self, tool: Tool, start: tuple[float, float], keys: str
    ) -> None:
        with pytest.raises(ValueError, match=rf"^{keys}.* overlaps it by 2\.7e-12 \(in m\)$"):
            simulate(tool, start_hub_angle=start[0], start_relative_angle=start[1])

    def test_at_rest_on_the_bar(self) -> None:
        """Hub at rest, the belt presses the wire on the bar at 0.8 of its length: k a = N 0.8 L."""
        tool = replace(between(-0.6, -1.0), workpart=None).replace(hub_speed=0.0)
        run = simulate(tool, start_hub_angle=-0.6, start_relative_angle=-0.4)
        assert np.ptp(run.angles) < 1e-12
        force = tool.belt.stiffness * 0.4 / (0.8 * tool.bristle.length)
        assert run.normal_force[-1] == pytest.approx(force, rel=1e-9)

    def test_on_the_very_centre_of_the_bar(self) -> None:
        """Where no direction is the normal's the gap is still minus the reach."""
        tool = replace(TOOL, bar=Bar(radius=0.005, horizontal=0.0, vertical=0.04), workpart=None)
        with pytest.raises(
            ValueError, match=r"the bar must be clear of the bristle .* overlaps it by 0\.00536"
        ):
            simulate(tool, start_hub_angle=0.0)

    def test_end_on_without_friction(self) -> None:
        """A hub without radius turns the wire's end onto a bar: nothing jams, and no force turns the bristle away."""
        bar = Bar(
            radius=0.005,
            horizontal=0.0,
            vertical=0.027 + 0.005 + 0.5 * TOOL.bristle.wire_diameter,
            friction=0.0,
        )
        tool = replace(TOOL, hub=Hub(speed=0.0, radius=0.0), bar=bar, workpart=None)
        run = simulate(tool, Settings(hub_turn=1.0), start_hub_angle=0.0)
        assert "jam" not in [each.name for each in run.events]
        assert run.stop_reason is StopReason.NO_GRIP

    def test_almost_end_on(self) -> None:
        """A slow hub, 19 rpm, turns the wire almost to the bar's normal: its force is large there, and ends as in the passes computed in arrays."""
        tool = replace(TOOL, hub=Hub(speed=2.0), belt=Belt(stiffness=0.1))
        run = simulate(tool, Settings(accuracy=1e-4), stop_after="bar release")
        assert run.stop_reason == "requested event"
        assert run.time[-1] == pytest.approx(float(ensemble(tool).release_time), rel=1e-6)


class TestLimits:
    def test_retraction_limit(self) -> None:
        """A belt a thousand times softer does not turn the bristle back from the bar."""
        run = simulate(replace(TOOL, belt=Belt(stiffness=TOOL.belt.stiffness * 1e-3)))
        assert run.stop_reason == "retraction limit"
        assert run.events[-2].name == "retraction limit"
        assert run.relative_angle[-1] == pytest.approx(-math.pi / 2.0, abs=1e-9)
        assert run.events[-1].name == "workpart not reached"

    def test_step_budget(self) -> None:
        run = simulate(TOOL, Settings(maximum_steps=1000))
        assert run.stop_reason == "step budget spent"
        assert run.cost.steps < 1500

    @pytest.mark.parametrize(
        ("tool", "budget"),
        [
            (replace(BARE, workpart=None), 1),
            (BARE.replace(contact="compliant", contact_duration=1e-3), 10),
        ],
    )
    def test_a_small_step_budget_is_exceeded_by_one_interval_at_most(
        self, tool: Tool, budget: int
    ) -> None:
        """In flight and in a contact resolved in time; an event is located by a hundred attempts at most."""
        run = simulate(tool, Settings(maximum_steps=budget), start_relative_angle=-0.5)
        assert run.stop_reason is StopReason.STEP_BUDGET
        assert 0 <= run.cost.steps - budget <= 100 * sum(CLOSE.counts)

    @pytest.mark.parametrize("accuracy", [0.1, 0.03])
    def test_a_coarse_pass_is_cheaper_than_one_of_the_usual_accuracy(self, accuracy: float) -> None:
        """The bar is touched and left at once, also where the attempted intervals are shortest."""
        coarse = simulate(TOOL, Settings(accuracy=accuracy), stop_after="strike")
        assert coarse.stop_reason == "requested event"
        assert coarse.cost.steps < simulate(TOOL, stop_after="strike").cost.steps

    def test_bar_friction_that_locks_ends_in_a_jam(self) -> None:
        run = simulate(replace(TOOL, bar=replace(TOOL.bar, friction=20.0)))
        assert run.stop_reason == "jam"

    @pytest.mark.parametrize("law", ["energetic", "compliant"])
    def test_a_wire_that_points_ahead_jams_on_a_rough_workpart(self, law: str) -> None:
        """Its tip leads the hub, which drives it into the surface: friction of 4 exceeds the cotangent of its slope."""
        rough = replace(BARE, workpart=Workpart(friction=4.0)).replace(contact=law)
        run = simulate(rough, start_hub_angle=0.0, start_relative_angle=0.9)
        assert run.stop_reason == "jam"
        assert [event.name for event in run.events] == ["strike", "jam"]
        assert [contact.outcome for contact in run.contacts] == ["jam"]

    @pytest.mark.parametrize("speed", [20.0, 261.8])
    def test_a_thick_wire_jams_where_the_friction_cone_points_at_its_root(
        self, speed: float
    ) -> None:
        """The lever of the normal over that of the tangent is mu = 1 there, at any speed.

        The scene counts 1e-3 of a free wire's compliance as none: with both levers near 9 mm, an inertia of
        m (15.6 mm)^2 and the contact 9 mm beside the centre, the ratio is larger by 0.4 %.
        """
        bar = Bar(radius=0.001, horizontal=0.038, vertical=0.0085, friction=1.0)
        bristle = replace(TOOL.bristle, mass=8.387e-5, wire_diameter=0.018)
        tool = replace(TOOL, hub=Hub(speed=speed), bar=bar, workpart=None, bristle=bristle)
        run = simulate(tool, start_hub_angle=-2.6)
        assert (run.stop_reason, run.event_time("jam")) == ("jam", run.time[-1])
        assert (run.contacts[-1].law, run.contacts[-1].outcome) == ("sustained", "jam")
        hub, wire = float(run.hub_angle[-1]), float(run.angles[-1, 0])
        to_bar = np.array(bar.centre) - tool.hub.radius * np.array([math.sin(hub), -math.cos(hub)])
        along = np.array([math.sin(wire), -math.cos(wire)])
        foot = (to_bar @ along) * along
        normal = (foot - to_bar) / np.linalg.norm(foot - to_bar)
        arm = foot - 0.5 * bristle.wire_diameter * normal
        levers = abs(arm[0] * normal[1] - arm[1] * normal[0]), abs(arm @ normal)
        assert levers[0] / levers[1] == pytest.approx(1.0, abs=5e-3)


def scaled(size: float, pace: float) -> Tool:
    """Lengths times s at the same mass, rates times p: belt torque times s^2 p^2, impulses times s p."""
    mass = float(TOOL.bristle.mass)
    return Tool(
        hub=Hub(speed=261.8 * pace, radius=0.0275 * size),
        belt=Belt(stiffness=TOOL.belt.stiffness * size**2 * pace**2),
        bristle=Bristle(length=0.027 * size, wire_diameter=7.1e-4 * size, mass=mass),
        bar=Bar(radius=TOOL.bar.radius * size, horizontal=0.05037 * size, vertical=0.0225 * size),
        workpart=Workpart(penetration=0.0045 * size),
    )


class TestScaleAndRepetition:
    @pytest.mark.parametrize(
        ("size", "pace"), [(2.0**-15, 1.0), (2.0**7, 1.0), (1.0, 2.0**-10), (1.0, 2.0**8)]
    )
    def test_powers_of_two_change_no_digit(self, size: float, pace: float) -> None:
        """They scale exactly in floating point, and the scene runs in its own units."""
        first, second = (simulate(tool, stop_after="strike") for tool in (TOOL, scaled(size, pace)))
        assert np.array_equal(first.angles, second.angles)
        assert np.array_equal(first.rates * pace, second.rates)
        assert np.array_equal(first.tip * size, second.tip)
        assert [each.time for each in first.events] == [each.time * pace for each in second.events]

    def test_a_contact_resolved_in_time_scales_too(self) -> None:
        tools = (TOOL.replace(contact="compliant"), scaled(2.0**-15, 2.0**8))
        first, second = (
            simulate(replace(tool, contact=tools[0].contact), stop_after="strike") for tool in tools
        )
        assert np.array_equal(first.angles, second.angles)
        assert np.array_equal(first.rates * 2.0**8, second.rates)


def test_a_swing_past_the_retraction_limit_and_back_within_one_interval_ends_there() -> None:
    """The bristle swings forward to 92 degrees from the radial direction; the limit is 90. At 3e-5 both ends of an interval are below it."""
    tool = TOOL.replace(
        hub_speed=97.6,
        belt_stiffness=0.00166,
        hub_radius=0.0228,
        knee_angle_deg=74.2,
        knee_position=0.758,
    )
    start = {"start_hub_angle": -1.72, "start_relative_rate": 510.0}
    coarse, fine = (simulate(tool, Settings(accuracy=each), **start) for each in (3e-5, 1e-8))
    assert coarse.stop_reason is fine.stop_reason is StopReason.RETRACTION_LIMIT
    assert coarse.time[-1] == pytest.approx(fine.time[-1], rel=3e-5)


def test_what_a_law_says_of_a_later_contact_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """The run up to a contact that a law cannot resolve is a result, with the law's advice."""
    resolve = EnergeticLaw.resolve
    calls = []

    def gives_up(*given: Any) -> Any:
        calls.append(given)
        if len(calls) > 2:
            raise ValueError("contact: duration must be longer")
        return resolve(*given)

    monkeypatch.setattr(EnergeticLaw, "resolve", gives_up)
    run = simulate(with_bar_at(0.04, 0.003, restitution=0.7))
    assert (run.stop_reason, len(run.contacts)) == (StopReason.UNRESOLVED, 2)
    assert run.stop_advice == "contact: duration must be longer"


def test_a_hop_on_the_bar_is_one_interval() -> None:
    """At 1e-3 the hop, from 1.2787 to 1.3422 ms, is shorter than a tenth of the longest interval; near its start the polynomial is accurate enough to show that the gap opens."""
    run = snapshots(Tool(), Settings(accuracy=1e-3), stop_after="strike")
    assert not [each.time for each in run if 1.279e-3 < each.time < 1.342e-3]
