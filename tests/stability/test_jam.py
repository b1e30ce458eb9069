"""Friction at the edge of the jam, and that the promises notice a program that is off there."""

import dataclasses
import decimal
import math
from decimal import Decimal
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases import jam
from bristle_sim.benchmarks.hard_cases.case import HardCase
from bristle_sim.benchmarks.hard_cases.jam import cases, critical_frictions
from bristle_sim.benchmarks.hard_cases.one_rod import rod_strike, sine_and_cosine
from bristle_sim.parameters import Contact, Surface, Tool, Workpart
from bristle_sim.scene import contact_laws
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.impulse_course import contact_inverse_mass
from bristle_sim.theory.impact import Impact, energetic_impact, stick_threshold
from bristle_sim.theory.pendulums import stick_friction

EPSILON = 2.0**-52


@pytest.mark.parametrize("case", cases(full=False), ids=lambda case: case.name)
def test_promise(case: HardCase) -> None:
    finding = case.measure()
    assert finding.ok, finding.reached


def named(start: str) -> HardCase:
    (found,) = (case for case in cases(full=False) if case.name == start)
    return found


@pytest.mark.parametrize("angle", [1e-30, 0.1, 1.0, math.pi / 2.0, -1.3, 3.0])
def test_sine_and_cosine(angle: float) -> None:
    with decimal.localcontext(prec=60):
        sine, cosine = sine_and_cosine(angle)
        assert abs(sine * sine + cosine * cosine - 1) < Decimal("1e-55")
        # Half a rounding of either, and that of the float.
        assert float(sine) == pytest.approx(math.sin(angle), rel=2 * EPSILON)
        assert float(cosine) == pytest.approx(math.cos(angle), rel=2 * EPSILON)


def test_cosine_next_to_a_right_angle() -> None:
    """cos(pi/2 as a float) is what it lacks of pi/2, up to the cube of that."""
    with decimal.localcontext(prec=60):
        _, cosine = sine_and_cosine(math.pi / 2.0)
        lacking = Decimal("1.57079632679489661923132169163975144209858469968755291") - Decimal(math.pi / 2.0)
        assert abs(cosine - lacking) < Decimal("1e-48")


def inverse_mass(mass: float, angle: float) -> np.ndarray:
    along = np.array([math.sin(angle), math.cos(angle)])
    return 3.0 / mass * np.outer(along, along)


@pytest.mark.parametrize("seed", range(20))
def test_one_rod_by_the_general_law(seed: int) -> None:
    """The closed form beside the law of any bodies, away from the jam; pulled along its line, pushed in any direction."""
    rng = np.random.default_rng(seed)
    mass, angle, e = 10.0 ** rng.uniform(-6, 3), rng.uniform(0.1, 1.4), rng.uniform(0.1, 1.0)
    mu = math.tan(angle) * rng.choice([rng.uniform(0.1, 0.8), rng.uniform(1.25, 10.0)])
    for at, velocity in ((-angle, (-math.sin(angle), math.cos(angle))), (angle, (-rng.uniform(0.1, 1.0), 1.0))):
        law = energetic_impact(inverse_mass(mass, at), velocity, mu, e)
        rod = rod_strike(mass, at, velocity, mu, e)
        assert law.outcome_name == rod.outcome
        # A hundred roundings: 16 over a distance of at least a fifth.
        assert rod.impulse == pytest.approx(law.impulse_normal, rel=100 * EPSILON)


@pytest.mark.parametrize("seed", range(10))
def test_any_rod_near_its_jam(seed: int) -> None:
    """Any angle, any distance, on hinge and hub: the same limits as the promise's."""
    rng = np.random.default_rng(100 + seed)
    angle, distance = rng.uniform(0.02, 1.55), 10.0 ** rng.uniform(-13.0, -2.0)
    rate, e = 10.0 ** rng.uniform(-2, 4), rng.uniform(0.05, 1.0)
    for mu in (math.tan(angle) * (1.0 - distance), math.tan(angle) * (1.0 + distance)):
        for chain in (
            Chain((2.0,), (0.3,), (-angle,), (rate,)),
            Chain((2.0,), (0.3,), (angle,), (0.0,), 0.3, rate, -0.9),
        ):
            hit = strike(chain, Surface(mu, None, e), Contact(), Settings()).contact
            rod = rod_strike(2.0, chain.angles[0], hit.velocity_before, mu, e)
            assert hit.outcome == rod.outcome
            # Roundings of the lever, and on a hub of the tip's place, over the distance of the jam.
            roundings = 16.0 + 2.0 * rod.arms
            assert hit.impulse[0] == pytest.approx(rod.impulse, rel=roundings * EPSILON * (1.0 + 1.0 / rod.distance))


def test_critical_frictions() -> None:
    """That of sticking is Zhang's mu_bar; at the other slip does not change the approach."""
    found = critical_frictions(jam.TWO_RODS)
    first, second = jam.TWO_RODS.angles
    # Ten roundings.
    assert found["sticks"] == pytest.approx(float(stick_friction(1.0, -first, -second)), rel=10 * EPSILON)
    assert found["sticks"] == pytest.approx(stick_threshold(contact_inverse_mass(jam.TWO_RODS)), rel=10 * EPSILON)
    surface = Surface(found["presses on"], None, 0.0)
    hit = strike(jam.TWO_RODS, surface, Contact(), Settings()).contact
    assert hit.phases == ("compression slip", "compression stick")
    lasting = strike(jam.TWO_RODS, Surface(0.5 * found["presses on"], None, 0.0), Contact(), Settings()).contact
    assert lasting.phases == ("compression slip",)


def test_pushed_rod_in_a_pass_jams_by_name() -> None:
    """Twice the friction of the jam stops the run: no motion obeys the law from there."""
    tool = dataclasses.replace(jam.LEANING, workpart=Workpart(penetration=0.0095, friction=2.0))
    run = simulate(tool, start_hub_angle=jam.START, start_relative_angle=jam.LEAN)
    assert run.stop_reason == "jam"
    assert [event.name for event in run.events][-1] == "jam"
    assert run.contacts[-1].outcome == "jam"


OFF = (
    ("rod pulled, friction 1e-09 off the jam", 1e-10),
    ("rod pushed, friction 1e-06 off the jam", 1e-12),
    ("two rods, 1e-06 off the friction that sticks", 1e-10),
    ("two rods, 1e-06 off the friction that presses on", 1e-10),
    ("pass, tip pushed, friction 0.001 off the jam", 1e-10),
    ("default pass, friction 0.001 off the jam", 1e-7),
)


@pytest.mark.parametrize(("name", "error"), OFF)
def test_a_law_with_a_wrong_friction_is_noticed(name: str, error: float, monkeypatch: pytest.MonkeyPatch) -> None:
    def off(inverse_mass: Any, velocity: Any, friction: float, e: float, later: float, *rest: Any) -> Impact:
        return energetic_impact(inverse_mass, velocity, friction * (1.0 + error), e, later * (1.0 + error), *rest)

    monkeypatch.setattr(contact_laws, "energetic_impact", off)
    assert not named(name).run().ok


@pytest.mark.parametrize(
    "name", ["rod pushed, friction 0.001 off the jam", "pass, tip pushed, friction 1e-12 off the jam"]
)
def test_a_jam_without_its_name_is_noticed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        contact_laws, "energetic_impact", lambda *given: dataclasses.replace(energetic_impact(*given), outcome=1)
    )
    assert not named(name).run().ok


def test_an_impulse_without_bound_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def endless(*given: Any) -> Impact:
        return dataclasses.replace(energetic_impact(*given), impulse_normal=math.inf)

    monkeypatch.setattr(contact_laws, "energetic_impact", endless)
    assert not named("rod pulled, friction at the jam, to rounding").run().ok
    assert not named("pass, tip pushed, friction at the jam, to rounding").run().ok


@pytest.mark.parametrize("error", [OverflowError("inf"), ValueError("two\nlines allowed"), ValueError("no word of it")])
def test_a_contact_in_time_that_ends_without_a_clear_word_is_noticed(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: Any) -> None:
        raise error

    monkeypatch.setattr(CompliantLaw, "resolve", fails)
    assert not named("rod in time, friction 1e-09 off the jam").run().ok


def test_a_refusal_where_the_jam_is_far_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuses(*_: Any) -> None:
        raise ValueError("contact: friction further from the jam is allowed")

    monkeypatch.setattr(CompliantLaw, "resolve", refuses)
    assert not named("rod in time, friction 0.001 off the jam").run().ok


def test_the_default_strike_is_near_its_jam_only_in_friction() -> None:
    """Its tip does not move along the rod's own line: what a pass promises there is no more than smoothness."""
    run = simulate(Tool(), stop_after="strike")
    hit = next(each for each in run.contacts if each.obstacle == "workpart")
    line = math.atan2(-hit.velocity_before[0], hit.velocity_before[1])
    assert abs(line + hit.angles[0]) > 0.005
