"""What happens in a run and when: touches by a hair, at any speed and step, starts, limits, chatter, scale, repetition.

A straight bristle without gravity stays radial until it touches something, so the instant of the first touch is plain
geometry: the radial line meets the bar's circle, or the tip's circle meets bar or workpart.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bristle_sim.parameters import Bar, Belt, Bristle, Hub, Tool, Workpart
from bristle_sim.scene.contact.laws import EnergeticLaw
from bristle_sim.scene.simulate import simulate, simulate_in_steps
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.trajectory import Trajectory

TOOL = Tool()
TIP = 0.0275 + 0.027
"""Radius of a radial bristle's tip, m."""

BARE = replace(TOOL, bar=None)


def with_hub_speed(tool: Tool, speed: float) -> Tool:
    return replace(tool, hub=replace(tool.hub, speed=speed))


def with_bar_at(distance: float, radius: float, angle: float = 1.2, **surface: float) -> Tool:
    """A bar at a distance from the hub's centre, in a direction ``angle`` before the workpart, and a thin wire."""
    bar = Bar(radius=radius, horizontal=distance * math.sin(angle), vertical=distance * math.cos(angle), **surface)
    return replace(TOOL, bar=bar, bristle=replace(TOOL.bristle, wire_diameter=0.0))


def first_bar_touch(tool: Tool) -> float:
    """Time at which a radial bristle meets the bar: its end on the reach (law of cosines) or its flank (tangent)."""
    assert tool.bar is not None
    distance, reach = math.hypot(tool.bar.horizontal, tool.bar.vertical), tool.bar_reach
    if distance * distance - reach * reach > TIP * TIP:
        between = math.acos((distance**2 + TIP**2 - reach**2) / (2.0 * distance * TIP))
    else:
        between = math.asin(reach / distance)
    return (math.pi / 2.0 - math.atan2(tool.bar.horizontal, tool.bar.vertical) - between) / tool.hub.speed


def least_gap(tool: Tool, run: Trajectory) -> float:
    """Least distance of the centre line from bar and workpart over all samples, m."""
    hub, wire = (np.stack([np.sin(angle), -np.cos(angle)], axis=1) for angle in (run.hub_angle, run.angles[:, 0]))
    gaps = []
    if tool.bar is not None:
        to_bar = np.array(tool.bar.centre) - tool.hub.radius * hub
        along = np.clip((to_bar * wire).sum(axis=1), 0.0, tool.bristle.length)
        gaps.append(np.linalg.norm(to_bar - along[:, None] * wire, axis=1).min() - tool.bar_reach)
    if tool.workpart is not None:
        gaps.append(run.tip[:, 1].min() + tool.workpart_depth)
    return float(min(gaps))


ACCURACY = Settings().accuracy
"""Requested by default: events of a run are good to it, relative to the run's time."""

INSIDE = -ACCURACY * 0.027
"""So is what is touched, relative to the bristle's length."""


class TestByAHair:
    @pytest.mark.parametrize("hair", [1e-6, 1e-8])
    @pytest.mark.parametrize("radius", [1e-3, 1e-5])
    def test_bar_grazed_and_missed(self, radius: float, hair: float) -> None:
        """A bar that the tip's circle overlaps by a hair is touched at the instant of geometry; off by a hair, never.

        The radial bristle has no error to speak of, and where the circles meet at grazing incidence it is magnified by
        up to 1e3.
        """
        grazed = with_bar_at(TIP + radius - hair, radius)
        found = simulate(grazed, stop_after="bar touch").event_time("bar touch")
        assert found == pytest.approx(first_bar_touch(grazed), rel=ACCURACY)
        missed = simulate(replace(with_bar_at(TIP + radius + hair, radius), workpart=None))
        assert [each.name for each in missed.events] == ["bar not touched"]
        assert missed.contacts == ()

    @pytest.mark.parametrize("hair", [1e-6, 1e-9])
    def test_workpart_grazed_and_missed(self, hair: float) -> None:
        grazed = replace(BARE, workpart=Workpart(penetration=hair))
        expected = (math.pi / 2.0 - math.acos(1.0 - hair / TIP)) / 261.8
        # Rounding of the tip's height is magnified by sqrt(TIP/hair), 7e3 for a nanometre.
        assert simulate(grazed, stop_after="strike").event_time("strike") == pytest.approx(expected, rel=ACCURACY)
        missed = simulate(replace(BARE, workpart=Workpart(penetration=-hair)))
        assert [each.name for each in missed.events] == ["workpart not reached"]
        assert least_gap(BARE, missed) > -0.0046


class TestFastAndThin:
    def test_too_long_a_plain_step_is_refused(self) -> None:
        with pytest.raises(ValueError, match=r"step = 0\.01: must be at most "):
            simulate_in_steps(TOOL, 0.01)


class TestStarts:
    GAMMA = math.acos(50.0 / 54.5)

    def test_in_contact_and_approaching(self) -> None:
        run = simulate(BARE, start_hub_angle=-self.GAMMA, start_relative_rate=583.8, stop_after="strike")
        assert run.event_time("strike") == 0.0
        assert run.contacts[0].rates_before[0] == pytest.approx(845.6, rel=1e-15)
        with pytest.raises(ValueError, match="must have samples of two different instants to be interpolated"):
            run.at(0.0)

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

    def test_on_the_very_centre_of_the_bar(self) -> None:
        """Where no direction is the normal's the gap is still minus the reach."""
        tool = replace(TOOL, bar=Bar(radius=0.005, horizontal=0.0, vertical=0.04), workpart=None)
        with pytest.raises(ValueError, match=r"the bar must be clear of the bristle .* overlaps it by 0\.00536"):
            simulate(tool, start_hub_angle=0.0)

    def test_end_on_without_friction(self) -> None:
        """A hub without radius turns the wire's end onto a bar: nothing jams, and no force turns the bristle away."""
        bar = Bar(radius=0.005, horizontal=0.0, vertical=0.027 + 0.005 + 0.5 * TOOL.bristle.wire_diameter, friction=0.0)
        tool = replace(TOOL, hub=Hub(speed=0.0, radius=0.0), bar=bar, workpart=None)
        run = simulate(tool, Settings(hub_turn=1.0), start_hub_angle=0.0)
        assert "jam" not in [each.name for each in run.events]

    @pytest.mark.parametrize(
        "start",
        [
            {"start_relative_rate": math.nan},
            {"start_hub_angle": math.inf},
            {"start_relative_angle": 1.6},
            {"start_relative_rate": -1e10},
            {"stop_after": "strik"},
        ],
    )
    def test_bad_values_are_refused_in_one_line(self, start: dict[str, float]) -> None:
        with pytest.raises(ValueError, match=f"^{next(iter(start))} = [^\n]* must be[^\n]*$"):
            simulate(BARE, **start)


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

    def test_bar_friction_that_locks_ends_in_a_jam(self) -> None:
        run = simulate(replace(TOOL, bar=replace(TOOL.bar, friction=20.0)))
        assert run.stop_reason == "jam"
        assert_sound(run)


def assert_sound(run: Trajectory) -> None:
    """Finite numbers, time that does not go back, events within the run, a reason for stopping."""
    for each in ("time", "angles", "rates", "tip", "kinetic_energy", "potential_energy", "normal_force"):
        assert np.isfinite(getattr(run, each)).all(), each
    assert np.diff(run.time).min() >= 0.0
    assert all(0.0 <= each.time <= run.time[-1] * (1.0 + 1e-12) for each in run.events)
    assert run.normal_force.min() >= 0.0
    assert run.stop_reason


class TestChatter:
    @pytest.mark.parametrize("restitution", [0.5, 0.9, 0.99])
    def test_bar(self, restitution: float) -> None:
        """A stiff, damped belt presses the wire on: taps come ever faster, add up in finite time, and the wire slides.

        Each tap leaves e of the normal velocity, down to 1e-8 of it at least: no more than ln 1e-8/ln e taps, doubled
        for what the belt's swing adds in between.
        """
        belt = Belt(stiffness=100.0 * TOOL.belt.stiffness, damping_ratio=0.3)
        tool = replace(TOOL, belt=belt, bar=replace(TOOL.bar, restitution=restitution), workpart=None)
        run = simulate(tool)
        taps = [each for each in run.contacts if each.law == "energetic"]
        assert_sound(run)
        assert 3 < len(taps) < 2.0 * math.log(1e-8) / math.log(restitution)
        assert any(each.law == "sustained" for each in run.contacts)
        assert least_gap(tool, run) > INSIDE


def scaled(size: float, pace: float) -> Tool:
    """Lengths times s at the same mass, rates times p: belt torque times s^2 p^2, impulses times s p."""
    return Tool(
        hub=Hub(speed=261.8 * pace, radius=0.0275 * size),
        belt=Belt(stiffness=TOOL.belt.stiffness * size**2 * pace**2),
        bristle=Bristle(length=0.027 * size, wire_diameter=7.1e-4 * size),
        bar=Bar(radius=TOOL.bar.radius * size, horizontal=0.05037 * size, vertical=0.0225 * size),
        workpart=Workpart(penetration=0.0045 * size),
    )


class TestScaleAndRepetition:
    @pytest.mark.parametrize(("size", "pace"), [(1e-6 / 0.027, 1.0), (10.0 / 0.027, 1.0), (1.0, 1e-3), (1.0, 300.0)])
    def test_similar_tools_move_alike(self, size: float, pace: float) -> None:
        """Bristles of a micrometre and of ten metres, slow and fast; 1e-9 is ten times the requested accuracy.

        That the wire's end grazes the bar when it is released magnifies it by 1e3 for that instant, and so does the hop before
        it is held: 4e-6 of the wire's length high, it ends at a ten-thousandth of the tip's speed.
        """
        first, second = (
            simulate(tool, Settings(accuracy=1e-10), stop_after="strike") for tool in (TOOL, scaled(size, pace))
        )
        assert [each.name for each in first.events] == [each.name for each in second.events]
        for number, (a, b) in enumerate(zip(first.events, second.events, strict=True)):
            grazes = number > 0 and a.name.startswith("bar ")
            assert b.time * pace == pytest.approx(a.time, rel=1e-6 if grazes else 1e-9)
        one, other = (run.first_contact("workpart") for run in (first, second))
        assert one is not None
        assert other is not None
        assert other.angles == pytest.approx(one.angles, rel=1e-9)
        assert other.rates_before[0] / pace == pytest.approx(one.rates_before[0], rel=1e-9)
        assert other.rates_after[0] / pace == pytest.approx(one.rates_after[0], rel=1e-9)
        # Tangential impulse is a difference of two phases, a thirtieth of the normal one.
        expected = [each * size * pace for each in one.impulse]
        assert other.impulse == pytest.approx(expected, rel=1e-9, abs=1e-9 * expected[0])

    @pytest.mark.parametrize(("size", "pace"), [(2.0**-15, 1.0), (2.0**9, 1.0), (1.0, 2.0**-10), (1.0, 2.0**8)])
    def test_powers_of_two_change_no_digit(self, size: float, pace: float) -> None:
        """They scale exactly in floating point, and the scene runs in its own units."""
        first, second = (simulate(tool, stop_after="strike") for tool in (TOOL, scaled(size, pace)))
        assert np.array_equal(first.angles, second.angles)
        assert np.array_equal(first.rates * pace, second.rates)
        assert np.array_equal(first.tip * size, second.tip)
        assert [each.time for each in first.events] == [each.time * pace for each in second.events]


def test_what_a_law_says_of_a_later_contact_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """The run up to a contact that a law cannot resolve is a result, with the law's advice."""
    resolve, calls = EnergeticLaw.resolve, []

    def gives_up(*given: Any) -> Any:
        calls.append(given)
        if len(calls) > 2:
            raise ValueError("contact: duration must be longer")
        return resolve(*given)

    monkeypatch.setattr(EnergeticLaw, "resolve", gives_up)
    run = simulate(with_bar_at(0.04, 0.003, restitution=0.7))
    assert (run.stop_reason, len(run.contacts)) == (StopReason.UNRESOLVED, 2)
    assert run.stop_advice == "contact: duration must be longer"
