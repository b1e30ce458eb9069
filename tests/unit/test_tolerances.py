"""Sobol indices and error propagation, against models whose answers are known in closed form."""

import math
from functools import partial

import numpy as np
import pytest

from bristle_sim.arrays import Array
from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_point import strike_of_keys, strikes_of_keys
from bristle_sim.studies.tolerances import (
    OUTPUTS,
    Sampling,
    Spreads,
    answer,
    propagated,
    sobol_study,
    tolerances,
)

SLOPES = {"a": 3.0, "b": -2.0, "c": 1.0, "d": 0.0}


def linear(a: Array, b: Array, c: Array, d: Array) -> dict[str, Array]:
    """Two outputs: a weighted sum, whose indices are the squares of its weights, and one input alone."""
    return {"sum": 3.0 * a - 2.0 * b + c + 7.0 + 0.0 * d, "alone": b}


def ishigami(x: Array, y: Array, z: Array) -> dict[str, Array]:
    """Ishigami and Homma 1990, whose indices are known; and a product, which is all interaction."""
    return {
        "ishigami": np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x),
        "product": x * y,
    }


def test_a_linear_model_has_its_squared_slopes_as_indices():
    intervals = dict.fromkeys(SLOPES, (-1.0, 1.0))
    study = sobol_study(linear, intervals, ("sum", "alone"), 4096)
    squares = np.array([each**2 for each in SLOPES.values()])
    # Quasi-Monte Carlo: errors of the order of (log n)^d/n, some 2e-2 in sequences of n = 256.
    assert study.first_order[0] == pytest.approx(squares / squares.sum(), abs=0.03)
    assert study.total[0] == pytest.approx(squares / squares.sum(), abs=0.03)
    assert study.total[1] == pytest.approx([0.0, 1.0, 0.0, 0.0], abs=0.03)
    (row, _) = study.rows({})
    # The variance of a uniform input on (-1, 1) is 1/3.
    assert row["mean"] == pytest.approx(7.0, abs=0.01)
    assert row["std"] == pytest.approx(math.sqrt(squares.sum() / 3.0), rel=0.01)
    assert row["indices"]["a"]["total"] == study.total[0, 0]


def test_interactions_are_in_the_total_index_alone():
    intervals = dict.fromkeys("xyz", (-math.pi, math.pi))
    study = sobol_study(ishigami, intervals, ("ishigami", "product"), 4096)
    a, b = 7.0, 0.1
    parts = (0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2, a**2 / 8.0, 0.0)
    both = b**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = sum(parts) + both
    assert study.first_order[0] == pytest.approx([each / variance for each in parts], abs=0.05)
    totals = [(parts[0] + both) / variance, parts[1] / variance, both / variance]
    assert study.total[0] == pytest.approx(totals, abs=0.05)
    assert study.first_order[1] == pytest.approx([0.0, 0.0, 0.0], abs=0.05)
    assert study.total[1] == pytest.approx([1.0, 1.0, 0.0], abs=0.05)


def test_the_intervals_hold_the_known_indices_and_shrink_with_the_sample():
    """Of 24 independent intervals of 95 % three may miss, with a probability of a thousandth; four times the sample halves them."""
    squares = np.array([each**2 for each in SLOPES.values()])
    expected = squares / squares.sum()
    widths = []
    missed = 0
    for samples in (256, 4096):
        for seed in (1, 2, 3):
            study = sobol_study(
                linear, dict.fromkeys(SLOPES, (-1.0, 1.0)), ("sum", "alone"), samples, seed=seed
            )
            low, high = study.total_interval[0].T
            missed += np.count_nonzero((expected < low - 1e-12) | (expected > high + 1e-12))
            widths.append(float((high - low)[:3].max()))
    assert missed <= 3
    assert max(widths[3:]) < 0.5 * min(widths[:3])


def test_small_spreads_of_a_pass_agree_with_error_propagation():
    """Sixteen times smaller than the smallest curvature that shows; 2 x 512 passes know a std to some percent."""
    tool = Tool()
    half_widths = {"hub_speed": 0.02, "belt_stiffness": 2e-5, "penetration": 5e-6}
    values = {
        "hub_speed": tool.hub.speed,
        "belt_stiffness": tool.belt.stiffness,
        "penetration": tool.workpart.penetration,
    }
    point = partial(strikes_of_keys, Settings(accuracy=1e-8), tool)
    intervals = {key: (values[key] - half, values[key] + half) for key, half in half_widths.items()}
    study = sobol_study(point, intervals, OUTPUTS, 512)
    changes = propagated(point, intervals)
    for name, found in zip(OUTPUTS, study.values, strict=True):
        expected = math.sqrt(sum(each**2 for each in changes[name].values()) / 3.0)
        assert found.std(ddof=1) == pytest.approx(expected, rel=0.06), name


def test_strikes_in_arrays_are_those_of_the_scene():
    """To the accuracy of both; the crater's depth follows from works and entry angle."""
    settings = Settings(accuracy=1e-8)
    many = strikes_of_keys(settings, Tool(), friction=np.array([0.2, 0.4, 0.0]))
    for number, friction in enumerate((0.2, 0.4)):
        for name, value in strike_of_keys(settings, friction=friction).items():
            assert many[name][number] == pytest.approx(value, rel=1e-6), name
    assert np.isnan(many["crater_depth"][2])  # without friction no chip is cut
    thin = strikes_of_keys(settings, Tool(), wire_diameter=np.array([5e-4, 0.0]))["crater_depth"]
    alone = strike_of_keys(settings, wire_diameter=5e-4)["crater_depth"]
    assert thin[0] == pytest.approx(alone, rel=1e-6)
    assert np.isnan(thin[1])
    bent = Tool().replace(knee_angle_deg=1.0)
    alone = strike_of_keys(settings, bent, friction=0.2)
    found = strikes_of_keys(settings, bent, friction=np.array([0.2]))
    assert {name: found[name][0] for name in alone} == alone


def test_an_input_that_goes_nowhere_is_refused_in_one_line():
    def broken(a: Array) -> dict[str, Array]:
        with np.errstate(invalid="ignore"):
            return {"y": np.sqrt(a), "z": a, "failure": np.full(a.shape, "", dtype=object)}

    with pytest.raises(
        ValueError,
        match=r"spreads: must be smaller, no result at \d+ of \d+ points; at a = .*: no y",
    ) as refusal:
        sobol_study(broken, {"a": (-1.0, 1.0)}, ("y", "z"), 32)
    assert "\n" not in str(refusal.value)


def test_nothing_spread_is_refused():
    nothing = Spreads(**dict.fromkeys(Spreads.__dataclass_fields__, 0.0))
    with pytest.raises(ValueError, match="at least one must be more than 0"):
        tolerances(Tool(), nothing, Sampling(), Settings())


def test_an_output_without_a_value_is_not_propagated():
    def model(x: Array) -> dict[str, Array]:
        return {"y": 2.0 * x, "z": np.full(x.shape, np.nan)}

    assert propagated(model, {"x": (0.5, 1.5)}) == {"y": {"x": 1.0}}


def test_the_tolerance_that_matters_most_ranks_first_for_most_outputs() -> None:
    speed = {"total": 0.9}
    friction = {"total": 0.1}
    rows = [
        {
            "output": "tip_speed_at_contact",
            "mean": 37.9,
            "std": 0.6,
            "indices": {"speed": speed, "friction": friction},
        },
        {
            "output": "normal_final_impulse",
            "mean": 2.75e-3,
            "std": 3e-4,
            "indices": {"speed": friction, "friction": speed},
        },
        {
            "output": "lag_deg_at_contact",
            "mean": 2.7,
            "std": 1.5,
            "indices": {"speed": speed, "friction": friction},
        },
    ]
    found = answer(rows)
    assert found.startswith(
        "Speed matters most for tip speed v_C, lag at the strike; friction matters most for normal impulse p_fy."
    )
    assert "normal impulse p_fy 2.75 mN s ± 0.3 mN s" in found
