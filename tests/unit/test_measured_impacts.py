"""Measured impacts: errors of the laws on the spheres of Kharaz et al., and on the ellipse where its file is at hand."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from bristle_sim.comparison import Report
from bristle_sim.parameters import Measured
from bristle_sim.studies.measured_impacts import elastic_compliance, measured_impacts, read_ellipse, spheres

FOLDER = os.environ.get("BRISTLE_MEASURED")
FILE = Path(FOLDER or ".") / "ellipse_uniform.mat"
measured = pytest.mark.skipif(FOLDER is None, reason="BRISTLE_MEASURED names no folder with ellipse_uniform.mat")


def values(report: Report) -> dict[str, float]:
    return {each.name: each.simulated for each in report.quantities if each.simulated is not None}


@pytest.mark.parametrize(
    ("squared", "most"), [(1.15, (0.045, 27.0, 0.47)), (1.21, (0.03, 26.0, 0.45)), (0.0, (0.055, 74.0, 1.2))]
)
def test_spheres(squared: float, most: tuple[float, float, float]) -> None:
    """Nothing is fitted: the limits are the resolution of points that were read off figures."""
    found = spheres(squared).errors
    assert np.all(np.array([found["restitution"], found["spin"], found["rebound_angle"]]) <= most)


def test_ratio_of_stiffnesses() -> None:
    """(2 - nu)/(2 (1 - nu)) at nu = 0: 1; at nu = 0.5, rubber: 1.5."""
    assert (elastic_compliance(0.0), elastic_compliance(0.5)) == (1.0, 1.5)


def test_what_is_no_file_of_impacts_is_refused_in_one_line(tmp_path: Path) -> None:
    other = tmp_path / "other.mat"
    other.write_bytes(b"no matrix")
    for path in (other, tmp_path / "none.mat"):
        with pytest.raises(ValueError, match=r"^data = ") as refusal:
            read_ellipse(str(path))
        assert "\n" not in str(refusal.value)


@measured
def test_the_arms_are_those_of_the_file_but_for_the_sense_of_the_tangential_one() -> None:
    """The file gives them to fractions of a millimetre; the angle runs clockwise."""
    from scipy.io import loadmat

    ellipse = read_ellipse(str(FILE))
    bounces = [
        each for each in loadmat(FILE, squeeze_me=True, struct_as_record=False)["bounce_array"] if not each.flags.any()
    ]
    normal, tangential = np.array([each.n[2] for each in bounces]), np.array([each.d[2] for each in bounces])
    assert np.median(np.abs(ellipse.jacobian[:, 0, 2] - normal)) < 3e-4
    assert np.median(np.abs(ellipse.jacobian[:, 1, 2] + tangential)) < 3e-4


@measured
def test_ellipse() -> None:
    """The energetic law leaves at most 0.17 of the velocity after impacts that it was not fitted on, the best impulse 0.044."""
    report = measured_impacts(Measured(data=str(FILE)))
    found = values(report)
    assert found["impacts"] == 1718
    assert found["energetic_error"] <= 0.17
    assert found["best_impulse_error"] == pytest.approx(0.0435, abs=0.001)
    for law in ("poisson", "newton"):
        assert found[f"{law}_error"] == pytest.approx(found["energetic_error"], abs=0.002)
    # A second way to the fit: 0.186 and 0.542 by another optimiser.
    assert found["friction"] == pytest.approx(0.187, abs=0.004)
    assert found["restitution"] == pytest.approx(0.54, abs=0.01)
