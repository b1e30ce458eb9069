"""Chapter 4 reckoned twice, its limits, and the craters that follow from a contact in the scene."""

import dataclasses
import math
from itertools import pairwise

import pytest

from bristle_sim.dissertation.crater_figures import merchant_sum
from bristle_sim.parameters import Bristle, Crater, Hub
from bristle_sim.settings import Settings
from bristle_sim.studies.crater_study import MEASURED, crater_study
from bristle_sim.theory.crater import merchant_crater_depth

GAMMA = math.radians(23.4)


def study(**changes):
    return crater_study(Hub(), Bristle(), dataclasses.replace(Crater(), **changes), Settings())


def row(found, name):
    return next(each for each in found.quantities if each.name == name)


def force(t):
    """(3.19), N."""
    return (
        1.016 * math.exp(-5.499 * t) * (26.0 - 30.0 * math.cos(2.0 * math.pi * (t + 1e-5) / 1.2e-4))
    )


def width(t):
    """(4.16), m."""
    return 2.0 * math.sqrt(3.55e-4**2 - (1.39e-4 + 2.16e-4 * math.exp(-92400.0 * t)) ** 2)


def ratio(friction, gamma):
    """sin(eta) cos(eta + beta - alpha) cos(gamma) at the shear angle of least work, by a product of cosines."""
    return 0.5 * (1.0 - math.sin(math.atan2(1.0, friction) - gamma)) * math.cos(gamma)


@pytest.mark.parametrize("plies", [1, 3, 50])
@pytest.mark.parametrize(("friction", "angle"), [(0.5, 23.4), (1.0, 10.0), (4.0, 40.0)])
def test_the_printed_sum_ply_by_ply(plies, friction, angle):
    crater = Crater(friction=friction, impact_angle_deg=angle, plies=plies)
    times = [5e-5 * i / plies for i in range(plies + 1)]
    growth = [(force(b) - force(a)) / width(b) for a, b in pairwise(times)]
    expected = ratio(friction, math.radians(angle)) / 1.2e8 * sum(growth)
    # Rounding of differences of forces; cos(beta - alpha) is divided out and multiplied in again.
    assert merchant_sum(crater) == pytest.approx(expected, rel=1e-11)
    cut = {"friction": friction, "impact_angle": math.radians(angle), "plies": plies}
    assert merchant_crater_depth(**cut) == pytest.approx(expected, rel=1e-11)


def test_everything_agrees_at_the_operating_point():
    found = study()
    assert [each.name for each in found.quantities if each.ok is False] == []
    assert row(found, "merchant_crater_depth").printed == 1.4e-4
    # 130 µm were measured; no number of that kind is printed for the contact.
    assert row(found, "contact_energy_depth").printed is None
    assert MEASURED == 1.3e-4
    assert found.answer == (
        "The simulated contact cuts 104 µm to 172 µm and Merchant's plies cut 139 µm (printed 140 µm); measured are 130 µm."
        " Work and energy give 9.65 mm, the ratio of sums printed in their place (eq. 4.66) 75.8 µm."
    )
    assert found.extra["measured_crater_depth"] == 1.3e-4


@pytest.mark.parametrize(("friction", "angle"), [(0.31, 23.4), (0.4, 23.4), (0.5, 30.0)])
def test_without_a_chip_there_is_no_merchant_depth(friction, angle):
    found = study(friction=friction, impact_angle_deg=angle)
    for name in (
        "merchant_crater_depth",
        "merchant_crater_depth_limit",
        "contact_energy_depth",
        "contact_force_depth",
    ):
        assert (row(found, name).simulated, row(found, name).theory, row(found, name).ok) == (
            None,
            None,
            None,
        )
    line = next(line for line in found.remarks if line.startswith("no chip"))
    assert f"friction = {friction:g}" in line
    assert f"{math.tan(math.radians(angle)):g}" in line
    assert row(found, "contact_energy_depth_inclined").simulated > 0.0
    assert "Merchant's plies cut no chip;" in found.answer


def test_a_contact_that_cannot_be_simulated_is_missing_or_refused():
    found = crater_study(Hub(speed=0.0), Bristle(), Crater(), Settings())
    assert found.outcome == "no contact"
    assert row(found, "merchant_crater_depth").theory == pytest.approx(1.394e-4, abs=5e-9)
    assert "No contact is simulated (speed_ratio: must let the tip strike" in found.answer
    with pytest.raises(ValueError, match=r"compression_time.*: must be shorter"):
        crater_study(Hub(speed=1e6), Bristle(), Crater(), Settings())
