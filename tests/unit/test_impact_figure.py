"""Pictures of impacts show what was computed, and never what is not there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from bristle_sim.render.impact_figure import impact_figure
from bristle_sim.render.style import save_figure
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.impulse_course import energetic_course
from impact_cases import TRAPEZOIDAL, data, panel, rods, words


@pytest.fixture(scope="module")
def strike_figure(strike: Impacts) -> Figure:
    return impact_figure(strike)


def test_impulse_plane_shows_the_course_and_the_contact_resolved_in_time(
    strike: Impacts, strike_figure: Figure
) -> None:
    plane = panel(strike_figure, "a")
    course = energetic_course(strike.chain, strike.surface)
    assert "mN·s" in plane.get_xlabel()
    for name in ("normal_velocity", "tangential_velocity"):
        x, y = data(plane, name)
        np.testing.assert_allclose(x, course.impulse * 1e3)
        np.testing.assert_allclose(y, getattr(course, name))
        x, y = data(plane, f"{name}, resolved in time")
        assert x.size > 5
        np.testing.assert_allclose(
            y,
            np.interp(x, course.impulse * 1e3, getattr(course, name)),
            atol=3.0 * TRAPEZOIDAL * np.ptp(getattr(course, name)),
        )


def test_figures_of_what_does_not_happen_say_so(tmp_path: Path) -> None:
    resting = impact_figure(rods(rate_1=0.0, rate_2=0.0))
    assert "no contact" in words(panel(resting, "a"))
    save_figure(resting, tmp_path / "resting.png")
    unresolved = rods()
    del unresolved.strikes["compliant"]
    names = {each.get_gid() for each in panel(impact_figure(unresolved), "a").get_lines()}
    assert not any(name and "resolved" in name for name in names)
