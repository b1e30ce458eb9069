"""Measured impacts: errors of the laws on the spheres of Kharaz et al., and on the ellipse where its file is at hand."""

from __future__ import annotations

import math
import os
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pymunk
import pytest

from bristle_sim.comparison import Report
from bristle_sim.contact_space.energetic_contact import EnergeticContact
from bristle_sim.parameters import Measured
from bristle_sim.studies.measured_impacts import (
    GYRATION,
    HALF_AXES,
    INERTIA,
    MASS,
    measured_impacts,
    read_ellipse,
    spheres,
)
from bristle_sim.theory.impact import energetic_impact

FOLDER = os.environ.get("BRISTLE_MEASURED")
FILE = Path(FOLDER or ".") / "ellipse_uniform.mat"
measured = pytest.mark.skipif(
    FOLDER is None, reason="BRISTLE_MEASURED names no folder with ellipse_uniform.mat"
)


def bounces() -> list[Any]:
    """Return the file's impacts whose flags are all 0."""
    from scipy.io import loadmat

    found = loadmat(FILE, squeeze_me=True, struct_as_record=False)["bounce_array"]
    return [each for each in found if not each.flags.any()]


def values(report: Report) -> dict[str, float]:
    return {each.name: each.simulated for each in report.quantities if each.simulated is not None}


@pytest.mark.parametrize(
    ("squared", "most"),
    [(1.15, (0.045, 27.0, 0.47)), (1.21, (0.03, 26.0, 0.45)), (0.0, (0.055, 74.0, 1.2))],
)
def test_spheres(squared: float, most: tuple[float, float, float]) -> None:
    """Nothing is fitted: the limits are the resolution of points that were read off figures."""
    found = spheres(squared)
    assert np.all(np.array([found["restitution"], found["spin"], found["rebound_angle"]]) <= most)


@pytest.mark.parametrize("states", [np.zeros((3, 12)), np.full((4, 12), math.nan)])
def test_few_impacts_or_gaps_are_refused(tmp_path: Path, states: np.ndarray) -> None:
    from scipy.io import savemat

    path = tmp_path / "bounces.mat"
    savemat(path, {"bounce_array": [{"states": each, "flags": np.zeros(2)} for each in states]})
    with pytest.raises(ValueError, match="must hold at least four impacts of finite numbers"):
        read_ellipse(str(path))


@pytest.mark.parametrize(("place", "bit"), [(289, 3), (298, 0), (316, 0), (320, 7), (163, 3)])
def test_a_damaged_file_is_refused(tmp_path: Path, place: int, bit: int) -> None:
    """With the first of these SciPy's reader ends its process by a segmentation fault."""
    from scipy.io import savemat

    path = tmp_path / "bounces.mat"
    savemat(
        path,
        {"bounce_array": [{"states": np.arange(12.0) + i, "flags": np.zeros(2)} for i in range(5)]},
    )
    damaged = bytearray(path.read_bytes())
    damaged[place] ^= 1 << bit
    path.write_bytes(damaged)
    with pytest.raises(
        ValueError, match="must be a MATLAB file with an array bounce_array of states and flags"
    ):
        read_ellipse(str(path))


@measured
def test_the_arms_are_those_of_the_file_but_for_the_sense_of_the_tangential_one() -> None:
    """The file gives them to fractions of a millimetre; the angle runs clockwise."""
    ellipse = read_ellipse(str(FILE))
    normal, tangential = np.array([(each.n[2], each.d[2]) for each in bounces()]).T
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


def through_a_space(
    state: np.ndarray, friction: float, restitution: float, compliance: float
) -> np.ndarray:
    """Velocities (x, y, clockwise turn) after an impact on a floor, in a pymunk space, from a state of the file.

    The ellipse at its angle touches the floor with its support point, where a small circle stands for its surface. It overlaps
    the floor by 1e-12 m, half of which is missing from arms of some 3e-2 m.
    """
    x, y, clockwise = state[:3]
    space = pymunk.Space()
    body = pymunk.Body(MASS, MASS * GYRATION**2)
    body.position = (x, y)
    body.angle = -clockwise
    body.velocity = tuple(state[3:5].tolist())
    body.angular_velocity = -state[5]
    down = np.array([math.sin(clockwise), -math.cos(clockwise)])  # in the body's axes
    lowest = np.square(HALF_AXES) * down / math.hypot(*(HALF_AXES * down))
    circle = pymunk.Circle(body, 1e-3, tuple((lowest - 1e-3 * down).tolist()))
    level = y - float(lowest @ down) + 1e-12
    floor = pymunk.Segment(space.static_body, (x - 1.0, level - 1.0), (x + 1.0, level - 1.0), 1.0)
    circle.collision_type = 1
    floor.collision_type = 2
    space.add(body, circle, floor)
    given = {"friction": friction, "restitution": restitution, "tangential_compliance": compliance}
    EnergeticContact(space, 1, 2, **given).step(1e-15)
    return np.array([*body.velocity, -body.angular_velocity])


@measured
@pytest.mark.parametrize("compliance", [0.0, 1.21])
def test_the_ellipses_impacts_through_a_space_are_those_of_the_law_in_arrays(
    compliance: float,
) -> None:
    """From the state before to the state after: within 1e-9 of the velocity before, in the norm of the kinetic energy.

    With a tangential spring every fifth impact is taken, as the law resolves thousands of phases there.
    """
    ellipse = read_ellipse(str(FILE))
    law = partial(energetic_impact, tangential_compliance=compliance)
    impulse = ellipse.predicted(law, 0.187, 0.54)
    wanted = ellipse.before + np.einsum("kij,ki->kj", ellipse.jacobian, impulse) / INERTIA
    taken = slice(None, None, 5 if compliance else 1)
    states = [bounce.states for bounce in bounces()][taken]
    after = np.array([through_a_space(state, 0.187, 0.54, compliance) for state in states])
    error = np.sqrt((after - wanted[taken]) ** 2 @ INERTIA / (ellipse.before[taken] ** 2 @ INERTIA))
    assert error.max() < 1e-9
