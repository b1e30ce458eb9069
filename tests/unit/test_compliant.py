"""Contacts resolved in time, against closed forms, balances and symmetry."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest

from bristle_sim.parameters import Contact, Surface, Tool
from bristle_sim.reference import simulate_reference
from bristle_sim.scene.compliant import CompliantLaw
from bristle_sim.scene.contact import Sums
from bristle_sim.scene.events import Kind, contact_events
from bristle_sim.scene.extrapolation import Extrapolation, IntervalResult
from bristle_sim.scene.impacts import ContactLaw
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import Chain, build_strike, strike, struck
from bristle_sim.scene.system import Plan, System
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord

PAIR = Chain((1.0, 1.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))


ROUGH = Surface(0.3, None, 0.5)


def law_accuracy(law: ContactLaw) -> float:
    return law.accuracy if isinstance(law, CompliantLaw) else 1e-6


def resolved(chain: Chain, surface: Surface, law: ContactLaw) -> ContactRecord:
    """A strike by a law in the scene's own units, in which the fastest rate is 1."""
    scene, state, obstacle, _ = build_strike(chain, surface)
    return struck(scene, state, obstacle, Settings(law_accuracy(law)), law)[0]


class TestCompliantContact:
    def test_duration_follows_the_accuracy_down_to_what_rounding_allows(self) -> None:
        """A tenth of the accuracy over the fastest rate, 0.2 rad/s; at least 3e-7/sqrt(e*) over it."""
        for accuracy, restitution, duration in (
            (1e-4, 0.5, 5e-5),
            (1e-7, 0.25, 3e-6),
            (1e-7, 0.0, 1.5e-6),
        ):
            surface = Surface(0.3, None, restitution)
            found = strike(
                PAIR, surface, Contact("compliant"), Settings(accuracy=accuracy)
            ).contact.duration
            # Without restitution compression alone takes the time. The motion meanwhile is of the order of it.
            assert found == pytest.approx(duration, rel=1e-4)

    @pytest.mark.parametrize("friction", [0.0, 0.3])
    def test_course_of_a_contact_of_one_freedom(self, friction: float) -> None:
        """A rod at gamma = 0.6 with v = rate: N' = -k v_n, v_n' = a N, a = K_nn + mu K_nt in and K_nn - mu K_nt out.

        Quarter periods of pi/2/sqrt(a k) and e* pi/2/sqrt(a' k), of sinus and cosinus; k from their sum, the duration.
        """
        gamma = 0.6
        e = 0.5
        duration = 1e-4
        approach = math.sin(gamma)
        k_nn = 3.0 * math.sin(gamma) ** 2
        k_nt = 3.0 * math.sin(gamma) * math.cos(gamma)
        rates = [k_nn + friction * k_nt, k_nn - friction * k_nt]
        stiffness = (0.5 * math.pi * (rates[0] ** -0.5 + e * rates[1] ** -0.5) / duration) ** 2
        inwards = 0.5 * math.pi / math.sqrt(rates[0] * stiffness)
        depth = approach / math.sqrt(rates[0] * stiffness)
        chain = Chain((1.0,), (1.0,), (-gamma,), (1.0,))
        history = strike(
            chain, Surface(friction, None, e), Contact("compliant", duration), Settings()
        ).contact.history
        assert history is not None
        time = history.time - history.time[0]
        phase = (
            np.where(time < inwards, time / inwards, 1.0 + (time - inwards) / (duration - inwards))
            * 0.5
            * math.pi
        )
        share = np.where(time < inwards, np.sin(phase), e**2 * np.sin(phase) + 1.0 - e**2)
        force = stiffness * depth * np.sin(phase)
        # The rod turns by 1e-4 meanwhile.
        np.testing.assert_allclose(history.penetration, depth * share, rtol=0.0, atol=1e-3 * depth)
        np.testing.assert_allclose(
            history.normal_force, force, rtol=0.0, atol=1e-3 * stiffness * depth
        )
        sign = np.where(time <= inwards * (1.0 + 1e-3), 1.0, -1.0)
        turning = np.abs(time - inwards) < 1e-2 * inwards
        np.testing.assert_allclose(
            history.tangential_force[~turning],
            (-friction * sign * history.normal_force)[~turning],
            rtol=1e-12,
            atol=1e-12,
        )

    @pytest.mark.parametrize("ratio", [3.0, 10.0, 30.0])
    @pytest.mark.parametrize("friction", [0.9, 0.92, 1.0, 1.2])
    def test_stick_lasts_until_the_spring_lets_go(self, ratio: float, friction: float) -> None:
        """Rounding breaks stick where the force ends: nothing but the end follows. Ten times the accuracy off the limit."""
        chain = dataclasses.replace(PAIR, masses=(5.0 * ratio, 5.0))
        surface = Surface(friction, None, 0.5)
        limit = strike(chain, surface, Contact(), Settings()).contact
        found = strike(chain, surface, Contact("compliant"), Settings())
        assert found.contact.rates_after == pytest.approx(limit.rates_after, rel=1e-5)
        assert found.contact.phases == limit.phases
        assert (
            found.steps < 5000
        )  # 1300 to 3500; up to twice of it with slip that starts and stops, or all there are

    @pytest.mark.parametrize(
        ("chain", "surface"),
        [
            (
                Chain((2.472, 0.656), (1.0, 1.0), (0.286, 0.475), (0.644, -0.685)),
                Surface(0.435, 0.903, 0.205),
            ),
            (
                Chain(
                    (0.532, 0.778, 2.01),
                    (1.118, 1.131, 1.052),
                    (-0.075, -0.311, -0.27),
                    (-1.014, -0.768, 1.485),
                ),
                Surface(0.164, 0.811, 1.0),
            ),
        ],
    )
    def test_slip_that_later_friction_presses_on_stays_at_rest(
        self, chain: Chain, surface: Surface
    ) -> None:
        """With mu_2 the deepest point would be pressed on, with mu_1 it parts: v_n = 0 and a friction between them until slip stops.

        The difference from the law falls as the duration does, but for a tenth of it.
        """
        unit = 1.0 / max(map(abs, chain.rates))
        settings = Settings(accuracy=1e-8)
        law = strike(chain, surface, Contact(), Settings()).contact.rates_after
        longer, shorter = (
            strike(chain, surface, Contact("compliant", duration * unit), settings).contact
            for duration in (1e-3, 1e-4)
        )
        first, second = (
            np.abs(np.subtract(each.rates_after, law)).max() * unit for each in (longer, shorter)
        )
        assert first / second == pytest.approx(10.0, rel=0.1)
        history = shorter.history
        assert history is not None
        friction = np.abs(history.tangential_force) / np.maximum(history.normal_force, 1e-300)
        at_rest = (np.abs(history.normal_velocity) < 1e-6 / unit) & (
            np.abs(history.tangential_velocity) > 0.1 / unit
        )
        assert np.count_nonzero(at_rest) > 3
        assert friction[at_rest].min() >= surface.friction * (1.0 - 1e-6)
        assert friction[at_rest].max() <= surface.friction_in_restitution
        # The last sample of compression alone has the friction of compression.
        assert np.count_nonzero(friction[at_rest] < surface.friction * (1.0 + 1e-6)) == 1
        assert history.penetration[at_rest] == pytest.approx(history.penetration.max(), rel=1e-6)

    def test_slip_does_not_stay_at_rest_where_later_friction_lets_the_tip_out(self) -> None:
        """With mu_2 = 0.5 it still moves out of the surface; as in the law, the tangential spring sticks meanwhile."""
        chain = Chain((2.472, 0.656), (1.0, 1.0), (0.286, 0.475), (0.644, -0.685))
        law, in_time = (
            strike(chain, Surface(0.435, 0.5, 0.205), Contact(*each, 0.05), Settings(1e-8)).contact
            for each in (("energetic", None), ("compliant", 1e-4))
        )
        assert in_time.phases == law.phases

    def test_stiction_ends_the_compression_of_a_rod_that_its_hub_still_presses_on(self) -> None:
        """Slip and approach end together but for the turn in a contact of 1e-4."""
        chain = Chain((1.0,), (1.0,), (-0.6,), (1.0,), 1.0, 0.3, -0.6)
        surface = Surface(2.0, None, 0.5)
        law = strike(chain, surface, Contact(), Settings()).contact
        in_time = found(chain, surface, 1e-4)
        assert in_time.outcome == law.outcome == "stiction"
        assert in_time.phases == law.phases
        assert in_time.impulse == pytest.approx(law.impulse, rel=1e-4)

    @pytest.mark.parametrize("duration", [1e-5, 1e-2, 0.1])
    @pytest.mark.parametrize(("friction", "later"), [(2.0, 2.0), (0.3, 5.0)])
    def test_stiction_ends_with_compression(
        self, duration: float, friction: float, later: float
    ) -> None:
        """A rod at 0.6 that friction sticks: p_c = m L w/(3 (sin + mu cos)) is all, but for the turn meanwhile."""
        chain = Chain((1.0,), (1.0,), (-0.6,), (1.0,))
        found = resolved(chain, Surface(friction, later, 0.5), CompliantLaw(duration, 1e-6))
        assert (found.outcome, found.phases) == ("stiction", ("compression slip",))
        assert found.impulse[0] == pytest.approx(
            1.0 / (3.0 * (math.sin(0.6) + friction * math.cos(0.6))), rel=duration
        )
        assert found.duration == pytest.approx(duration, rel=max(duration, 1e-4))


@pytest.mark.parametrize("ratio", [1e-9, 1e-4, 1e6, 1e12])
def test_rods_of_very_different_masses_follow_the_rigid_body_law(ratio: float) -> None:
    """The joint is solved for directly: no number of iterations depends on the ratio of the masses."""
    chain = Chain((ratio, 1.0), (1.0, 1.0), (-0.3, -0.5), (0.1, 0.2))
    surface = Surface(0.3, None, 0.25)
    limit = strike(chain, surface, Contact(), Settings()).contact
    found = strike(chain, surface, Contact("compliant"), Settings()).contact
    # Ten times the accuracy of 1e-6, in units of the fastest rate.
    assert found.rates_after == pytest.approx(limit.rates_after, rel=0.0, abs=1e-5 * 0.2)


def test_a_rebound_slower_than_the_accuracy_is_that_of_the_rigid_body_law() -> None:
    """Its motion is the state before and the state after, as that of an impact without duration."""
    surface = Surface(0.3, None, 0.002)
    settings = Settings(accuracy=1e-2)
    limit, found = (
        strike(PAIR, surface, Contact(law), settings) for law in ("energetic", "compliant")
    )
    assert found.contact.duration == 0.0
    assert found.kinetic_energy == pytest.approx(limit.kinetic_energy, rel=1e-12)


@pytest.mark.parametrize(("speed", "restitution"), [(262.0, 0.4), (120.0, 0.1)])
def test_a_tip_comes_to_rest_by_the_rebounds_of_the_rigid_body_law(
    speed: float, restitution: float
) -> None:
    """Every rebound leaves a dent, shallower than the accuracy; hops of a few microseconds follow, which the dent must not hold."""
    tool = Tool().replace(
        hub_speed=speed,
        restitution=restitution,
        friction=0.0,
        belt_damping_ratio=0.3,
        contact="compliant",
    )
    runs = (simulate(tool, Settings(accuracy=1e-6)), simulate_reference(tool, accuracy=1e-8))
    found, expected = (
        sum(each.impulse[0] for each in run.contacts if each.obstacle == "workpart") for run in runs
    )
    assert found == pytest.approx(expected, rel=1e-5)  # ten times the accuracy


def test_a_wire_that_strikes_almost_end_on_tends_to_the_rigid_body_law() -> None:
    """Two links in line but for 2 mrad push 5000 times harder than a rigid wire; the contact is as short as the rigid wire's.

    It turns the links meanwhile, by its duration, which follows the accuracy.
    """
    tool = Tool().replace(wire_links=2, wire_damping_ratio=0.02, hub_speed=150.0)

    def impulse(law: str, accuracy: float) -> float:
        run = simulate(tool.replace(contact=law), Settings(accuracy=accuracy), stop_after="strike")
        (struck,) = (each for each in run.contacts if each.obstacle == "workpart")
        assert struck.outcome == "rebound"
        return struck.impulse[0]

    limit = impulse("energetic", 1e-5)
    apart = [abs(impulse("compliant", each) / limit - 1.0) for each in (1e-4, 1e-5)]
    assert apart[0] < 0.2
    assert apart[1] == pytest.approx(0.1 * apart[0], rel=0.5)


class TestCompliantRefusals:
    @pytest.mark.parametrize(
        ("call", "said"),
        [
            (
                lambda: resolved(PAIR, Surface(0.3, None, 9e-4), CompliantLaw(None, 1e-6)),
                "^restitution = 0.0009: must be 0, or at least 0.001, ",
            ),
            (
                lambda: resolved(PAIR, Surface(0.3, None, 0.25), CompliantLaw(3e-7, 1e-6)),
                "^contact_duration = 3e-07: must be at least 6e-07, ",
            ),
            (
                lambda: resolved(PAIR, Surface(0.3, None, 0.0), CompliantLaw(1.5e-7, 1e-6)),
                "^contact_duration = 1.5e-07: must be at least 3e-07, ",
            ),
        ],
    )
    def test_refusals_name_key_value_and_range(self, call: Callable[[], object], said: str) -> None:
        with pytest.raises(ValueError, match=said):
            call()


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_record_of_a_contact_resolved_in_time(restitution: float) -> None:
    """Every entry tends to that of the rigid-body law, as the rates do: within ten times the requested accuracy."""
    chain = Chain((1.0, 1.0), (1.0, 1.0), (-math.radians(20.0), -math.radians(30.0)), (0.1, 0.2))
    surface = Surface(0.3, None, restitution)
    limit = strike(chain, surface, Contact(), Settings()).contact
    found = strike(chain, surface, Contact("compliant"), Settings(accuracy=1e-5)).contact
    assert found.history is not None
    released = found.history.normal_force[-1] == found.history.tangential_force[-1] == 0.0
    assert released == (restitution > 0.0)
    for name in (
        "compressive_impulse",
        "compressive_work",
        "restitutive_work",
        "velocity_before",
        "velocity_after",
    ):
        expected = getattr(limit, name)
        # The tangential parts are shares of the normal ones; a final v_n of 0 is one beside that of the approach.
        size = max(map(abs, limit.velocity_before if "velocity" in name else expected), default=0.0)
        assert getattr(found, name) == pytest.approx(expected, rel=1e-4, abs=1e-4 * size + 1e-12), (
            name
        )


def found(
    chain: Chain, surface: Surface, duration: float | None, accuracy: float = 1e-7
) -> ContactRecord:
    return strike(
        chain, surface, Contact("compliant", duration), Settings(accuracy=accuracy)
    ).contact


class TestStick:
    JAMMED = Chain((0.5,), (0.7,), (0.65,), (2.9,), 0.9, 5.9, -0.5), Surface(3.0, None, 0.9)
    """A rod whose hub brings its root down on it: a jam for a contact without duration, not for one of 20 ms."""

    @pytest.mark.parametrize("accuracy", [1e-4, 1e-6, 1e-8, 1e-10])
    def test_that_breaks_in_restitution(self, accuracy: float) -> None:
        """7.88645 rad/s by an event-driven integration and by brute force, neither of this project."""
        breaking = Chain((1.0, 1.0), (1.0, 1.0), (0.35, 0.52), (-4.0, -8.0))
        record = found(breaking, Surface(1.5, None, 0.5), 3e-2, accuracy)
        assert record.rates_after[1] == pytest.approx(7.88645, abs=5e-6 + 8.0 * accuracy)
        assert record.phases == (
            "compression slip",
            "restitution slip",
            "restitution stick",
            "restitution slip",
        )

    @pytest.mark.parametrize("compliance", [1e-3, 0.05, 1.21])
    @pytest.mark.parametrize("restitution", [0.0, 0.4, 0.9])
    @pytest.mark.parametrize(
        ("angle", "friction"), [(0.2, 1.0), (0.5, 1.0), (0.5, 2.5), (0.8, 5.0)]
    )
    def test_that_jams_on_a_tangential_spring_too(
        self, angle: float, friction: float, restitution: float, compliance: float
    ) -> None:
        """Contact in time and law end at the same balance of forces. The law differs by half the duration, 3e-7, over the root's motion."""
        chain = dataclasses.replace(self.JAMMED[0], angles=(angle,))
        law, in_time = (
            strike(
                chain,
                Surface(friction, None, restitution),
                Contact(name, tangential_compliance=compliance),
                Settings(accuracy=1e-8),
            ).contact
            for name in ("energetic", "compliant")
        )
        assert law.outcome == in_time.outcome == "jam"
        assert in_time.impulse == pytest.approx(law.impulse, rel=2e-6)

    def test_that_jams_to_the_other_side_is_the_mirror_image(self) -> None:
        rod, _ = self.JAMMED
        mirrored = dataclasses.replace(
            rod,
            angles=(-0.5,),
            rates=(-rod.rates[0],),
            hub_speed=-rod.hub_speed,
            hub_angle=-rod.hub_angle,
        )
        contact = Contact("compliant", tangential_compliance=0.05)
        there, here = (
            strike(each, Surface(1.0, None, 0.4), contact, Settings(accuracy=1e-8)).contact
            for each in (dataclasses.replace(rod, angles=(0.5,)), mirrored)
        )
        assert there.outcome == here.outcome == "jam"
        assert here.impulse == pytest.approx((there.impulse[0], -there.impulse[1]), rel=1e-6)

    def test_that_jams_for_the_rigid_law_alone(self) -> None:
        """Ten times 0.1 ms later the hub's root has hardly moved on, by 6e-4: the record ends where the tip stuck."""
        limit = strike(*self.JAMMED, Contact(), Settings()).contact
        short = found(*self.JAMMED, 1e-4)
        long = found(*self.JAMMED, 0.02)
        assert (limit.outcome, short.outcome, long.outcome) == ("jam", "jam", "rebound")
        assert short.phases == (*limit.phases[:1], "compression stick")
        assert short.impulse == short.compressive_impulse == pytest.approx(limit.impulse, rel=1e-3)
        assert "compression stick" in long.phases

    def test_of_a_tip_that_its_root_presses_on(self) -> None:
        """It touches at 1 mm/s while the root, on top of its hub, falls at 31 m/s^2: after ten times 1 ms it is still there.

        The rigid law lets it rebound. "No rebound" is the word of contacts without restitution.
        """
        angle = 0.65
        rate = -1e-3 / (0.7 * math.sin(angle))
        pressed = Chain((0.5,), (0.7,), (angle,), (rate,), 0.9, 5.9, math.pi)
        surface = Surface(0.0, None, 0.5)
        assert strike(pressed, surface, Contact(), Settings()).contact.outcome == "rebound"
        assert found(pressed, surface, 1e-3).outcome == "stiction"

    def test_of_a_tip_that_begins_without_slip(self) -> None:
        """It sticks where friction suffices, and slips at once in the sense in which it is driven where not."""
        random = np.random.default_rng(5)
        slips = 0
        for _ in range(12):
            first, second = random.uniform(-1.2, 1.2, 2).tolist()
            rate = random.uniform(-2.0, 2.0)
            other = -rate * math.cos(first) / math.cos(second)
            approach = rate * math.sin(first) + other * math.sin(second)
            rates = (rate, other) if approach < 0.0 else (-rate, -other)
            chain = Chain((random.uniform(0.2, 5.0), 1.0), (1.0, 1.0), (first, second), rates)
            surface = Surface(10.0 ** random.uniform(-3.0, 1.0), None, random.uniform(0.1, 1.0))
            limit = strike(chain, surface, Contact(), Settings()).contact
            short = found(chain, surface, None)
            assert short.outcome == limit.outcome
            size = max(map(abs, limit.rates_after))
            assert short.rates_after == pytest.approx(limit.rates_after, abs=3e-5 * size)
            slips += limit.phases[0].endswith("slip")
        assert 3 <= slips <= 11

    @pytest.mark.parametrize("links", [1, 2, 3])
    def test_stays_within_the_friction_cone(self, links: int) -> None:
        """But for the accuracy, 1e-7, to which the instant is located where stick ends: ten times that of the peak."""
        random = np.random.default_rng(links)
        for _ in range(15):
            masses, lengths = np.exp(random.uniform(-1.0, 1.0, (2, links)))
            angles = random.uniform(-1.2, 1.2, links)
            rates = random.uniform(-10.0, 10.0, links)
            rates = -rates if (lengths * np.sin(angles) * rates).sum() > 0.0 else rates
            chain = Chain(*(tuple(map(float, each)) for each in (masses, lengths, angles, rates)))
            friction = math.exp(random.uniform(-2.0, 1.0))
            restitution = random.uniform(0.2, 1.0)
            course = found(
                chain, Surface(friction, None, restitution), 10.0 ** random.uniform(-3.0, -1.2)
            ).history
            excess = np.abs(course.tangential_force) - friction * course.normal_force
            assert excess.max() <= 1e-6 * course.normal_force.max()


@pytest.mark.parametrize("squared", [0.0, 1e-3, 1.2])
@pytest.mark.parametrize("duration", [None, 1e-4, 1e-2])
@pytest.mark.parametrize("degrees", [89.999999, 90.0, 90.001])
@pytest.mark.parametrize("hub", [(0.0, 0.0), (1.0, 0.3)])
def test_friction_cannot_stop_the_slip_of_a_rod_along_the_surface(
    hub: tuple[float, float], degrees: float, duration: float | None, squared: float
) -> None:
    """K_tt passes through zero, and the slip with it: p_n = (1 + e) v/K_nn with v of the tip, K_nn = 3, and abs(p_t) <= mu p_n.

    The rod turns by its rate times the duration in the contact; friction then acts with this lever.
    """
    mu, e = 0.3, 0.5
    angle = -math.radians(degrees)
    chain = Chain((1.0,), (1.0,), (angle,), (1.0,), *hub, angle)
    law = Contact("compliant", duration, squared)
    record = strike(chain, Surface(mu, None, e), law, Settings()).contact
    normal, along = record.impulse
    assert normal == pytest.approx((1.0 + e) * (1.0 + hub[0] * hub[1]) / 3.0, rel=5e-3)
    assert abs(along) <= mu * normal * (1.0 + 1e-9)


@pytest.mark.parametrize(
    ("share", "kinds"), [(0.5, set()), (1.1, {Kind.REST_ENDS}), (-0.1, {Kind.PRESSED_ON})]
)
@pytest.mark.parametrize("later", [0.6, 0.1])
def test_slip_at_rest_ends_where_its_friction_leaves_both_coefficients(
    later: float, share: float, kinds: set[Kind]
) -> None:
    """The friction is ``share`` of the way from mu, with which the tip moves deeper, to mu_2, with which it moves out."""
    scene, state, pair, _ = build_strike(PAIR, Surface(0.3, later, 0.5))
    law = CompliantLaw(1e-3, 1e-6)
    spring = law.spring(scene, state, pair)
    assert spring is not None
    system = System(scene, state, Extrapolation(1e-6), Plan(1.0, 1e-6), law=law)
    moved = state._replace(angles=tuple(a + 1e-4 * w for a, w in zip(*state[1:], strict=True)))
    slip = system.closest(pair, moved).velocity[1]
    spring.slip = int(math.copysign(1.0, slip))
    deepest = system.penetration(spring, moved)
    spring.law = dataclasses.replace(spring.law, deepest=deepest)
    spring.at_rest = True
    force = spring.law.stiffness * deepest
    friction = 0.3 + share * (later - 0.3)
    sums = Sums(force, -spring.slip * friction * force)
    reached = IntervalResult(moved, totals=tuple(sums))
    events = contact_events(system, [spring], None)
    assert {event.kind for event in events if event.value(reached) < 0.0} == kinds


def test_a_jam_is_reached_in_compression_and_once() -> None:
    """Slip that stops in restitution is none; nor is the second stop of a contact in which the bodies move on."""
    rod, surface = TestStick.JAMMED
    scene, state, pair, _ = build_strike(rod, surface)
    springs = [CompliantLaw(1e-3, 1e-6).spring(scene, state, pair) for _ in range(3)]
    fresh, unloading, stopped = [spring for spring in springs if spring is not None]
    unloading.unload(1e-6)
    stopped.stopped_at = (state, (0.0, 0.0), (0.0, 0.0), 0, 0)
    assert [spring.jams for spring in (fresh, unloading, stopped)] == [True, False, False]


@pytest.mark.parametrize(("slope", "sticks"), [(2e-3, True), (0.5e-3, False)])
def test_a_tip_that_moves_along_its_normal_but_for_a_milliradian_cannot_stick(
    slope: float, sticks: bool
) -> None:
    """However long the contact, of one radian here: K_tt = 3 slope^2 for a rod that lies along the surface."""
    chain = Chain((1.0,), (1.0,), (-(0.5 * math.pi - slope),), (1.0,))
    scene, state, pair, _ = build_strike(chain, ROUGH)
    spring = CompliantLaw(1.0, 1e-6).spring(scene, state, pair)
    assert spring is not None
    expected = 3.0 * slope**2 if sticks else 0.0
    assert spring.compliance_in_stick == pytest.approx(expected, rel=1e-5)
