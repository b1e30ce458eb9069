"""The whole pass: its answer follows from its numbers, and its verdict from formulas, reference and invariants."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.comparison import Report
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, Hub, Tool, Workpart
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings, StopReason
from bristle_sim.studies.pass_invariants import invariant_rows
from bristle_sim.studies.whole_pass import whole_pass
from bristle_sim.theory import impact_phases
from bristle_sim.trajectory import Trajectory

SETTINGS = Settings()


def value(name: str, report: Report) -> float:
    """Return the simulated value of a quantity."""
    (found,) = (each.simulated for each in report.quantities if each.name == name)
    assert found is not None
    return found


class TestStart:
    def test_a_pass_begins_before_a_bar_that_stands_behind_a_quarter_turn(self) -> None:
        """Bar at 111.6 deg, where a search found the radial strike of a wire of 40 mm: the hub is then at -gamma."""
        tool = Tool().replace(bristle_length=0.04, bar_horizontal=0.05129, bar_vertical=-0.02031)
        report = whole_pass(tool, SETTINGS, with_reference=True)
        assert "no bar touches" not in report.answer
        assert {each.ok for each in report.quantities if each.reference is not None} == {True}
        # A bar that is rounded to 10 um turns the strike by up to 1e-3 rad.
        struck = tool.start_hub_angle + 261.8 * value("contact_time", report)
        assert struck == pytest.approx(-math.acos(0.063 / 0.0675), abs=1e-3)

    @pytest.mark.parametrize("solve", [simulate, simulate_reference])
    def test_an_earlier_start_delays_everything_by_its_turn(
        self, solve: Callable[..., Trajectory]
    ) -> None:
        """A straight wire without gravity turns with the hub, unchanged, until it meets the bar; to the requested accuracy."""
        options = {"settings": Settings(accuracy=1e-9)} if solve is simulate else {"accuracy": 1e-9}
        runs = [
            solve(Tool(start_hub_angle_deg=degrees), stop_after="strike", **options)
            for degrees in (-90.0, -150.0)
        ]
        first, later = (run.event_time("strike") for run in runs)
        assert later - first == pytest.approx(math.radians(60.0) / 261.8, rel=1e-7)


class TestContactPoint:
    def test_a_wire_that_strikes_with_its_knee(self) -> None:
        """Records name the knee and its place; the checks of energy and momentum use that point, the answer names it."""
        tool = Tool(bristle=Bristle(knee_angle_deg=-80.0, knee_position=0.9))
        report = whole_pass(tool, SETTINGS, with_reference=True)
        assert {each.ok for each in report.quantities} == {True}
        assert report.answer.startswith("The bristle strikes with its knee at ")
        for run in (report.subject.trajectory, report.subject.reference):
            strike = run.first_contact("workpart")
            knee = run.at(strike.time).centre_line[1]
            assert strike.point == "knee"
            assert strike.place == pytest.approx(knee, abs=1e-12)  # roundings of 0.05 m
            assert strike.place[1] == pytest.approx(-tool.workpart_depth, abs=1e-9)

    @pytest.mark.parametrize("solve", [simulate, simulate_reference])
    def test_the_bar_meets_flank_or_tip(self, solve: Callable[..., Trajectory]) -> None:
        """The flank is met where the tip's circle reaches beyond the tangent's foot, sqrt(S^2 - (r_b + d/2)^2) < r_h + L."""
        for length, point in ((0.027, "tip"), (0.04, "flank")):
            touch = solve(Tool(bristle=Bristle(length=length)), stop_after="bar touch").contacts[0]
            assert touch.point == point
            tangent = math.sqrt(math.hypot(*Bar().centre) ** 2 - Tool().bar_reach ** 2)
            assert (tangent < 0.0275 + length) is (point == "flank")
            assert math.dist(touch.place, Bar().centre) == pytest.approx(Tool().bar_reach, rel=1e-9)

    @pytest.mark.parametrize("compliance", [0.0, 1.21])
    def test_a_contact_in_time_agrees_with_the_reference(self, compliance: float) -> None:
        tool = Tool(contact=Contact("compliant", 5e-5, compliance))
        report = whole_pass(tool, SETTINGS, with_reference=True)
        assert {each.ok for each in report.quantities} == {True}


class TestAnswer:
    def test_of_the_operating_point(self) -> None:
        """Time, lag, speeds and impulse of the strike, and the differences that are largest: 10 % of p_fy, 26 % of v_C."""
        report = whole_pass(Tool(), SETTINGS)
        numbers = (
            rf"at {1e3 * value('contact_time', report):.4g} ms, {value('lag_deg_at_contact', report):.3g}° short of radial,",
            rf"{value('relative_speed_at_contact', report):.3g} rad/s relative to the hub,",
            rf"{value('tip_speed_at_contact', report):.3g} m/s, with a normal impulse of",
            rf"{1e3 * value('normal_final_impulse', report):.3g} mN s; the tip reverses its slip\.",
            r"normal impulse p_fy \S+ mN s, by formula 3\.06 mN s; tip speed v_C \S+ m/s, printed in the dissertation 30 m/s\.$",
        )
        for each in numbers:
            assert re.search(each, report.answer), each

    @pytest.mark.parametrize(
        ("tool", "words"),
        [
            (
                Tool(belt=Belt(stiffness=0.00041)),
                r"does not strike the workpart: it folds back by 90° at 5\.\d+ ms; a stiffer",
            ),
            (
                Tool(workpart=Workpart(penetration=-0.001)),
                r"does not strike the workpart: its tip stays [\d.]+ mm above it",
            ),
            (Tool(workpart=None), r"does not strike the workpart: the tool has no workpart"),
            (
                Tool(bar=None),
                r"The bristle, which no bar touches, strikes at [\d.]+ ms, radial, turning with the hub, its tip at 14\.3 m/s,",
            ),
            (Tool(workpart=Workpart(restitution=0.0)), "; the tip stays"),
        ],
    )
    def test_changes_with_the_tool(self, tool: Tool, words: str) -> None:
        """A tip that turns with the hub has 261.8 rad/s times 54.5 mm."""
        assert re.search(words, whole_pass(tool, SETTINGS).answer)


class TestInvariants:
    def test_what_holds_is_one_sentence_and_no_row(self) -> None:
        report = whole_pass(Tool(), SETTINGS)
        sentence = re.fullmatch(
            r"energy, gap, impulse law and friction are satisfied to (\S+)", report.remarks[0]
        )
        assert sentence
        largest = max(abs(each) for each in report.extra["invariants"].values())
        assert float(sentence[1]) == pytest.approx(largest, rel=0.5)
        assert not {each.name for each in report.quantities} & set(report.extra["invariants"])

    def test_the_scenario_fails_with_a_wrong_law(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """A law that takes e* for another: the whole pass says so without the reference."""
        right = impact_phases.resolve_phases

        def wrong(*numbers):  # type: ignore[no-untyped-def]
            *before, restitution, friction, stick = numbers
            return right(*before, 0.9 * restitution, friction, stick)

        monkeypatch.setattr("bristle_sim.scene.impacts.resolve_phases", wrong)
        assert [
            each.name for each in whole_pass(Tool(), SETTINGS).quantities if each.ok is False
        ] == ["restitution_work_error"]

    def test_a_pass_without_a_strike_confirms_nothing(self) -> None:
        """Its release and largest retraction agree with the reference's, which says nothing of a strike."""
        lifted = Tool(workpart=Workpart(penetration=-0.001))
        report = whole_pass(lifted, SETTINGS, with_reference=True)
        assert {each.ok for each in report.quantities} == {None}
        assert sum(each.reference is not None for each in report.quantities) == 3

    def test_a_contact_that_is_cut_off_in_restitution_has_no_restitution_to_judge(self) -> None:
        """Two links in line hardly leave a surface on which the tip sticks: their contact outlasts its limit."""
        tool = Tool(
            bristle=Bristle(links=2),
            bar=None,
            workpart=Workpart(friction=0.6, restitution=1.0),
            contact=Contact("compliant"),
        )
        settings = Settings(accuracy=1e-3)
        run = simulate(tool, settings, stop_after="workpart release")
        strike = run.first_contact("workpart")
        assert strike is not None
        assert strike.outcome == "stiction"
        assert [row.name for row in invariant_rows(tool, settings, run) if row.ok is False] == []


class TestGivenUp:
    def test_a_strike_before_the_run_is_given_up_is_reported(self) -> None:
        """Half the steps of the whole pass carry it beyond its strike, which stands as without the limit."""
        free = whole_pass(Tool(), SETTINGS)
        report = whole_pass(Tool(), Settings(maximum_steps=free.steps // 2))
        for name in ("contact_time", "tip_speed_at_contact", "release_time"):
            assert value(name, report) == value(name, free)
        assert report.outcome == "rebound"
        assert report.extra["stopped"]["complete"] is False
        assert report.extra["stopped"]["time"] > report.events[-1][1] - 1e-12
        (told,) = [remark for remark in report.remarks if remark.startswith("given up at")]
        assert report.extra["stopped"]["remedy"] in told


TOOLS = {
    "default": Tool(),
    "knee": Tool(bristle=Bristle(knee_angle_deg=30.0)),
    "gravity and damping": Tool(gravity=9.81, belt=Belt(damping_ratio=0.1)),
    "rubbing bar that throws back": Tool(bar=Bar(friction=0.3, restitution=0.6)),
    "contact resolved in time": Tool(contact=Contact("compliant")),
    "engine's contact": Tool(contact=Contact("engine")),
    "at rest": Tool(hub=Hub(speed=0.0)),
    "bar in the knee, which meets the second segment while the first one touches": Tool(
        hub=Hub(speed=237.7),
        belt=Belt(damping_ratio=0.05),
        bristle=Bristle(knee_angle_deg=9.7),
        bar=Bar(horizontal=0.0365),
    ),
    "knee on the workpart, then the end of the wire too": Tool(
        hub=Hub(speed=312.0),
        belt=Belt(stiffness=0.043, damping_ratio=0.46),
        bristle=Bristle(0.0386, wire_diameter=0.000525, knee_position=0.874, knee_angle_deg=-56.0),
        bar=None,
        workpart=Workpart(penetration=0.011, friction=0.772, restitution=0.0),
    ),
    # The integrated loss of half of them and of all samples happens to be the same; neither is exact.
    "half of critical damping": Tool().replace(
        hub_speed=109.8,
        bristle_length=0.02295,
        wire_diameter=0.0007926,
        belt_damping_ratio=0.4916,
        friction=0.2513,
        restitution=0.6927,
        belt_stiffness=0.179,
        bar_radius=0.007151,
        bar_horizontal=0.04383,
        bar_vertical=0.02413,
        penetration=0.00111,
        knee_angle_deg=-34.94,
        knee_position=0.8293,
    ),
}


@pytest.fixture(scope="module")
def run() -> Trajectory:
    return simulate(Tool(), SETTINGS)


def verdicts(tool: Tool, settings: Settings, run: Trajectory) -> dict[str, bool | None]:
    return {row.name: row.ok for row in invariant_rows(tool, settings, run)}


@pytest.mark.parametrize("name", TOOLS)
@pytest.mark.parametrize("settings", [Settings(accuracy=1e-4), SETTINGS, Settings(accuracy=1e-9)])
def test_invariants_are_kept(name: str, settings: Settings) -> None:
    rows = invariant_rows(TOOLS[name], settings, simulate(TOOLS[name], settings))
    assert [(row.name, row.simulated) for row in rows if row.ok is False] == []
    assert sum(row.ok is True for row in rows) >= 2


def only(name: str, found: dict[str, bool | None]) -> bool:
    return found[name] is False and all(
        ok is not False for other, ok in found.items() if other != name
    )


class TestNoticed:
    """Each invariant notices the error that breaks it."""

    def test_energy_gained_in_flight(self, run: Trajectory) -> None:
        """Rates 1e-4 too high from half the last flight on: 2e-4 of the kinetic energy, twenty times the tolerance."""
        rates = run.rates.copy()
        late = run.time > 0.5 * (run.contacts[-1].time + run.contacts[-1].duration + run.time[-1])
        assert late.any()
        rates[late] *= 1.001
        assert only("energy_balance", verdicts(Tool(), SETTINGS, replace(run, rates=rates)))

    def test_overlap(self, run: Trajectory) -> None:
        strike = int(np.argmin(np.abs(run.time - run.first_contact("workpart").time)))  # type: ignore[union-attr]
        line = run.centre_line.copy()
        line[strike, -1, 1] -= 1e-4 * Tool().bristle.length
        assert only("deepest_overlap", verdicts(Tool(), SETTINGS, replace(run, centre_line=line)))

    def test_impulse_that_does_not_change_the_velocity(self, run: Trajectory) -> None:
        strike = run.first_contact("workpart")
        assert strike is not None
        assert strike.compressive_impulse is not None
        contacts = [
            replace(each, velocity_after=(each.velocity_after[0] * 1.01, each.velocity_after[1]))
            if each is strike
            else each
            for each in run.contacts
        ]
        assert (
            verdicts(Tool(), SETTINGS, replace(run, contacts=tuple(contacts)))[
                "impulse_momentum_error"
            ]
            is False
        )

    def test_other_restitution_and_friction(self, run: Trajectory) -> None:
        """A tangential impulse lies outside the cone of a smooth surface, whatever it is."""
        springy = Tool(workpart=Workpart(restitution=0.5))
        smooth = Tool(workpart=Workpart(friction=0.0))
        assert only("restitution_work_error", verdicts(springy, SETTINGS, run))
        assert only("friction_cone_excess", verdicts(smooth, SETTINGS, run))

    def test_friction_that_does_work_on_the_wire(self, run: Trajectory) -> None:
        """Friction's work in a sustained contact with its sign turned; the cone is not left."""
        drag = next(
            each for each in run.contacts if each.law == "sustained" and each.obstacle == "workpart"
        )
        assert drag.compressive_work is not None
        normal, tangential = drag.compressive_work
        assert tangential < 0.0
        helping = [
            replace(each, compressive_work=(normal, -tangential)) if each is drag else each
            for each in run.contacts
        ]
        assert (
            verdicts(Tool(), SETTINGS, replace(run, contacts=tuple(helping)))["friction_work"]
            is False
        )


def test_a_reference_that_gives_up_is_a_line_and_no_agreement(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It has come to 1 ms, long before the largest retraction."""
    reached = simulate_reference(Tool(), duration=1e-3)
    given_up = replace(reached, stop_reason=StopReason.ACCURACY)
    monkeypatch.setattr("bristle_sim.reference.simulate_reference", lambda *_, **__: given_up)
    report = whole_pass(Tool(), SETTINGS, with_reference=True)
    expected = (
        "the reference gives up at 1.0000 ms: no step is short enough for the requested accuracy"
    )
    assert expected in report.remarks
    assert False in {each.ok for each in report.quantities}
