"""Design: found tools against closed forms, the reference and dense maps, and bad input in one line."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import OptimizeResult

import bristle_sim as bs
from bristle_sim.cli import command
from bristle_sim.studies import design_search

FREE = bs.Tool(bar=None)
REACH = FREE.hub.radius + FREE.bristle.length
CUED: dict[str, Any] = {
    "vary": {"hub_speed": ("2000 rpm", "3000 rpm"), "bar_horizontal": ("47 mm", "54 mm")}
}


def test_a_tip_speed_without_bar_needs_the_hub_speed_of_the_closed_form():
    """A radial wire's tip moves at omega (r_h + L). The tolerance is that of the search, a millionth of the spread."""
    found = bs.design(FREE, want={"tip_speed_at_contact": "20 m/s"}, vary={"hub_speed": (100, 500)})
    assert found.varied["hub_speed"] == pytest.approx(20.0 / REACH, rel=1e-7)
    assert found.wants[0].reached == pytest.approx(20.0, rel=1e-7)
    assert not found.conflict
    # 1 % of the speed is 1 % of the hub's; the ends are those of 64 equal parts of the part of a part that is kept.
    assert found.kept["hub_speed"] == pytest.approx(
        (0.99 * 20 / REACH, 1.01 * 20 / REACH), rel=1e-3
    )
    slope = found.sensitivity["hub_speed"]["tip_speed_at_contact"]
    assert slope == pytest.approx(REACH, rel=1e-6)


def test_a_goal_ends_at_the_limit_of_the_impulse_which_is_proportional_to_the_speed():
    one = bs.ensemble(FREE, hub_speed=100.0).normal_final_impulse
    limit = 2.5 * float(one)
    found = bs.design(
        FREE,
        vary={"hub_speed": (100, 500)},
        at_most={"normal_final_impulse": limit},
        maximize="tip_speed_at_contact",
    )
    assert found.varied["hub_speed"] == pytest.approx(250.0, rel=1e-6)


@pytest.mark.parametrize(("end", "best"), [(0.9, 0.4), (0.1, 0.4), (0.5, 0.5)])
def test_a_minimisation_that_a_jump_misleads_gives_the_best_speed_on_its_way(
    end: float, best: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Impulse and speed are proportional to the fraction of the hub's range; the limit lies at 0.5, beyond it nothing is met."""
    limit = {"normal_final_impulse": float(bs.ensemble(FREE, hub_speed=300.0).normal_final_impulse)}
    ranges = {"hub_speed": (100.0, 500.0)}
    search = design_search.Search(FREE, ranges, {}, limit, "tip_speed_at_contact", -1.0)

    def minimize(objective: Callable[[np.ndarray], float], *_: Any, **__: Any) -> OptimizeResult:
        for place in (0.4, 0.7, 0.2):
            objective(np.array([place]))
        return OptimizeResult(x=np.array([end]))

    monkeypatch.setattr(design_search, "minimize", minimize)
    assert search._improved(np.array([0.3])) == pytest.approx([best])


def test_the_keys_change_least_where_the_wants_leave_a_choice():
    """Lagrange: the changes over the squares of their ranges are proportional to the slopes of omega (r_h + L)."""
    ranges = {"hub_speed": (150.0, 450.0), "hub_radius": (0.02, 0.05)}
    found = bs.design(FREE, want={"tip_speed_at_contact": 18.0}, vary=ranges)
    speed, radius = found.varied["hub_speed"], found.varied["hub_radius"]
    assert speed * (radius + FREE.bristle.length) == pytest.approx(18.0, rel=1e-7)
    by_speed = (speed - FREE.hub.speed) / 300.0**2 / (radius + FREE.bristle.length)
    by_radius = (radius - FREE.hub.radius) / 0.03**2 / speed
    assert by_speed == pytest.approx(
        by_radius, rel=1e-3
    )  # a minimum: quadratic in the misplacement


def test_a_fast_and_radial_strike_is_found_and_confirmed_by_the_reference():
    found = bs.design(want={"tip_speed_at_contact": "36 m/s", "lag_deg_at_contact": 0}, **CUED)
    strike = bs.simulate_reference(found.tool, accuracy=1e-9, stop_after="strike").first_contact(
        "workpart"
    )
    assert math.hypot(*strike.velocity_before) == pytest.approx(36.0, rel=1e-7)
    turned = found.tool.start_hub_angle + found.tool.hub.speed * strike.time
    assert turned == pytest.approx(strike.angles[0], abs=1e-7)
    assert found.check.difference < 1e-6
    assert found.check.apart == 0


@pytest.mark.nightly  # the ends of another curve are checked always
def test_wants_that_conflict_are_named_with_the_best_compromises():
    """No tool of a dense map over both keys has less lag at as fast a tip than the curve, but for the map's steps."""
    wants = {"tip_speed_at_contact": 42.0, "lag_deg_at_contact": 0.0}
    found = bs.design(want=wants, **CUED)
    assert found.conflict == tuple(wants)
    tip, lag = (found.trade_off[name] for name in wants)
    assert tip[0] == pytest.approx(42.0, abs=1e-3)
    assert lag[-1] == pytest.approx(0.0, abs=1e-3)
    assert (np.diff(tip) < 0.0).all()
    many = bs.ensemble(
        hub_speed=np.linspace(209.4396, 314.159, 60),
        bar_horizontal=np.linspace(0.047, 0.054, 60)[:, np.newaxis],
    )
    best = np.interp(many.tip_speed_at_contact, tip[::-1], lag[::-1], right=np.nan)
    lags = np.abs(np.degrees(many.lag_at_contact))
    assert not (lags < best - 0.02).any()
    with pytest.raises(ValueError, match="two conflicting wants"):
        bs.design(FREE, want={"tip_speed_at_contact": 20}, vary={"hub_speed": (100, 500)}).plot()


@pytest.mark.nightly
def test_the_best_compromises_end_at_the_fastest_radial_strike():
    """Most of these tools strike radially at a far lower speed, from which no small change leads to the fastest one."""
    vary = CUED["vary"] | {"bar_vertical": ("18 mm", "26 mm")}
    wants = {"tip_speed_at_contact": 45.0, "lag_deg_at_contact": 0.0}
    curve = bs.design(want=wants, vary=vary).trade_off
    radial = bs.design(want={"lag_deg_at_contact": 0}, maximize="tip_speed_at_contact", vary=vary)
    (fastest,) = (
        each.simulated for each in radial.report.quantities if each.name == "tip_speed_at_contact"
    )
    # A condition that the curve meets has the weight 1e3, squared a million, of the other one.
    assert curve["tip_speed_at_contact"][[0, -1]] == pytest.approx([45.0, fastest], rel=1e-5)
    assert curve["lag_deg_at_contact"][-1] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.nightly
def test_a_curve_of_compromises_that_jumps_meets_each_condition_at_its_end():
    """The tools at one end jam, those at the other rebound; no small steps lead from one end to the other."""
    wants = {"rebound_ratio": -0.22313, "lag_deg_at_contact": 6.30362}
    ranges = {"belt_stiffness": (0.029818, 0.035418), "penetration": (1.2477e-3, 2.1477e-3)}
    curve = bs.design(want=wants, vary=ranges).trade_off
    for (name, value), end in zip(wants.items(), (0, -1), strict=True):
        misses = np.abs(curve[name] - value)
        assert misses[end] == pytest.approx(0.0, abs=1e-3)
        assert (np.diff(misses) * (1 + 2 * end) >= 0.0).all()


def test_a_limit_that_no_tool_meets_is_named() -> None:
    """Without the bar the tip moves at omega (r_h + L), at least 100 REACH here."""
    vary = {"hub_speed": (100.0, 500.0)}
    most = {"tip_speed_at_contact": 50.0 * REACH}
    found = bs.design(FREE, vary=vary, at_most=most, minimize="normal_final_impulse")
    assert found.conflict == ("tip_speed_at_contact",)
    assert found.answer.startswith(
        f"No tool in these ranges has a tip speed v_C of at most {50.0 * REACH:.5g} m/s; the nearest: "
    )
    assert found.varied["hub_speed"] == pytest.approx(100.0, rel=1e-6)
    assert "lowest" not in found.answer
    assert not found.kept
    both = bs.design(
        FREE,
        vary=vary,
        at_most=most,
        want={"normal_final_impulse": found.before["normal_final_impulse"]},
    )
    assert both.conflict == ("tip_speed_at_contact",)


def test_a_want_and_a_limit_that_contradict_each_other_have_a_curve() -> None:
    """The impulse is proportional to the speed: half the impulse at a hub speed of 300 needs 150."""
    vary = {"hub_speed": (100.0, 500.0)}
    impulse = float(bs.ensemble(FREE, hub_speed=150.0).normal_final_impulse)
    found = bs.design(
        FREE,
        vary=vary,
        want={"tip_speed_at_contact": 300.0 * REACH},
        at_most={"normal_final_impulse": impulse},
    )
    assert found.conflict == ("tip_speed_at_contact", "normal_final_impulse")
    assert "at most" in found.answer
    assert "without regard" not in found.remarks[0]
    speeds = found.trade_off["hub_speed"]
    assert speeds[[0, -1]] == pytest.approx([300.0, 150.0], rel=1e-5)
    assert (np.diff(speeds) < 0.0).all()


def test_a_third_want_is_named_as_disregarded_on_the_curve_of_two() -> None:
    impulse = float(bs.ensemble(FREE, hub_speed=150.0).normal_final_impulse)
    wants = {
        "tip_speed_at_contact": 300.0 * REACH,
        "normal_final_impulse": impulse,
        "contact_time": 0.01,
    }
    found = bs.design(FREE, vary={"hub_speed": (100.0, 500.0)}, want=wants)
    assert found.conflict == ("tip_speed_at_contact", "normal_final_impulse")
    (curve,) = found.remarks
    assert curve.startswith(
        "The best compromises, without regard to the time of the strike, run from a tip speed"
    )


def test_a_limit_above_the_wanted_value_changes_nothing() -> None:
    want = {"tip_speed_at_contact": 300.0 * REACH}
    vary = {"hub_speed": (100.0, 500.0)}
    found = bs.design(FREE, vary=vary, want=want, at_most={"tip_speed_at_contact": 400.0 * REACH})
    assert found.varied["hub_speed"] == pytest.approx(300.0, rel=1e-7)


def test_a_key_without_effect_keeps_its_value() -> None:
    """At the end of its range too; where no key needs to change, none does, to the search's tolerance."""
    found = bs.design(
        FREE,
        want={"tip_speed_at_contact": 300.0 * REACH},
        vary={"hub_speed": (100.0, 500.0), "friction": (FREE.workpart.friction, 0.6)},
    )
    assert found.varied["friction"] == FREE.workpart.friction


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"want": {"tip_sped_at_contact": 1}, "vary": {"hub_speed": (1, 2)}}, "did you mean tip_"),
        ({"want": {"tip_speed_at_contact": "1 kg"}, "vary": {"hub_speed": (1, 2)}}, "kg"),
        ({"want": {"tip_speed_at_contact": 1}, "vary": {"hub_sped": (1, 2)}}, "did you mean hub"),
        ({"want": {"tip_speed_at_contact": 1}, "vary": {"hub_speed": (2, 2)}}, "two different"),
        ({"want": {"tip_speed_at_contact": 1}, "vary": {"wire_links": (1, 2)}}, "real numbers"),
        ({"want": {"tip_speed_at_contact": 1}, "vary": {}}, "at least one key"),
        ({"vary": {"hub_speed": (100, 200)}}, "must be given"),
        (
            {
                "want": {"tip_speed_at_contact": 36},
                "at_most": {"tip_speed_at_contact": "30 m/s"},
                "vary": {"hub_speed": (100, 200)},
            },
            "36: must be at most its upper limit, 30",
        ),
        ({"want": {"tip_speed_at_contact": 1}, "vary": {"friction": (0.1, 0.2)}}, "depend"),
        ({"want": {"tip_speed_at_contact": 9}, "vary": {"penetration": (-0.03, -0.02)}}, "no tool"),
        (
            {
                "want": {"tip_speed_at_contact": 9},
                "vary": {"bar_horizontal": (0.02, 0.025)},
            },
            "it is refused; bar_radius = ",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(given: dict[str, Any], words: str):
    with pytest.raises(ValueError, match=words) as caught:
        bs.design(**given)
    assert "\n" not in str(caught.value)


def test_the_command_prints_and_writes_the_tool(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    file = tmp_path / "tool.toml"
    ask = ["design", "--want", "tip_speed_at_contact=39m/s", "--vary", "hub_speed=2000rpm:3000rpm"]
    assert command.main([*ask, "--write-tool", str(file), "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["scenario"] == "design"
    assert found["wants"][0]["reached"] == pytest.approx(39.0, rel=1e-7)
    assert bs.read_tool(file).hub.speed == found["tool"]["hub_speed"]
    assert found["answer"].count(". ") == 0
    assert {"hub_speed", "bar_horizontal", "friction"} <= found["tool"].keys()
    quantities = {each["name"]: each["simulated"] for each in found["quantities"]}
    assert quantities["tip_speed_at_contact"] == pytest.approx(39.0, rel=1e-7)
    assert "tip_speed_at_contact" in found["sensitivity"]["hub_speed"]
    monkeypatch.setattr(design_search, "CURVE_POINTS", 3)
    assert (
        command.main([*ask, "--want", "lag_deg_at_contact=0", "--plot", str(tmp_path / "a.png")])
        == 1
    )
    assert (tmp_path / "a.png").stat().st_size > 1000
    assert (
        command.main(["design", "--want", "tip_speed_at_contact", "--vary", "hub_speed=1:2"]) == 2
    )


@pytest.mark.nightly
def test_no_quantity_has_a_slope_where_the_bar_is_just_touched_once_more() -> None:
    """The least lag is where a last touch of the bar ceases, and with it the retraction of 22 degrees at the release."""
    found = bs.design(vary={"bar_horizontal": ("47 mm", "54 mm")}, minimize="lag_deg_at_contact")
    place = found.varied["bar_horizontal"]
    beside = bs.ensemble(bar_horizontal=np.array([place - 1e-7, place + 1e-7]))
    assert np.degrees(beside.release_retraction) == pytest.approx([22.6, 0.0], abs=0.1)
    assert math.isnan(found.sensitivity["bar_horizontal"]["release_retraction_deg"])
