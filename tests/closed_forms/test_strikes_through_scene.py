"""The energetic law acting through the pymunk scene equals the closed forms, for parameters drawn at random.

The closed forms are the dissertation's own, written independently of the general law; what is compared is what comes
back from the engine's bodies. 1e-9 leaves room for the conditioning of K and nothing for physics. Draws closer than 1e-3
to a jam are left out here: there the result magnifies rounding without bound, which the hard cases look at.
"""

import math

import numpy as np
import pymunk
import pytest

from bristle_sim.contact_space.impulse import contact_space
from bristle_sim.contact_space.joints import joined
from bristle_sim.parameters import (
    Bristle,
    Contact,
    DoublePendulum,
    Hub,
    SinglePendulum,
    Strike,
    Surface,
)
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.impacts import double_pendulum, oblique_impact, single_pendulum
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.theory.monofilament import monofilament_impact

TOLERANCE = 1e-9
DRAWS = 1500


def close(found: float, expected: float, scale: float) -> bool:
    return abs(found - expected) <= TOLERANCE * max(abs(expected), scale)


def test_radial_bristle() -> None:
    rng = np.random.default_rng(20)
    rebounds = 0
    for _ in range(DRAWS):
        gamma = rng.uniform(0.02, 1.55)
        friction = rng.uniform(0.0, 1.5)
        e = rng.uniform(0.0, 1.0)
        later = rng.uniform(0.0, 1.5) if rng.random() < 0.5 else friction
        if abs(later / math.tan(gamma) - 1.0) < 1e-3:
            continue
        mass = 10.0 ** rng.uniform(-8, 2)
        length = 10.0 ** rng.uniform(-4, 1)
        radius = rng.uniform(0.0, 3.0) * length
        speed = 10.0 ** rng.uniform(-1, 4)
        ratio = rng.uniform(0.1, 20.0)
        chain = Chain((mass,), (length,), (-gamma,), (ratio * speed,), radius, speed, -gamma)
        found = strike(chain, Surface(friction, later, e), Contact(), Settings()).contact
        theory = monofilament_impact(mass, length, radius, speed, ratio, gamma, friction, e, later)
        assert found.outcome == theory.outcome_name
        rebounds += found.outcome == "rebound"
        impulse = theory.normal_compressive_impulse
        assert found.compressive_impulse is not None
        assert close(found.compressive_impulse[0], impulse, 0.0)
        assert close(found.compressive_impulse[1], theory.tangential_compressive_impulse, impulse)
        assert close(found.impulse[0], theory.normal_final_impulse, impulse)
        assert close(found.rates_after[0], theory.final_bristle_rate, ratio * speed)
    assert DRAWS / 4 < rebounds < DRAWS


PAIR = (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2)


@pytest.mark.parametrize(
    ("ratio", "motion", "surface"),
    [
        *(
            (ratio, PAIR, Surface(mu, None, 0.5))
            for ratio in (1.0, 10.0, 1e4)
            for mu in (0.0, 0.3, 0.5, 0.7)
        ),
        (1.0, PAIR, Surface(0.3, 0.1, 0.5)),
        # They come straight down: slip begins as K drives it, or friction sticks.
        *((1.0, ((-0.5, 0.5), (1.0, -1.0)), Surface(mu, None, 0.5)) for mu in (0.0, 0.1, 0.9)),
    ],
)
def test_compliant_contact_tends_to_the_law(ratio: float, motion: tuple, surface: Surface) -> None:
    """With 1e-4 and 1e-6 requested, a contact resolved in time comes within ten times that of its rigid-body limit: its
    duration is a tenth of the accuracy over the fastest rate, and rates change by about that much meanwhile."""
    chain = Chain((ratio, 1.0), (1.0, 1.0), *motion)
    limit = strike(chain, surface, Contact(), Settings()).contact
    for accuracy in (1e-4, 1e-6):
        found = strike(chain, surface, Contact("compliant"), Settings(accuracy=accuracy)).contact
        assert found.outcome == limit.outcome
        assert found.phases == limit.phases
        assert found.rates_after == pytest.approx(limit.rates_after, rel=10.0 * accuracy)
        assert found.impulse == pytest.approx(limit.impulse, rel=10.0 * accuracy, abs=1e-10)


@pytest.mark.parametrize("restitution", [1e-6, 1.93e-9, 3e-11, 1e-12, 1e-14, 1e-100])
@pytest.mark.parametrize("friction", [0.0, 0.3, 0.5])
def test_pendulums_agree_with_theory_however_small_the_restitution(
    restitution: float, friction: float
) -> None:
    """A rate after the impact has the rounding of the one before: 1e-15/e* of itself."""
    surface = Surface(friction, None, restitution)
    for report in (
        single_pendulum(SinglePendulum(), surface, Contact(), Settings()),
        double_pendulum(DoublePendulum(), surface, Contact(), Settings()),
    ):
        assert all(row.ok for row in report.quantities), report.quantities


@pytest.mark.parametrize("slip", [0.0, 1e-11, -0.3])
def test_a_hinged_rod_met_on_its_axis_cannot_slip_by_an_impulse(slip: float) -> None:
    """It turns at right angles to its axis only: K_tt = K_nt = 0, p = (1 + e) v / K_nn, and no jam, at any angle and rounding."""
    for angle in np.linspace(-3.0, 3.0, 101).tolist():
        space = pymunk.Space()
        rod = pymunk.Body(1.0, 1.0 / 12.0)
        x, y = math.cos(angle), math.sin(angle)
        rod.position = (0.5 * x, 0.5 * y)
        rod.angle = angle
        rod.velocity = (0.5 * y, -0.5 * x)
        rod.angular_velocity = -1.0
        space.add(rod, pymunk.PivotJoint(space.static_body, rod, (0.0, 0.0), (-0.5, 0.0)))
        along = complex(x, y)
        found = contact_space(
            [rod], 0.9 * along, 1j * along, joined([rod]), surface_velocity=-slip * along
        )
        assert found.velocity == pytest.approx((-0.9, slip), abs=1e-15)
        impact = energetic_impact(
            found.inverse_mass, found.velocity, 0.3, 0.5, stick_compliance=found.stick_compliance
        )
        assert impact.outcome_name == "rebound"
        assert impact.impulse_normal == pytest.approx(1.5 * 0.9 / (3.0 * 0.9**2), rel=1e-12)


def test_a_tangential_work_that_is_rounding_agrees() -> None:
    """A wire along the surface has no velocity along it: W_x = 0."""
    report = oblique_impact(
        Hub(), Bristle(), Strike(impact_angle_deg=90.0), Surface(), Contact(), Settings()
    )
    assert all(row.ok for row in report.quantities), report.quantities


@pytest.mark.parametrize("degrees", [90.0, 89.9999, 89.998, 89.9])
def test_a_slide_by_the_turn_in_a_contact_in_time_is_not_compared(degrees: float) -> None:
    """Beside the surface the tip slides by the wire's turn in the contact alone, and back: theory has no turn."""
    report = oblique_impact(
        Hub(),
        Bristle(),
        Strike(impact_angle_deg=degrees),
        Surface(),
        Contact("compliant"),
        Settings(),
    )
    judged = {row.name: row.ok for row in report.quantities}
    compared = degrees < 89.99
    assert judged.pop("tangential_compressive_impulse") is (True if compared else None)
    assert judged.pop("tangential_compressive_work") is (True if compared else None)
    assert all(judged.values()), report.quantities


@pytest.mark.parametrize("degrees", [-89.99, -89.9998, -89.99982, -89.99983])
def test_an_approach_that_two_rates_nearly_cancel_agrees(degrees: float) -> None:
    """Both rods move their ends at 0.1 m/s, away and near; the difference has the rounding of either."""
    pendulum = DoublePendulum(angle_1_deg=degrees)
    report = double_pendulum(pendulum, Surface(0.5, 0.5), Contact(), Settings())
    assert all(row.ok for row in report.quantities), report.quantities


def test_a_rate_with_too_few_digits_is_refused() -> None:
    with pytest.raises(
        ValueError, match=r"rate before the impact = 4\.94e-324: must be 0 or at least 1e-300"
    ):
        single_pendulum(SinglePendulum(rate=-5e-324), Surface(), Contact(), Settings())


def test_a_bristle_at_rest_on_a_turning_hub_has_no_rebound_ratio() -> None:
    """Its root moves, so its tip strikes; only a ratio to the rate 0 has no value."""
    report = oblique_impact(
        Hub(), Bristle(), Strike(speed_ratio=0.0), Surface(), Contact(), Settings()
    )
    judged = {row.name: row.ok for row in report.quantities}
    assert judged.pop("rebound_ratio") is None
    assert all(judged.values()), report.quantities


def test_a_rod_that_stays_has_the_rate_zero():
    """mu > tan(gamma): the rate after the impact is 0, neither rounding error nor -0."""
    report = single_pendulum(
        SinglePendulum(impact_angle_deg=10.0), Surface(friction=1.0), Contact(), Settings()
    )
    assert str(report.quantities[0].simulated) == "0.0"
    assert "turns at 0 rad/s" in report.answer
