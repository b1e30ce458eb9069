"""Impacts that hardly are any, and that the promises notice a program that takes them for what they are not."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases import grazing, tip_paths
from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.grazing import cases
from bristle_sim.benchmarks.hard_cases.tip_paths import bar_at, gap_of_circle, lowest_place, swinging
from bristle_sim.parameters import Bar, Bristle, Contact, Hub, Surface, Tool, Workpart
from bristle_sim.scene import contact_laws
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.theory.impact import Impact, energetic_impact
from bristle_sim.theory.monofilament import LEAST_ANGLE as SMALLEST
from bristle_sim.theory.monofilament import monofilament_impact, normal_final_impulse
from bristle_sim.trajectory import Trajectory


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def named(name: str) -> HardCase:
    (found,) = (case for case in cases(full=False) if case.name == name)
    return found


@pytest.mark.parametrize("full", [False, True])
def test_every_case_has_its_own_name(full: bool) -> None:
    names = [case.name for case in cases(full)]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("depth", [0.01, 1e-4, -1e-3])
def test_bar_stands_where_the_circle_dips_into_it(depth: float) -> None:
    """Least distance of points of the tip's circle from the bar's face, on the line of centres."""
    tool = bar_at(depth)
    assert tool.bar is not None
    towards = math.atan2(tool.bar.vertical, tool.bar.horizontal)
    times = (towards + np.linspace(-0.1, 0.1, 2001)) / tool.hub.speed
    gaps = [gap_of_circle(tool)(time) / tip_paths.LENGTH for time in times]
    # Rounding of places of two lengths.
    assert min(gaps) == pytest.approx(-depth, abs=1e-14)
    assert gaps.index(min(gaps)) == 1000


def test_lowest_place_of_a_bristle_that_does_not_swing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Radial, its tip runs on the circle of radius r_h + L."""
    monkeypatch.setattr(tip_paths, "LEAN", 0.0)
    # The fifth power of a thousandth, and rounding of the samples.
    assert lowest_place() == pytest.approx(tip_paths.REACH, rel=1e-14)


def test_lowest_place_of_a_bristle_that_swings() -> None:
    """The program's own samples come no lower, and nearly as low: they lie up to 1/24 of a period apart."""
    run = simulate(dataclasses.replace(Tool(), bar=None, workpart=None), start_relative_angle=tip_paths.LEAN)
    sampled, lowest = -float(run.tip[:, 1].min()), lowest_place()
    # The run's accuracy.
    assert sampled <= lowest + 1e-6 * tip_paths.LENGTH
    # A sample is at most 1/48 of a period off; the tip's path is curved by R omega^2 plus the swing's own acceleration.
    period = 2.0 * math.pi / 1120.0
    assert lowest - sampled <= 0.5 * (tip_paths.REACH * 261.8**2 + 0.4 * 0.027 * 1120.0**2) * (period / 48.0) ** 2


@pytest.mark.parametrize("seed", range(8))
def test_any_circle_and_any_depth(seed: int) -> None:
    """Tools of other numbers; the instant from the triangle of hub, bar and tip."""
    rng = np.random.default_rng(seed)
    bristle, hub = Bristle(length=rng.uniform(0.01, 1.0), wire_diameter=0.0), Hub(radius=rng.uniform(0.01, 1.0))
    reach, depth = hub.radius + bristle.length, 10.0 ** rng.uniform(-9.0, -3.0) * bristle.length
    towards, radius = rng.uniform(0.3, 1.2), rng.uniform(0.05, 0.5) * bristle.length
    for sign in (1.0, -1.0):
        away = reach + radius - sign * depth
        bar = Bar(radius=radius, horizontal=away * math.cos(towards), vertical=away * math.sin(towards))
        run = simulate(Tool(hub=hub, bristle=bristle, bar=bar, workpart=None), Settings(accuracy=1e-10))
        names = [event.name for event in run.events]
        assert ("bar touch" in names, "bar not touched" in names) == (sign > 0.0, sign < 0.0)
        if sign > 0.0:
            turned = hub.speed * run.events[names.index("bar touch")].time
            gap = math.hypot(reach - away * math.cos(turned - towards), away * math.sin(turned - towards)) - radius
            # Ten times what the engine locates a touch to.
            assert abs(gap) < 1e-12 * bristle.length


@pytest.mark.parametrize("seed", range(10))
def test_any_angle(seed: int) -> None:
    """Angles of any size down to 1e-30, impulse and rate of the closed form."""
    rng = np.random.default_rng(seed)
    angle, e = 10.0 ** rng.uniform(-30.0, 0.0), rng.uniform(0.0, 1.0)
    mu = math.tan(angle) * rng.choice([rng.uniform(0.0, 0.5), rng.uniform(2.0, 10.0)])
    hit = strike(Chain((2.0,), (0.3,), (-angle,), (7.0,)), Surface(mu, None, e), Contact(), Settings()).contact
    theory = monofilament_impact(2.0, 0.3, 0.0, 7.0, 1.0, angle, mu, e)
    assert hit.outcome == theory.outcome_name
    # Sixteen roundings over a distance from the jam of at least a third.
    assert hit.impulse[0] == pytest.approx(theory.normal_final_impulse, rel=48 * 2.0**-52)
    assert hit.rates_after[0] == pytest.approx(theory.final_bristle_rate, rel=48 * 2.0**-52, abs=7.0 * 16 * 2.0**-52)


def test_least_angle_of_the_theory_gives_numbers() -> None:
    """The impulse of a frictionless tip grows as 1/gamma, its work m v^2/6 does not; the largest allowed is a number."""
    hit = monofilament_impact(1.0, 1.0, 0.0, 1.0, 1.0, SMALLEST, 0.0, 0.5)
    # Three roundings.
    assert hit.normal_compressive_impulse == pytest.approx(1.0 / (3.0 * SMALLEST), rel=3 * 2.0**-52)
    assert hit.normal_compressive_work == pytest.approx(-1.0 / 6.0, rel=3 * 2.0**-52)
    assert math.isfinite(normal_final_impulse(1e6, 1e12, SMALLEST, 0.0, 1.0))
    with pytest.raises(ValueError, match=r"^impact_angle = 9e-151: "):
        monofilament_impact(1.0, 1.0, 0.0, 1.0, 1.0, 0.9 * SMALLEST, 0.0, 0.5)


def test_a_swing_that_stops_short_of_the_surface_goes_on() -> None:
    """Three periods with no touch: three times the lowest place, the energy kept."""
    run = simulate(
        swinging(-1e-9),
        Settings(accuracy=1e-10),
        start_hub_angle=-tip_paths.SIDE,
        start_relative_angle=-tip_paths.SWING,
    )
    energy = run.kinetic_energy + run.potential_energy
    assert not run.contacts
    # A hundred times the accuracy, for three periods.
    np.testing.assert_allclose(energy, energy[0], rtol=1e-8)


def test_a_law_that_is_off_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def off(inverse_mass: Any, velocity: Any, friction: float, e: float, *rest: Any) -> Impact:
        return energetic_impact(inverse_mass, velocity, friction, e * (1.0 - 1e-12), *rest)

    monkeypatch.setattr(contact_laws, "energetic_impact", off)
    for name in ("strike at 1e-09 rad", "strike at a right angle", "approach 1e-12 of the tip's speed"):
        assert not named(name).run().ok


def test_slow_approaches_taken_for_none_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(inverse_mass: Any, velocity: tuple[float, float], *rest: Any) -> Impact:
        slow = abs(velocity[0]) < 1e-10 * abs(velocity[1])
        return energetic_impact(inverse_mass, (0.0, velocity[1]) if slow else velocity, *rest)

    monkeypatch.setattr(contact_laws, "energetic_impact", none)
    assert not named("approach 1e-12 of the tip's speed").run().ok
    assert named("approach 1e-09 of the tip's speed").run().ok


@pytest.mark.parametrize("error", [OverflowError("inf"), ValueError("contact: two\nlines")])
def test_a_contact_in_time_that_ends_without_a_clear_word_is_noticed(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: Any) -> None:
        raise error

    monkeypatch.setattr(CompliantLaw, "resolve", fails)
    assert not named("strike in time at 1e-06 rad").run().ok


def moved(by: float) -> Any:
    """A program that sees obstacles ``by`` lengths off."""

    def wrong(tool: Tool, settings: Settings, **start: Any) -> Trajectory:
        if tool.bar is not None:
            tool = dataclasses.replace(
                tool, bar=dataclasses.replace(tool.bar, radius=tool.bar.radius + by * tip_paths.LENGTH)
            )
        if tool.workpart is not None:
            off = Workpart(penetration=tool.workpart.penetration + by * tip_paths.LENGTH)
            tool = dataclasses.replace(tool, workpart=off)
        return simulate(tool, settings, **start)

    return wrong


PATHS = (
    ("tip's circle 1e-09 {} the bar", 2e-9),
    ("tip's circle 1e-09 {} the workpart", 2e-9),
    ("tip's circle 1e-06 {} the bar", 1e-5),
    ("swinging bristle's tip 1e-09 {} the workpart", 2e-9),
)


@pytest.mark.parametrize(("name", "by"), PATHS)
def test_an_obstacle_out_of_place_is_noticed(name: str, by: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grazing, "simulate", moved(-by))
    assert not named(name.format("into")).run().ok
    monkeypatch.setattr(grazing, "simulate", moved(by))
    assert not named(name.format("past")).run().ok


def test_a_touch_out_of_place_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """By ten times the promise, either way."""
    for by in (1e-11, -1e-11):
        monkeypatch.setattr(grazing, "simulate", moved(by))
        for what in ("bar", "workpart"):
            assert not named(f"tip's circle 1e-06 into the {what}").run().ok


def test_a_coarse_program_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def coarse(tool: Tool, _: Settings, **start: Any) -> Trajectory:
        return simulate(tool, Settings(accuracy=1e-4), **start)

    monkeypatch.setattr(grazing, "simulate", coarse)
    names = ("swing that {} the workpart by 1e-09", "swinging bristle's tip 1e-09 {} the workpart")
    ways = (("reaches", "stops short of"), ("into", "past"))
    for name, (in_, out) in zip(names, ways, strict=True):
        assert not (named(name.format(in_)).run().ok and named(name.format(out)).run().ok)
