"""Sobol indices and error propagation, against models whose answers are known in closed form."""

import math
from functools import partial

import numpy as np
import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")

from bristle_sim.comparison import Unfinished
from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_point import strike_of_keys
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


def linear(a: float, b: float, c: float, d: float) -> dict[str, float]:
    """Two outputs: a weighted sum, whose indices are the squares of its weights, and one input alone."""
    return {"sum": 3.0 * a - 2.0 * b + c + 7.0 + 0.0 * d, "alone": b}


def ishigami(x: float, y: float, z: float) -> dict[str, float]:
    """Ishigami and Homma 1990, whose indices are known; and a product, which is all interaction."""
    return {
        "ishigami": math.sin(x) + 7.0 * math.sin(y) ** 2 + 0.1 * z**4 * math.sin(x),
        "product": x * y,
    }


def test_a_linear_model_has_its_squared_slopes_as_indices():
    intervals = dict.fromkeys(SLOPES, (-1.0, 1.0))
    study = sobol_study(linear, intervals, ("sum", "alone"), 256)
    squares = np.array([each**2 for each in SLOPES.values()])
    # Quasi-Monte Carlo: errors of the order of (log n)^d/n, some 2e-2 at n = 256.
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
    study = sobol_study(ishigami, intervals, ("ishigami", "product"), 1024)
    a, b = 7.0, 0.1
    parts = (0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2, a**2 / 8.0, 0.0)
    both = b**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = sum(parts) + both
    assert study.first_order[0] == pytest.approx([each / variance for each in parts], abs=0.05)
    totals = [(parts[0] + both) / variance, parts[1] / variance, both / variance]
    assert study.total[0] == pytest.approx(totals, abs=0.05)
    assert study.first_order[1] == pytest.approx([0.0, 0.0, 0.0], abs=0.05)
    assert study.total[1] == pytest.approx([1.0, 1.0, 0.0], abs=0.05)


def test_small_spreads_of_a_pass_agree_with_error_propagation():
    """Sixteen times smaller than the smallest curvature that shows; the sample of 2 x 32 passes knows a std to some percent."""
    tool = Tool()
    settings = Settings(accuracy=1e-8)
    half_widths = {"hub_speed": 0.02, "belt_stiffness": 2e-5, "penetration": 5e-6}
    values = {
        "hub_speed": tool.hub.speed,
        "belt_stiffness": tool.belt.stiffness,
        "penetration": tool.workpart.penetration,
    }
    point = partial(strike_of_keys, settings, tool)
    intervals = {key: (values[key] - half, values[key] + half) for key, half in half_widths.items()}
    study = sobol_study(point, intervals, OUTPUTS, 16)
    changes = propagated(point, values, half_widths)
    for name, found in zip(OUTPUTS, study.values, strict=True):
        expected = math.sqrt(sum(each**2 for each in changes[name].values()) / 3.0)
        assert found.std(ddof=1) == pytest.approx(expected, rel=0.06), name


def test_an_input_that_goes_nowhere_is_refused_in_one_line():
    with pytest.raises(
        ValueError, match=r"spreads: must be smaller, \d+ of \d+ points have no result; at a = "
    ) as refusal:
        sobol_study(lambda a: {"y": math.sqrt(a), "z": a}, {"a": (-1.0, 1.0)}, ("y", "z"), 4)
    assert "\n" not in str(refusal.value)


def test_nothing_spread_is_refused():
    nothing = Spreads(**dict.fromkeys(Spreads.__dataclass_fields__, 0.0))
    with pytest.raises(ValueError, match="at least one must be more than 0"):
        tolerances(Tool(), nothing, Sampling(), Settings())


@pytest.mark.parametrize("finished", [15, 1])
def test_an_interrupted_study_keeps_the_passes_that_are_finished(
    finished: int, monkeypatch: pytest.MonkeyPatch
):
    """When the user interrupts, the first sample and seven points of the second one are done; one pass alone has no mean."""
    passes = []

    def until_interrupted(_settings: Settings, _tool: Tool, **_: float) -> dict[str, float]:
        if len(passes) == finished:
            raise KeyboardInterrupt
        passes.append(float(len(passes)))
        return dict.fromkeys(OUTPUTS, passes[-1])

    monkeypatch.setattr("bristle_sim.studies.tolerances.strike_of_keys", until_interrupted)
    with pytest.raises(Unfinished) as ended:
        tolerances(Tool(), Spreads(), Sampling(samples=8), Settings())
    found = {each.name: each.simulated for each in ended.value.report.quantities}
    assert ended.value.report.remarks == (
        f"{finished} of 120 passes are finished; indices need all of them",
    )
    assert bool(found) is (finished > 1)
    if found:
        assert found[f"{OUTPUTS[0]}_mean"] == np.mean(passes)
        assert found[f"{OUTPUTS[0]}_std"] == pytest.approx(np.std(passes, ddof=1), rel=1e-15)


def test_an_output_without_a_value_is_not_propagated():
    assert propagated(lambda x: {"y": 2.0 * x, "z": None}, {"x": 1.0}, {"x": 0.5}) == {
        "y": {"x": 1.0}
    }


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
    assert found.startswith("Speed matters most: it ranks first for 2 of 3 measures of the strike.")
    assert "normal impulse p_fy 2.75 mN s by 0.3 mN s (mostly friction)" in found
