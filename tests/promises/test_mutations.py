"""Seeded physical errors must be noticed: with each of them, a check that the validation tests rely on fails."""

import math
from collections.abc import Callable
from dataclasses import replace

import pymunk
import pytest

from bristle_sim.parameters import Belt, Bristle, Tool
from bristle_sim.scene import impacts as contact_laws
from bristle_sim.scene import tool
from bristle_sim.scene.build import Scene
from bristle_sim.scene.mechanism import Link
from bristle_sim.scene.simulate import simulate
from bristle_sim.trajectory import Trajectory
from closed_forms.test_operating_point import (
    check_bar,
    check_retraction,
    check_strike,
    check_strike_ledger,
)

Check = Callable[[Trajectory], None]

CHECKS: tuple[Check, ...] = (check_strike, check_retraction, check_bar, check_strike_ledger)


def failing(subject: Tool | None = None) -> set[Check]:
    """The checks that a simulated pass does not stand."""
    run = simulate(subject or Tool(), stop_after="strike")
    return {check for check in CHECKS if fails(check, run)}


def fails(check: Check, run: Trajectory) -> bool:
    try:
        check(run)
    except AssertionError:
        return True
    return False


def test_unharmed_the_pass_stands_every_check() -> None:
    assert failing() == set()


class TestBelt:
    def test_torque_of_the_wrong_sign(self, monkeypatch: pytest.MonkeyPatch) -> None:
        class ReversedSpring(pymunk.DampedRotarySpring):
            def __init__(self, a, b, rest_angle, stiffness, damping):
                super().__init__(a, b, rest_angle, -stiffness, damping)

        monkeypatch.setattr("bristle_sim.scene.build.pymunk.DampedRotarySpring", ReversedSpring)
        assert failing() == set(CHECKS)

    @pytest.mark.parametrize("share", [0.99, 1.01])
    def test_stiffness_off_by_a_hundredth(self, share: float) -> None:
        """The speed goes with the root of the stiffness: 0.5 % of it."""
        assert check_strike in failing(
            replace(Tool(), belt=Belt(stiffness=math.degrees(0.00041) * share))
        )

    def test_damping_that_was_not_requested(self) -> None:
        assert check_strike in failing(replace(Tool(), belt=Belt(damping_ratio=0.002)))


class TestInertia:
    def test_no_centrifugal_term(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """A torque on the link that takes away what the rotating root exerts, m r_h (L/2) w^2 sin a."""
        true = Scene.__init__

        def built(scene: Scene, *given) -> None:
            true(scene, *given)
            hub = scene.hub
            link = scene.links[0]
            mechanism = scene.mechanism
            step = scene.step

            def without(length: float, count: int, acts, **options) -> list[float]:
                def push() -> None:
                    relative = link.angle - hub.angle
                    link.torque += (
                        0.5 * mechanism.hub_radius * mechanism.hub_speed**2 * math.sin(relative)
                    )

                return step(length, count, [*acts, push], **options)

            scene.step = without

        monkeypatch.setattr(Scene, "__init__", built)
        assert {check_strike, check_retraction} <= failing()

    @pytest.mark.parametrize("share", [0.98, 1.02])
    def test_moment_of_inertia_off(self, monkeypatch: pytest.MonkeyPatch, share: float) -> None:
        """About the centre, where it is a quarter of that about the root: 0.5 % of the latter."""
        true = tool.wire_links

        def off(*arguments) -> tuple[Link, ...]:
            return tuple(replace(link, inertia=link.inertia * share) for link in true(*arguments))

        monkeypatch.setattr(tool, "wire_links", off)
        assert check_strike in failing()

    def test_hub_off_its_speed(self) -> None:
        assert check_strike in failing(
            replace(Tool(), hub=replace(Tool().hub, speed=261.8 * 1.001))
        )

    def test_root_circle_off(self) -> None:
        assert check_strike in failing(
            replace(Tool(), hub=replace(Tool().hub, radius=0.0275 - 1e-4))
        )


class TestBar:
    @pytest.mark.parametrize("side", ["horizontal", "vertical"])
    @pytest.mark.parametrize("off", [-1e-3, 1e-3])
    def test_a_millimetre_off(self, side: str, off: float) -> None:
        bar = Tool().bar
        assert bar is not None
        moved = replace(bar, **{side: getattr(bar, side) + off})
        assert {check_strike, check_retraction, check_bar} <= failing(replace(Tool(), bar=moved))

    def test_wire_without_thickness(self) -> None:
        thin = Bristle(wire_diameter=0.0, mass=8.387e-5)
        assert {check_strike, check_retraction, check_bar} <= failing(replace(Tool(), bristle=thin))

    def test_bar_that_throws_back(self) -> None:
        bar = Tool().bar
        assert bar is not None
        assert {check_strike, check_bar} <= failing(
            replace(Tool(), bar=replace(bar, restitution=0.42))
        )

    def test_no_bar(self) -> None:
        run = simulate(replace(Tool(), bar=None), stop_after="strike")
        assert fails(check_strike, run)
        assert fails(check_retraction, run)
        assert fails(check_bar, run)


class TestImpact:
    def test_workpart_off_by_a_hundredth_of_a_millimetre(self) -> None:
        part = Tool().workpart
        assert part is not None
        assert check_strike in failing(replace(Tool(), workpart=replace(part, penetration=0.00451)))

    def test_another_coefficient_of_restitution(self) -> None:
        part = Tool().workpart
        assert part is not None
        assert failing(replace(Tool(), workpart=replace(part, restitution=0.42 + 1e-6))) == {
            check_strike_ledger
        }

    def test_friction_of_the_wrong_sign(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """The tangential impulse turned round on its way to the bodies."""
        monkeypatch.setattr(
            contact_laws, "contact_at", with_response(contact_laws.contact_at, turned_friction)
        )
        assert failing() == {check_strike_ledger}

    def test_impulse_that_misses_the_tip(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """The response of a rod a thousandth shorter."""

        def off(response: tuple) -> list:
            return [[0.999 * each for each in changes] for changes in response]

        monkeypatch.setattr(contact_laws, "contact_at", with_response(contact_laws.contact_at, off))
        assert check_strike_ledger in failing()


def turned_friction(response: tuple) -> tuple:
    normal, along = response
    return normal, [-each for each in along]


def with_response(true: Callable, change: Callable) -> Callable:
    def changed(*arguments):
        point = true(*arguments)
        return point._replace(response=change(point.response))

    return changed
