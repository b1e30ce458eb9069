"""The picture of a release: its cue times and the bars' places."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from bristle_sim.parameters import Bar, Tool
from bristle_sim.render.cue_figure import cue_figure
from bristle_sim.settings import Settings
from bristle_sim.studies.cue_timing import CueTiming, cue_timing
from impact_cases import data, panel


@pytest.fixture(scope="module")
def release() -> CueTiming:
    subject = cue_timing(Tool(), math.radians(44.5), Settings(), with_reference=False).subject
    assert isinstance(subject, CueTiming)
    return subject


def bars(axes: Axes) -> dict[str, np.ndarray]:
    """Centres of the bars drawn, m, by name."""
    return {
        patch.get_gid(): -1e-3 * np.array(patch.get_center())
        for patch in axes.patches
        if isinstance(patch, Circle) and patch.get_gid()
    }


def test_cue_figure_draws_the_bar_where_the_keys_say_and_the_wire_on_the_bar_it_needs(release: CueTiming) -> None:
    moved = Bar(horizontal=0.052, vertical=0.018)
    plan = panel(cue_figure(dataclasses.replace(release, bar=moved)), "c")
    drawn = bars(plan)
    assert drawn["bar as given"] == pytest.approx([0.052, 0.018])
    tip = 1e-3 * np.transpose(data(plan, "wire released"))[-1]
    assert np.hypot(*(tip + drawn["bar, simulated"])) == pytest.approx(
        Tool().bar_reach, abs=1e-9
    )  # m; 1e-6 of the turn
    (left, right), (bottom, top) = plan.get_xlim(), plan.get_ylim()
    for horizontal, vertical in drawn.values():
        assert left < -1e3 * horizontal < right
        assert bottom < -1e3 * vertical < top
