"""Passes of many tools at once: against closed forms and the model's numbers, and as a result that people read."""

from __future__ import annotations

import math

import numpy as np
import pint
import pytest

import bristle_sim as bs
from bristle_sim.passes import ensemble as entry
from bristle_sim.passes.crossing import root
from bristle_sim.passes.motion import course_of, free_acceleration, step_length
from bristle_sim.passes.request import passes_of, request_of
from bristle_sim.passes.result import QUANTITIES
from bristle_sim.passes.strike import OUTCOMES
from bristle_sim.theory.monofilament import monofilament_impact

TOOL = bs.Tool()


def test_the_pass_that_two_independent_integrations_agree_on():
    """The ledger's third row; the printed digits are the tolerance. The release is ill-conditioned: its last digit may be off."""
    many = bs.ensemble(bar_restitution=[0.0, 0.42])
    assert many.contact_time[0] == pytest.approx(4.5300e-3, abs=5e-8)
    assert many.relative_speed_at_contact == pytest.approx([877.09, 911.9], abs=0.05)
    assert np.degrees(many.lag_at_contact) == pytest.approx([2.743, 3.300], abs=5e-4)
    assert math.degrees(many.largest_retraction[0]) == pytest.approx(44.995, abs=5e-4)
    assert math.degrees(many.release_retraction[0]) == pytest.approx(43.6, abs=0.05)
    assert many.release_time[0] == pytest.approx(2.9534e-3, abs=1e-7)


def test_energy_is_kept_between_the_largest_retraction_and_the_strike():
    """Without damping and gravity I alpha'^2/2 + k_T alpha^2/2 - m r_h (L/2) omega^2 cos alpha is constant in flight."""
    speed = np.linspace(240.0, 300.0, 7)
    many = bs.ensemble(hub_speed=speed, accuracy=1e-10)
    wire = TOOL.bristle
    stiffness = TOOL.belt.stiffness
    rooted = wire.mass * TOOL.hub.radius * 0.5 * wire.length * speed**2

    def potential(angle: np.ndarray) -> np.ndarray:
        return 0.5 * stiffness * angle**2 - rooted * np.cos(angle)

    gained = potential(many.largest_retraction) - potential(many.lag_at_contact)
    expected = np.sqrt(2.0 * gained / wire.inertia_about_root)
    # The accuracy, of an energy that is a square.
    np.testing.assert_allclose(many.relative_speed_at_contact, expected, rtol=2e-10)


def test_a_wire_without_bar_strikes_radially_by_the_closed_form():
    """It turns with the hub, R = 1, up to cos gamma = depth/(r_h + L)."""
    friction = np.array([0.0, 0.1, 0.31, 0.4])
    many = bs.ensemble(TOOL.replace(bar=None), friction=friction)
    reach = TOOL.hub.radius + TOOL.bristle.length
    gamma = math.acos(TOOL.workpart_depth / reach)
    wire = (TOOL.bristle.mass, TOOL.bristle.length, TOOL.hub.radius, TOOL.hub.speed)
    expected = monofilament_impact(*wire, 1.0, gamma, friction, 0.42, friction)
    # The strike is located to rounding; the law's closed form and its phases differ by rounding.
    np.testing.assert_allclose(
        many.contact_time, (0.5 * math.pi - gamma) / TOOL.hub.speed, rtol=1e-14
    )
    np.testing.assert_allclose(
        many.normal_compressive_impulse, expected.normal_compressive_impulse, rtol=1e-12
    )
    np.testing.assert_allclose(many.normal_final_impulse, expected.normal_final_impulse, rtol=1e-12)
    np.testing.assert_allclose(many.final_bristle_rate, expected.final_bristle_rate, rtol=1e-12)
    assert np.isnan(many.release_time).all()
    assert set(many.reason) == {entry.UNTOUCHED}


@pytest.mark.parametrize("gravity", [0.0, 500.0])
def test_the_series_solves_the_equation_of_motion(gravity: float):
    """Its second derivative at the end of a step is that of the equation, to the tolerance of the step's last terms."""
    request = request_of(TOOL, {"belt_damping_ratio": [0.0, 0.5], "gravity": gravity}, 1.0)
    passes, _ = passes_of(request, np.arange(2))
    passes.angle[:] = [-0.7, -0.3]
    passes.rate[:] = [1.0, -2.0]
    course = course_of(passes)
    step = step_length(passes, course, 1e-11)
    angle, rate = course.at(step, np.arange(2))
    degrees = np.arange(1, course.series.shape[1])[:, np.newaxis]
    found = (degrees * course.series[1, 1:] * step ** (degrees - 1)).sum(axis=0)
    expected = free_acceleration(passes, passes.hub_angle + step, angle, rate)
    np.testing.assert_allclose(found, expected, rtol=1e-8)


@pytest.mark.parametrize("slopes", [True, False])
@pytest.mark.parametrize("width", [1.0, 1e-6])
def test_a_root_beside_a_singularity_is_found(width: float, slopes: bool):
    """1 - a/(w - x)^(3/2) is almost constant up to its root, whose distance from the end w is a^(2/3).

    The error is 1e-13 w over that distance, which is at least 1e-6 w.
    """
    a = np.array([1e-9, 1e-3]) * width**1.5

    def function(x: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        value = 1.0 - a[chosen] * (width - x) ** -1.5
        return value, -1.5 * a[chosen] * (width - x) ** -2.5 if slopes else None

    low = np.zeros(2)
    high = np.full(2, width * (1.0 - 1e-12))
    found = root(function, (low, high), function(high, np.arange(2))[0], low + 1e-15 * width)
    np.testing.assert_allclose(width - found, a ** (2.0 / 3.0), rtol=0.0, atol=1e-7 * width)


def test_friction_locks_a_wire_on_the_bar():
    many = bs.ensemble(bar_friction=[0.3, 50.0])
    assert many.outcome.tolist() == ["reverses its slip", "jams"]
    assert "bar" in many.reason[1]


def test_a_tool_out_of_range_spoils_no_other():
    speed = np.array([250.0, -1.0, math.nan, 0.0, 280.0])
    many = bs.ensemble(hub_speed=speed)
    alone = bs.ensemble(hub_speed=speed[[0, 4]])
    assert (many.outcome == "refused").tolist() == [False, True, True, True, False]
    assert all("hub_speed" in each for each in many.reason[1:4])
    for name in QUANTITIES:
        np.testing.assert_allclose(
            getattr(many, name)[[0, 4]], getattr(alone, name), rtol=1e-9, atol=1e-12, err_msg=name
        )
        assert np.isnan(getattr(many, name)[1:4]).all()


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"penetration": 0.03}, "penetration"),
        ({"bar_radius": 0.04}, "bar_radius"),
        ({"wire_links": 4}, "wire_links"),
        ({"knee_angle_deg": 10.0}, "knee_angle_deg"),
        ({"contact": "compliant"}, "contact"),
        ({"contact_duration": 1e-5}, "contact_duration"),
        ({"belt_stiffness": 1e6}, "belt_stiffness"),
        ({"belt_stiffness": 1e-4}, "quarter turn"),
    ],
)
def test_a_tool_that_the_method_cannot_do_is_refused_with_the_reason(
    values: dict[str, float], word: str
):
    many = bs.ensemble(**values)
    assert many.outcome == "refused"
    assert word in many.reason[()]


@pytest.mark.parametrize(
    "values",
    [
        {"hub_sped": 1.0},
        {"hub_speed": "27 mm"},
        {"hub_speed": [True]},
        {"hub_speed": [1j]},
        {"hub_speed": {}},
        {"hub_speed": [1.0, 2.0], "friction": [0.1, 0.2, 0.3]},
        {"hub_speed": [[1.0], [1.0, 2.0]]},
        {"hub_speed": pint.UnitRegistry().Quantity([2000.0, 2500.0], "rpm")},
        {"friction": [0.3, None]},
        {"accuracy": 2.0},
    ],
)
def test_a_request_without_meaning_raises_one_line(values: dict[str, object]):
    with pytest.raises(ValueError, match=f"^[^\n]*{next(iter(values))}[^\n]+$"):
        bs.ensemble(**values)  # type: ignore[arg-type]


def test_an_array_may_omit_single_values_of_an_optional_key():
    many = bs.ensemble(bristle_mass=[None, "80 mg"], restitution_friction=[0.2, None])
    alone = (bs.ensemble(restitution_friction=0.2), bs.ensemble(bristle_mass=8e-5))
    np.testing.assert_allclose(
        many.normal_final_impulse, [each.normal_final_impulse for each in alone], rtol=1e-9
    )
    assert many == bs.ensemble(bristle_mass=[None, 8e-5], restitution_friction=[0.2, None])
    assert many != bs.ensemble(bristle_mass=[None, 8e-5], restitution_friction=[0.3, None])


def test_keys_broadcast_and_blocks_join(monkeypatch: pytest.MonkeyPatch):
    """The order of passes in blocks does not matter beyond rounding, and each result stands at its place."""
    values = {"hub_speed": np.linspace(200.0, 300.0, 7), "friction": np.array([[0.1], [0.5]])}
    whole = bs.ensemble(**values)
    monkeypatch.setattr(entry, "BLOCK", 3)
    monkeypatch.setattr(entry, "LEAST_FLYING", 2)
    finished = list[float]()
    parts = bs.ensemble(progress=finished.append, **values)
    assert whole.shape == parts.shape == (2, 7)
    np.testing.assert_allclose(whole.normal_final_impulse, parts.normal_final_impulse, rtol=1e-9)
    assert finished == sorted(finished)
    assert finished[-1] == 1.0


def test_a_bar_that_returns_all_energy_is_tapped_again_and_again():
    """The wire never rests on it; the pass is the scene's, whose accuracy is 1e-9, magnified by some taps."""
    many = bs.ensemble(bar_restitution=1)
    strike = bs.simulate(
        TOOL.replace(bar_restitution=1.0), bs.Settings(accuracy=1e-9)
    ).first_contact("workpart")
    assert strike is not None
    assert many.contact_time == pytest.approx(strike.time, rel=1e-7)


def test_tools_alike_to_a_millionth_have_one_outcome():
    """A first touch located at the very tip must not end in taps of no height for some of them."""
    values = {
        "hub_speed": 264.257,
        "hub_radius": 0.0274897,
        "bristle_length": 0.0270837,
        "wire_diameter": 0.000700193,
        "wire_density": 7828.43,
        "belt_stiffness": 0.0230243,
        "belt_damping_ratio": 0.00734233,
        "bar_radius": 0.00438667,
        "bar_horizontal": 0.0502796,
        "bar_vertical": 0.0224286,
        "penetration": 0.00452707,
        "friction": 0.261584,
        "restitution": 0.402943,
    }
    chance = np.random.default_rng(1)
    spread = {
        key: value * (1.0 + 2e-6 * chance.uniform(-1.0, 1.0, 600)) for key, value in values.items()
    }
    assert set(bs.ensemble(bs.Tool(), **spread).outcome) == {"reverses its slip"}


def test_texts_carry_units():
    texts = bs.ensemble(hub_speed="2500 rpm", bristle_length=["27 mm", "0.028"])
    numbers = bs.ensemble(hub_speed=2500.0 * math.pi / 30.0, bristle_length=[0.027, 0.028])
    np.testing.assert_array_equal(texts.contact_time, numbers.contact_time)


def test_limits_are_those_of_the_closed_forms():
    """Without bar and with R = 1 the tip rebounds for mu < tan gamma (2.51), and strikes where the workpart cuts its circle."""
    tool = TOOL.replace(bar=None)
    gamma = math.acos(TOOL.workpart_depth / (TOOL.hub.radius + TOOL.bristle.length))
    (change,) = bs.limits(tool, friction=(0.1, 0.8))
    assert (change.above, change.at) == ("stays", pytest.approx(math.tan(gamma), abs=1e-8))
    (change,) = bs.limits(tool, penetration=("-1 mm", "1 mm"))
    assert (change.below, change.at) == ("does not strike", pytest.approx(0.0, abs=1e-10))
    # A rod at the angle phi to the normal has K_nt/K_tt = tan phi, the friction from which its tip sticks.
    many = bs.ensemble()
    phi = TOOL.hub.speed * float(many.contact_time) - 0.5 * math.pi - float(many.lag_at_contact)
    (change,) = bs.limits(friction=("0.1", 0.6))
    assert (change.below, change.above) == ("reverses its slip", "sticks and rebounds")
    assert change.confirmed
    assert change.at == pytest.approx(math.tan(-phi), abs=1e-7)
    assert bs.limits(hub_speed=(250.0, 260.0)) == ()


@pytest.mark.parametrize(
    ("key", "ends", "outcomes"),
    [
        ("start_hub_angle_deg", (-90.0, -68.0), ["reverses its slip", "refused"]),
        ("bar_horizontal", ("36 mm", "38 mm"), ["refused", "reverses its slip"]),
        ("restitution", (0.0, 0.01), ["stays", "rebounds"]),
        ("tangential_compliance", (0.0, 1.5), ["reverses its slip", "rebounds"]),
    ],
)
def test_limits_of_refused_tools_and_at_an_end_of_the_range_are_confirmed(
    key: str, ends: tuple[float, float], outcomes: list[str]
) -> None:
    """A bar in the wire, a wire that folds back, a rebound from the least restitution on, and two changes within the accuracy."""
    tool = TOOL.replace(friction=0.5 if key == "restitution" else 0.45)
    (change,) = bs.limits(tool, **{key: ends})  # type: ignore[arg-type]
    assert [change.below, change.above] == outcomes
    assert change.confirmed


@pytest.mark.parametrize(
    "between",
    [
        {},
        {"progress": (0.1, 0.2)},
        {"wire_links": (1, 4)},
        {"friction": 0.1},
        {"friction": (0.1, 0.1)},
        {"friction": (0.1, math.inf)},
        {"frict": (0.1, 0.2)},
        {"tool": TOOL.replace(knee_angle_deg=5.0), "friction": (0.1, 0.2)},
    ],
)
def test_limits_of_no_range_are_refused(between: dict[str, object]):
    with pytest.raises(ValueError, match=r"^[^\n]+$"):
        bs.limits(**between)  # type: ignore[arg-type]


def test_tables_and_picture():
    many = bs.ensemble(hub_speed=np.linspace(240.0, 280.0, 3), friction=np.array([[0.1], [0.6]]))
    data = many.to_xarray()
    assert data.normal_final_impulse.dims == ("friction", "hub_speed")
    assert data.normal_final_impulse.attrs["units"] == "N s"
    frame = many.to_dataframe()
    assert len(frame) == 6
    assert frame["hub_speed"].tolist() == [240.0, 260.0, 280.0] * 2
    assert set(frame["outcome"]) <= set(OUTCOMES)
    assert len(many.plot().axes) >= len(QUANTITIES)
    with pytest.raises(ValueError, match="must be one or two axes"):
        bs.ensemble().plot()
