"""The constant C of (4.45) for the measured depth: closed form, root finding, and what Merchant's circle says of it."""

import dataclasses
import math

import numpy as np
import pytest

from bristle_sim.parameters.experiments import Crater
from bristle_sim.studies.crater_sums import (
    FRICTIONS,
    IMPACT_ANGLES_DEG,
    constant_row,
    constants_over,
)
from bristle_sim.theory.crater import constant_for_crater_depth, merchant_crater_depth
from bristle_sim.theory.merchant import oblique_angles

GAMMA = math.radians(23.4)
MEASURED = 1.3e-4


def changed(**changes):
    return dataclasses.replace(Crater(), **changes)


@pytest.mark.parametrize("friction", [0.5, 1.0, 4.0])
@pytest.mark.parametrize("part", [0.1, 0.6, 1.0])
def test_the_circle_with_that_constant_cuts_that_depth(friction, part):
    """Merchant's circle is built with C, by its angles, and its depth gives C back."""
    x = math.atan(1.0 / friction) - 0.2
    constant = x + part * (0.5 * math.pi - x)
    angles = dataclasses.replace(oblique_angles(friction, 0.2, check=False), shear=0.5 * (constant - x))
    depth = merchant_crater_depth(friction, 0.2, angles=angles)
    # arcsin near 1 takes the root of rounding.
    assert constant_for_crater_depth(depth, friction, 0.2) == pytest.approx(constant, rel=3e-8)


def test_by_hand_at_the_operating_point():
    """depth = K [sin C - sin x]/2, and 139.40 um at C = 90 deg fix K = 781.5 um: sin C = 0.6432 + 260/781.5."""
    x = math.atan(2.0) - GAMMA
    scale = 2.0 * 139.403e-6 / (1.0 - math.sin(x))
    by_hand = math.degrees(math.asin(math.sin(x) + 2.0 * MEASURED / scale))
    # 139.403 has six digits; C moves by 1/cos(77.4 deg) = 4.6 times as much.
    assert constant_row(Crater(), MEASURED).theory == pytest.approx(by_hand, abs=0.001)


@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("angle", IMPACT_ANGLES_DEG)
def test_closed_form_and_root_agree(friction, angle):
    row = constant_row(changed(friction=friction, impact_angle_deg=angle, plies=50.0), MEASURED)
    assert (row.simulated is None) == (row.theory is None)
    if row.theory is not None:
        assert row.ok is True
        assert row.tolerance < 1e-6


def test_no_constant_makes_a_crater_deeper_than_least_work():
    deepest = float(merchant_crater_depth())
    assert constant_for_crater_depth(deepest) == pytest.approx(math.pi / 2, abs=1e-7)
    row = constant_row(Crater(), 1.001 * deepest)
    assert (row.simulated, row.theory, row.ok) == (None, None, None)
    for depth in (1.001 * deepest, 0.0, -1e-5, math.nan):
        with pytest.raises(ValueError, match=r"^depth = "):
            constant_for_crater_depth(depth)


def test_the_chip_ends_where_the_shear_plane_stays_below():
    """eta = gamma at C = arccot(mu) + gamma: K sin(gamma) cos(arccot mu) is the shallowest crater with a chip."""
    angles = dataclasses.replace(oblique_angles(0.5, GAMMA), shear=GAMMA)
    shallowest = float(merchant_crater_depth(0.5, GAMMA, angles=angles))
    for depth, emerges in ((MEASURED, False), (0.9999 * shallowest, False), (1.0001 * shallowest, True)):
        (row,) = constants_over(Crater(), depth, (0.5,), (23.4,))
        assert row["shear_plane_emerges"] is emerges


def test_over_friction_and_angle():
    table = constants_over(Crater(), MEASURED)
    assert len(table) == len(FRICTIONS) * len(IMPACT_ANGLES_DEG)
    for angle in IMPACT_ANGLES_DEG:
        constants = [each["constant_deg"] for each in table if each["impact_angle_deg"] == angle]
        known = np.array([each for each in constants if each is not None])
        # More friction makes a deeper crater at the same C, so less C will do; no one C serves all.
        assert np.all(np.diff(known) < 0.0)
        assert known[0] > 2.0 * known[-1]
    for each in table:
        if each["constant_deg"] is not None:
            assert each["shear_plane_emerges"] is (each["shear_angle_deg"] >= each["impact_angle_deg"])
