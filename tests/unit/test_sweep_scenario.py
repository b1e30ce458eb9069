"""A scenario's quantities over its keys, of a scenario whose answers are known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("zarr", reason="needs the extra sweep")

from bristle_sim.comparison import Quantity, Report
from bristle_sim.studies.sweep_scenario import sweep_scenario


def halves(length: float, width: float = 1.0) -> Report:
    """A rectangle's area and diagonal; none for a length of 0, and no diagonal for a width of 3."""
    if length == 0.0:
        raise ValueError("length = 0: must be more than 0 (m)")
    quantities = (
        Quantity("area", "m^2", length * width, label="area A"),
        Quantity("diagonal", "m", None if width == 3.0 else float(np.hypot(length, width))),
    )
    return Report(None, quantities, answer="A width of 3 m has no diagonal.")


@pytest.mark.parametrize("store", [None, "store"])
def test_a_table_over_two_keys_has_units_labels_and_reasons(store: str | None, tmp_path: Path):
    axes = {"length": [0.0, 3.0], "width": [4.0, 3.0]}
    found = sweep_scenario(halves, axes, units={"length": "m"}, store=store and tmp_path / store)
    assert np.array_equal(found["area"], [[np.nan, np.nan], [12.0, 9.0]], equal_nan=True)
    assert np.array_equal(found["diagonal"], [[np.nan, np.nan], [5.0, np.nan]], equal_nan=True)
    assert found["failure"].values.tolist() == [
        ["length = 0: must be more than 0 (m)"] * 2,
        ["", "A width of 3 m has no diagonal."],
    ]
    assert found["area"].attrs == {"units": "m^2", "long_name": "area A"}
    assert found["length"].attrs == {"units": "m"}


def test_a_table_without_results_says_why_everywhere():
    found = sweep_scenario(halves, {"length": [0.0]})
    assert list(found.data_vars) == ["failure"]
    assert found["failure"].item() == "length = 0: must be more than 0 (m)"


@pytest.mark.parametrize("axes", [{}, {"a": [1.0], "b": [1.0], "c": [1.0]}])
def test_more_keys_than_can_be_drawn_are_refused(axes: dict[str, Any]):
    with pytest.raises(ValueError, match="must be one key or two"):
        sweep_scenario(halves, axes)
