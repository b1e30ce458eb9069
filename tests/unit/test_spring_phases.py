"""Phases of a contact with springs, and its forces in them, against values by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.contact import Outcome
from bristle_sim.scene.events import Kind
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.impacts import contact_at
from bristle_sim.scene.motion import Motion
from bristle_sim.scene.spring import SHORTEST_SWING, SpringContact
from bristle_sim.scene.spring_phases import change_spring, look_up_slip
from bristle_sim.scene.strike import Chain, build_strike, strike
from bristle_sim.scene.system import Plan, System
from bristle_sim.settings import Settings

PAIR = Chain((1.0, 1.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))


def penetrating(
    surface: Surface, compliance: float = 0.0, chain: Chain = PAIR, *, single: bool = True
) -> tuple[System, SpringContact, float]:
    """A chain a moment after its tip has touched a surface, its contact, and the penetration."""
    scene, start, pair, _ = build_strike(chain, surface)
    law = CompliantLaw(1e-3, 1e-6, tangential_compliance=compliance)
    spring = law.spring(scene, start, pair)
    assert spring is not None
    moved = tuple(a + 1e-4 * w for a, w in zip(start.angles, start.rates, strict=True))
    plan = Plan(1.0, 1e-6, single_contact=single)
    system = System(scene, start._replace(angles=moved), Extrapolation(1e-6), plan, law=law)
    return system, spring, system.penetration(spring)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_force_in_stick_is_limited_to_the_friction_cone(sense: float) -> None:
    _, spring, depth = penetrating(Surface(0.3, None, 0.5))
    normal = spring.law.stiffness * depth
    spring.stick_force = sense * 1e9
    assert spring.forces(depth) == pytest.approx((normal, sense * 0.3 * normal))


@pytest.mark.parametrize(("friction", "later"), [(0.1, 0.6), (0.6, 0.1)])
def test_a_force_in_slip_at_rest_is_limited_by_the_larger_friction(
    friction: float, later: float
) -> None:
    _, spring, depth = penetrating(Surface(friction, later, 0.5))
    spring.unload(depth)
    spring.at_rest = True
    spring.slip = 1
    spring.stick_force = -1e9
    normal = spring.law.stiffness * depth
    assert spring.forces(depth) == pytest.approx((normal, -0.6 * normal))


def test_slow_slip_at_rest_swings_on_its_tangential_spring() -> None:
    """The force rises by the difference of both frictions while the tip moves by this distance, in the shortest swing."""
    _, spring, depth = penetrating(Surface(0.5, 0.2, 0.5), 1.2)
    spring.unload(depth)
    assert spring.least_slip_at_rest == pytest.approx(1.2 * 0.3 * depth / (SHORTEST_SWING * 1e-3))


def test_the_foot_of_a_spring_beyond_the_cone_follows_to_its_edge() -> None:
    _, spring, depth = penetrating(Surface(0.3, None, 0.5), 1.2)
    spring.stick_force = 1e9
    assert spring.set_foot(depth, 0.25)
    assert spring.stick_force == pytest.approx(0.3 * spring.law.stiffness * depth)
    assert spring.foot == pytest.approx(0.25 + 0.3 * 1.2 * depth)
    assert spring.forces(depth)[1] == spring.stick_force


def test_a_tip_that_is_pressed_on_loads_its_springs_again() -> None:
    system, spring, depth = penetrating(Surface(0.3, None, 0.5), 1.2)
    spring.unload(0.5 * depth)
    spring.at_rest = True
    assert change_spring(system, Motion((spring,)), spring, Kind.PRESSED_ON) is None
    assert not spring.at_rest
    assert spring.forces(depth)[0] == pytest.approx(spring.law.stiffness * depth)
    place = system.along(spring.pair, system.state)
    stretched = 1.2 * spring.stick_force / spring.law.stiffness
    assert spring.foot == pytest.approx(place + stretched, abs=1e-15)


@pytest.mark.parametrize("kind", [Kind.REST_ENDS, Kind.FOOT_STOPS])
def test_slip_at_rest_ends_at_the_present_depth_with_the_friction_of_compression(
    kind: Kind,
) -> None:
    system, spring, depth = penetrating(Surface(0.3, 0.6, 0.5))
    spring.unload(0.9 * depth)
    spring.at_rest = True
    spring.slip = 1
    if kind is Kind.REST_ENDS:
        assert change_spring(system, Motion((spring,)), spring, kind) is None
        assert spring.stick_force == pytest.approx(-0.3 * spring.law.stiffness * depth)
    else:
        change_spring(system, Motion((spring,)), spring, kind)
    assert not spring.at_rest
    assert spring.forces(depth)[0] == pytest.approx(spring.law.stiffness * depth)


@pytest.mark.parametrize(("friction", "slips"), [(0.3, 0), (0.0, -1)])
def test_a_foot_that_stops_sticks_unless_it_has_no_friction(friction: float, slips: int) -> None:
    """Without friction the tip swings back, which no tangential force notices."""
    system, spring, depth = penetrating(Surface(friction, None, 0.5), 1.2)
    sense = int(math.copysign(1.0, system.closest(spring.pair, system.state).velocity[1]))
    spring.slip = sense
    spring.stick_force = -sense * friction * spring.law.stiffness * depth
    assert change_spring(system, Motion((spring,)), spring, Kind.FOOT_STOPS) is None
    assert spring.slip == slips * sense


@pytest.mark.parametrize(("single", "outcome"), [(True, Outcome.STICTION), (False, None)])
def test_stiction_is_foretold_for_a_single_contact_only(
    single: bool, outcome: Outcome | None
) -> None:
    """In a pass the bodies move noticeably during a contact whose duration is given."""
    system, spring, _ = penetrating(Surface(0.3, None, 0.5), single=single)
    spring.predicted = Outcome.STICTION
    spring.slip = 1
    motion = Motion((spring,))
    assert change_spring(system, motion, spring, Kind.COMPRESSION_ENDS) is outcome


@pytest.mark.parametrize(("friction", "sticks"), [(3.0, True), (0.01, False)])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_slip_within_its_error_sticks_from_the_first_touch_if_friction_suffices(
    friction: float, sticks: bool, sense: float
) -> None:
    """The slip velocity is 1e-7 of the speed, its error 1e-6; both forces are zero at the touch."""
    first, second = angles = (-0.4, -0.9)
    rates = (1.0, (sense * 1e-7 - math.cos(first)) / math.cos(second))
    rates = rates if math.sin(first) + rates[1] * math.sin(second) < 0.0 else (-rates[0], -rates[1])
    system, spring, _ = penetrating(
        Surface(friction, None, 0.5), chain=Chain((1.0, 1.0), (1.0, 1.0), angles, rates)
    )
    system.state = spring.start
    look_up_slip(system, Motion(), spring)
    assert (spring.slip == 0) == sticks


def test_a_single_contact_does_not_end_as_its_rod_turns_through_a_right_angle() -> None:
    """Only in a pass it would lie on the hub. Half the depth v T/2 past it, a level rod rebounds with e* of its rate.

    The rod turns by 1e-3, so that its lever changes by 1e-6.
    """
    depth = 2.0 * 1e-3 / math.pi / (1.0 + 0.9)
    chain = Chain((1.0,), (1.0,), (0.5 * math.pi + 0.5 * depth,), (-1.0,))
    struck = strike(chain, Surface(0.0, None, 0.9), Contact("compliant", 1e-3), Settings())
    assert min(struck.angles[:, 0]) < 0.5 * math.pi < struck.angles[0, 0]
    assert struck.contact.rates_after[0] == pytest.approx(0.9, rel=1e-5)


@pytest.mark.parametrize(
    ("chain", "single", "outcome"),
    [
        (PAIR, True, Outcome.REBOUND),
        (PAIR, False, None),
        (Chain((1.0,), (1.0,), (-0.4,), (1.0,)), False, Outcome.REBOUND),
    ],
)
def test_a_trace_of_unloading_is_left_out_where_no_other_link_may_press_on(
    chain: Chain, single: bool, outcome: Outcome | None
) -> None:
    """With e* = 0.5 the dent is 0.75 of the greatest depth; 5e-6 of the unloading is left."""
    system, spring, depth = penetrating(Surface(0.3, None, 0.5), chain=chain, single=single)
    spring.unload(depth / (0.75 + 0.25 * 5e-6))
    assert change_spring(system, Motion((spring,)), spring, Kind.CONE_REACHED) is outcome


def moving(normal: float, along: float) -> Chain:
    """Two rods of mass and length 1 at -20 and -30 degrees whose tip has a velocity."""
    levers = np.array([np.sin(PAIR.angles), np.cos(PAIR.angles)])
    rates = np.linalg.solve(levers, (normal, along))
    return replace(PAIR, rates=tuple(rates.tolist()))


@pytest.mark.parametrize(("compliance", "rests"), [(1e-3, True), (1.2, False)])
def test_slip_rests_at_the_greatest_depth_if_its_spring_would_swing_too_fast(
    compliance: float, rests: bool
) -> None:
    """Both frictions hold the depth between them: N K_nn = T K_nt. At 1.2 the shortest swing takes a faster slip."""
    pair = moving(-1.0, 0.1)
    scene, start, part, _ = build_strike(pair, Surface(0.0, None, 0.5))
    (normal, coupling), _ = contact_at(scene.mechanism, start, part).inverse_mass
    holding = normal / abs(coupling)
    surface = Surface(0.8 * holding, 1.2 * holding, 0.5)
    system, spring, depth = penetrating(surface, compliance, pair)
    level = moving(0.0, math.copysign(0.1, coupling))
    system.state = system.state._replace(rates=level.rates)
    spring.slip = int(math.copysign(1.0, coupling))
    spring.stick_force = -spring.slip * surface.friction * spring.law.stiffness * depth
    assert change_spring(system, Motion((spring,)), spring, Kind.COMPRESSION_ENDS) is None
    assert spring.at_rest == rests


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("rounding", [1e-8, -1e-8])
@pytest.mark.parametrize("compliance", [0.4, 6.0])
def test_a_foot_whose_velocity_is_rounding_slides_if_its_force_drives_it(
    compliance: float, rounding: float, sense: int
) -> None:
    """At the edge of the cone the velocity of the foot, s v_t + mu eta^2 v_n, changes by
    s (K_nt - mu s K_tt) + mu eta^2 (K_nn - mu s K_nt) per normal impulse."""
    along = sense * (0.3 * compliance + rounding)
    system, spring, _ = penetrating(Surface(0.3, None, 0.5), compliance, moving(-1.0, along))
    system.state = spring.start
    (normal, coupling), (_, tangential) = spring.inverse_mass
    driven = sense * coupling - 0.3 * tangential
    driven += 0.3 * compliance * (normal - 0.3 * sense * coupling)
    look_up_slip(system, Motion(), spring)
    assert spring.slip == (sense if driven > 0.0 else 0)


def test_the_force_in_stick_holds_against_the_springs_of_other_contacts() -> None:
    """A second contact of the same tip without friction: T = -K_nt (N + N')/K_tt, as the rods stand still."""
    system, spring, depth = penetrating(Surface(9.0, None, 0.5))
    part = replace(spring.pair, friction=0.0, restitution_friction=0.0)
    other = system.law.spring(system.scene, spring.start, part)
    assert isinstance(other, SpringContact)
    other.slip = 1
    system.state = system.state._replace(rates=(0.0, 0.0))
    look_up_slip(system, Motion((spring, other)), spring)
    force = spring.law.normal_force(depth) + other.law.normal_force(depth)
    (_, coupling), (_, tangential) = spring.inverse_mass
    assert spring.slip == 0
    assert spring.stick_force == pytest.approx(-coupling * force / tangential, rel=1e-6)
