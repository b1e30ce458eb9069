"""The picture of a release: its cue times and the bars' places."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from bristle_sim.parameters import Bar, Tool
from bristle_sim.render.cue_figure import cue_figure
from bristle_sim.render.style import save_figure
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


def test_cue_figure_marks_both_cues_and_every_bar(release: CueTiming, tmp_path: Path) -> None:
    figure = cue_figure(release)
    retraction, speed, plan = (panel(figure, letter) for letter in "abc")
    inertia = 8.387e-5 * 0.027**2 / 3.0
    natural = math.sqrt(math.degrees(0.00041) / inertia)
    assert data(speed, "cue, quasi-static formula")[0][0] == pytest.approx(0.5e3 * math.pi / natural)
    assert data(speed, "highest, quasi-static formula")[1][0] == pytest.approx(math.radians(44.5) * natural)
    # From an integration of I alpha'' + k alpha + g sin alpha = 0, to the digits given.
    assert data(speed, "cue, simulated")[0][0] == pytest.approx(1.4052, abs=5e-5)
    assert data(speed, "highest, simulated")[1][0] == pytest.approx(869.1, abs=0.05)
    assert data(retraction, "retraction, simulated")[1][0] == pytest.approx(44.5)
    assert abs(data(retraction, "retraction, simulated")[1][-1]) < 1e-3
    assert set(bars(plan)) == {"bar as given", "bar, simulated", "bar, formula"}
    (table,) = figure.axes[-1].tables
    cells = {cell.get_text().get_text() for cell in table.get_celld().values()}
    # By integration, by A + omega t_c + gamma (2.1), and the finding of README: the lag as a pass strikes.
    assert {"66.56°", "59.97°", "67.43°", "114.33°", "1.97°", "2.74°", "no strike"} <= cells
    save_figure(figure, tmp_path / "cue.png")


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


def test_cue_figure_never_simulates(release: CueTiming, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("a figure must not simulate")

    for module in ("scene.tool", "studies.cue_timing", "studies.strike_point"):
        monkeypatch.setattr(f"bristle_sim.{module}.simulate", refuse)
    cue_figure(release)


def test_cue_figure_without_a_formula_or_a_cue(release: CueTiming) -> None:
    bare = dataclasses.replace(release, simulated=None, formula=None)
    figure = cue_figure(dataclasses.replace(bare, readings={"own": dataclasses.replace(bare, passes=bare.passes[:1])}))
    assert set(bars(panel(figure, "c"))) == {"bar as given"}
