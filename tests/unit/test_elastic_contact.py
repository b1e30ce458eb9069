"""A contact that is elastic along the surface: in time, against the impact law that it tends to, and against balances."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from bristle_sim.parameters import Bristle, Contact, Hub, Strike, Surface, Tool
from bristle_sim.render.impact_pictures import impact_figure
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import Chain, build_strike, strike
from bristle_sim.settings import Settings
from bristle_sim.studies.impacts import oblique_impact
from bristle_sim.trajectory import Trajectory

GAMMA = math.radians(23.4)
BRISTLE = Chain((8.387e-5,), (0.027,), (-GAMMA,), (845.6,), 0.0275, 261.8, -GAMMA)
ROD = Chain(
    (6.3,), (1.0,), (-0.575,), (0.856,)
)  # on a hub at rest: all of it stands still where slip stops
PAIR = Chain((1.0, 1.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))
ACCURACY = 1e-7


def thrown(tool: Tool, accuracy: float) -> Trajectory:
    """A wire that is let go 0.7 rad behind the hub, up to the end of its strike."""
    return simulate(
        tool,
        Settings(accuracy=accuracy, hub_turn=1.6, maximum_steps=100_000),
        start_hub_angle=-GAMMA - 0.21,
        start_relative_angle=-0.7,
        start_relative_rate=877.0,
        stop_after="workpart release",
    )


def struck(chain: Chain, surface: Surface, contact: Contact) -> np.ndarray:
    """Rates after the strike, over the fastest before."""
    rates = strike(chain, surface, contact, Settings(accuracy=ACCURACY)).contact.rates_after
    return np.array(rates) / max(map(abs, chain.rates))


@pytest.mark.parametrize("squared", [0.01, 1.21, 1e4])
@pytest.mark.parametrize("restitution", [0.0, 0.42, 1.0])
@pytest.mark.parametrize(
    ("chain", "mu", "later"), [(BRISTLE, 0.31, None), (PAIR, 0.3, 0.6), (PAIR, 0.7, 0.2)]
)
def test_a_shorter_contact_tends_to_the_law(
    chain: Chain, mu: float, later: float | None, restitution: float, squared: float
) -> None:
    """A tenth of the duration leaves a tenth of the difference, but for its square; the shortest one the accuracy's size."""
    surface = Surface(mu, later, restitution)
    unit = 1.0 / max(map(abs, chain.rates))
    law = struck(chain, surface, Contact(tangential_compliance=squared))
    first, second = (
        np.abs(struck(chain, surface, Contact("compliant", duration * unit, squared)) - law).max()
        for duration in (1e-3, 1e-4)
    )
    assert second < 1e-3
    assert first / second == pytest.approx(10.0, rel=0.05)
    assert np.abs(struck(chain, surface, Contact("compliant", None, squared)) - law).max() < 1e-5


@pytest.mark.parametrize(("chain", "mu", "squared"), [(BRISTLE, 0.2, 1.21), (ROD, 0.487, 0.01)])
def test_rounding_does_not_decide_what_ends_together(
    chain: Chain, mu: float, squared: float
) -> None:
    """Slip and approach of one degree of freedom end at one instant; the start's last digits change the order they are found in."""
    surface = Surface(mu, None, 1.0)
    law = struck(chain, surface, Contact(tangential_compliance=squared))
    for digits in range(-12, 13):
        start = dataclasses.replace(chain, angles=(chain.angles[0] + digits * 1e-15,))
        assert struck(start, surface, Contact("compliant", None, squared)) == pytest.approx(
            law, abs=1e-5
        )


@pytest.mark.parametrize("restitution", [0.99, 0.999, 1.0])
@pytest.mark.parametrize("degrees", [40.0, 60.0])
def test_the_foot_of_a_rod_on_a_turning_hub_stops_with_compression(
    degrees: float, restitution: float
) -> None:
    """Within the rounding of the shortest contact stick and slip would follow each other for ever."""
    angle = -math.radians(degrees)
    chain = Chain((1.0,), (1.0,), (angle,), (1.0,), 1.0, 0.3, angle)
    surface = Surface(0.3, None, restitution)
    law = struck(chain, surface, Contact(tangential_compliance=1.2))
    assert np.abs(struck(chain, surface, Contact("compliant", None, 1.2)) - law).max() < 1e-5


def test_compression_that_a_swing_along_the_surface_ends() -> None:
    """The first swing after slip carries the tip of two rods out of compression and would carry it back in."""
    chain = Chain((0.564, 1.395), (1.0, 1.0), (-0.283, -0.266), (0.56, 0.792))
    surface = Surface(0.711, 0.24, 1.0)
    law = struck(chain, surface, Contact(tangential_compliance=0.01))
    assert struck(chain, surface, Contact("compliant", None, 0.01)) == pytest.approx(law, abs=1e-5)


def test_a_short_excursion_beyond_the_cone_is_not_missed() -> None:
    """The force in stick of two rods leaves the cone and comes back within an interval: within the angle turned meanwhile, 1e-5."""
    chain = Chain((2.281, 0.911), (1.0, 1.0), (0.865, -0.201), (-1.44, 1.049))
    surface = Surface(0.455, None, 1.0)
    law = struck(chain, surface, Contact(tangential_compliance=0.00501))
    assert struck(chain, surface, Contact("compliant", 1e-5 / 1.44, 0.00501)) == pytest.approx(
        law, abs=1e-5
    )


@pytest.mark.parametrize("squared", [0.05, 1.21])
def test_a_foot_that_stops_stands_while_the_wire_bends(squared: float) -> None:
    """Where the foot's velocity falls through zero the force turns back from the cone's edge, whatever accelerates the tip."""
    contact = Contact("compliant", 2e-4, squared)
    found = thrown(Tool(bristle=Bristle(links=4), bar=None, contact=contact), 1e-5)
    assert found.stop_reason == "requested event"


def test_a_frictionless_tip_swings_along_the_surface() -> None:
    """Its slip turns round in compression; the law knows one phase. Within ten times the angle turned meanwhile, 1e-4."""
    chain = Chain((2.0, 1.0), (1.0, 1.0), (-0.6, 0.4), (1.0, -0.3))
    surface = Surface(0.0, 0.2, 0.3)
    (law_impulse, law_rates), (impulse, rates) = (
        (found.impulse, found.rates_after)
        for found in (
            strike(chain, surface, each, Settings(accuracy=ACCURACY)).contact
            for each in (Contact(tangential_compliance=0.01), Contact("compliant", 1e-4, 0.01))
        )
    )
    assert rates == pytest.approx(law_rates, abs=1e-3)
    assert impulse == pytest.approx(law_impulse, abs=1e-3)


def test_the_error_that_the_shortest_contact_leaves_is_estimated() -> None:
    """Its difference from the impact law, which is more than the accuracy; rates are some times the motion's unit, 20 at most."""
    squared = 1.21
    accuracy = 1e-8
    tool = Tool(bar=None, contact=Contact(tangential_compliance=squared))
    law = thrown(tool, accuracy)
    found = thrown(tool.replace(contact=Contact("compliant", None, squared)), accuracy)
    after, expected = (
        np.array(each.first_contact("workpart").rates_after) for each in (found, law)
    )
    difference = np.abs(after - expected).max() / np.abs(expected).max()
    assert difference > accuracy
    assert found.cost.error_estimate is not None
    assert difference < 20.0 * found.cost.error_estimate < 400.0 * difference


def test_the_oblique_strike_is_as_it_was_predicted() -> None:
    """By hand for one degree of freedom, eta^2 = 1.21: 1.750 mN s and a rebound ratio of -0.858 instead of -0.540."""
    for contact in (Contact(tangential_compliance=1.21), Contact("compliant", None, 1.21)):
        found = strike(BRISTLE, Surface(0.31, None, 0.42), contact, Settings()).contact
        assert found.impulse[0] == pytest.approx(1.750e-3, abs=5e-7)
        assert found.rates_after[0] / 845.6 == pytest.approx(-0.858, abs=5e-4)


@pytest.mark.parametrize("squared", [1e-3, 0.3, 5.0])
def test_force_stays_in_the_cone_and_energy_does_not_grow(squared: float) -> None:
    """The force in stick is linear in the place along the surface, T = -(k/eta^2)(x - x_foot)."""
    surface = Surface(0.5, None, 0.8)
    found = strike(PAIR, surface, Contact("compliant", 1e-3, squared), Settings())
    history = found.contact.history
    assert history is not None
    bound = 0.5 * history.normal_force
    assert (np.abs(history.tangential_force) <= bound + 1e-9 * bound.max()).all()
    assert found.kinetic_energy_ratio is not None
    assert found.kinetic_energy_ratio < 1.0


@pytest.mark.parametrize("squared", [0.0, 0.5e-4])
def test_no_compliance_no_spring_along_the_surface(squared: float) -> None:
    """Below 1e-4 the law is that of a rigid surface, and so is the contact in time, bit for bit."""
    scene, state, obstacle, _ = build_strike(PAIR, Surface(0.3, None, 0.5))
    law = CompliantLaw(1e-3, ACCURACY, tangential_compliance=squared)
    spring = law.spring(scene, state, obstacle)
    assert spring is not None
    assert not spring.elastic
    rigid = struck(PAIR, Surface(0.3, None, 0.5), Contact("compliant", 1e-2))
    assert (
        struck(PAIR, Surface(0.3, None, 0.5), Contact("compliant", 1e-2, squared)) == rigid
    ).all()


def test_the_engine_knows_no_such_contact() -> None:
    with pytest.raises(
        ValueError, match=r"^tangential_compliance = 1: must be 0 with contact = engine"
    ):
        Contact("engine", tangential_compliance=1.0)


def test_an_elastic_strike_is_not_judged_by_formulas_of_a_rigid_surface() -> None:
    """Print, answer and picture say which contact each number and line is of."""
    report = oblique_impact(
        Hub(), Bristle(), Strike(), Surface(), Contact(tangential_compliance=1.21), Settings()
    )
    assert "rigid along the surface" in report.answer
    assert "by formula" not in report.answer
    assert {row.ok for row in report.quantities} == {None}
    (axes,) = impact_figure(report.subject).axes
    assert "rigid along the surface" in axes.get_title(loc="left")
