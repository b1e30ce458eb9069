"""Every hard case keeps its promise, and the measures notice a program whose physics is broken."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bristle_sim.benchmarks.hard_cases import THEMES
from bristle_sim.benchmarks.hard_cases.report import TABLES
from bristle_sim.scene import collisions as scene_collisions
from bristle_sim.scene import extrapolation, touches
from bristle_sim.scene import impacts as contact_laws
from bristle_sim.scene import simulate as scene_simulate
from bristle_sim.scene import tool as scene_tool
from bristle_sim.scene.extrapolation import Extrapolation
from bristle_sim.scene.impacts import EnergeticLaw
from bristle_sim.theory.impact import energetic_impact

CASES = {f"{theme}: {case.name}": case for theme, cases in TABLES.items() for case in cases()}


LONGEST = "long_run: 1000 hub turns, accuracy 1e-06"
"""A case that takes as long as all others of its theme together."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.nightly] if name == LONGEST else []) for name in CASES],
)
def test_promise(name: str) -> None:
    finding = CASES[name].measure()
    assert finding.ok, finding.reached


def test_every_theme_can_be_chosen_and_every_case_has_a_name_of_its_own() -> None:
    assert tuple(TABLES) == THEMES
    assert LONGEST in CASES
    assert len(CASES) == sum(len(list(cases())) for cases in TABLES.values())


def law(change: Callable[..., Any]) -> tuple[object, str, Any]:
    """Another impact law in the scene's place of the energetic one."""

    def phases(
        k_nn: float, k_nt: float, k_tt: float, normal: float, slip: float, *rest: Any
    ) -> Any:
        return change(np.array([[k_nn, k_nt], [k_nt, k_tt]]), (normal, slip), *rest)

    return contact_laws, "resolve_phases", phases


def friction_off(error: float) -> tuple[object, str, Any]:
    """The impact law with a friction that is off by a relative error."""
    return law(
        lambda matrix, velocity, mu, e, later=None, *rest: energetic_impact(
            matrix,
            velocity,
            mu * (1.0 + error),
            e,
            None if later is None else later * (1.0 + error),
            *rest,
        )
    )


def restitution_off(error: float) -> tuple[object, str, Any]:
    """The impact law with a restitution that is off by a relative error."""
    return law(
        lambda matrix, velocity, mu, e, *rest: energetic_impact(
            matrix, velocity, mu, e * (1.0 - error), *rest
        )
    )


def slow_is_none(matrix: Any, velocity: Any, *rest: Any) -> Any:
    """Take an approach of 1e-10 of the slip for none."""
    slow = abs(velocity[0]) < 1e-10 * abs(velocity[1])
    return energetic_impact(matrix, (0.0, velocity[1]) if slow else velocity, *rest)


def part(name: str, **factors: float) -> tuple[object, str, Any]:
    """A scene built with some of the numbers of its effects or its mechanism off by a factor."""
    made = getattr(scene_tool, name)

    def off(*values: Any, **given: Any) -> Any:
        found = made(*values, **given)
        numbers = {key: getattr(found, key) or 0.0 for key in factors}
        return dataclasses.replace(found, **{key: numbers[key] * factors[key] for key in factors})

    return scene_tool, name, off


def gaining(*given: Any) -> Any:
    """Resolve an impact with rates 1e-6 too large, and say so."""
    after, record = RESOLVE(*given)
    rates = tuple(rate * (1.0 + 1e-6) for rate in after.rates)
    works = record.compressive_work, record.restitutive_work
    more = (works[1][0] - 3e-6 * works[0][0] + 1e-12 * abs(works[0][0]), works[1][1])
    return after._replace(rates=rates), dataclasses.replace(
        record, rates_after=rates, restitutive_work=more
    )


RESOLVE = EnergeticLaw.resolve


def nameless(*given: Any) -> Any:
    """Resolve an impact and call every outcome a rebound."""
    after, record = RESOLVE(*given)
    return after, dataclasses.replace(record, outcome="rebound")


def livelier(mass: Any, velocity: Any, friction: float, restitution: float, *others: float) -> Any:
    """Two percent more restitution."""
    return energetic_impact(mass, velocity, friction, min(1.02 * restitution, 1.0), *others)


def later(**given: Any) -> Any:
    """Allow a hundred times the requested steps."""
    return PLAN(**(given | {"maximum_steps": 100 * given["maximum_steps"]}))


PLAN = scene_simulate.Plan

BROKEN: dict[str, tuple[tuple[object, str, Any], list[str]]] = {
    "a friction 1e-10 off": (
        friction_off(1e-10),
        [
            "jam: rod pulled, friction 1e-09 off the jam",
            "jam: two rods, 1e-06 off the friction that sticks",
            "mass_ratio: n = 1e-09, slip",
        ],
    ),
    "a friction 1e-7 off": (
        friction_off(1e-7),
        [
            f"jam: {which}, friction 0.001 off the jam"
            for which in ("pass, tip pushed", "default pass")
        ],
    ),
    "a restitution 1e-12 off": (restitution_off(1e-12), ["grazing: strike at 1e-12 rad"]),
    "an approach taken for none": (law(slow_is_none), ["grazing: strike at 1e-12 rad"]),
    "a jam without its name": (
        (EnergeticLaw, "resolve", nameless),
        ["jam: pass, tip pushed, friction 0.001 off the jam"],
    ),
    "energy gained": (
        (EnergeticLaw, "resolve", gaining),
        ["mass_ratio: n = 1e-09, slip"],
    ),
    "compliance in stick from K alone": (
        law(lambda *given: energetic_impact(*given[:5])),
        ["mass_ratio: n = 1e+12, stick"],
    ),
    "a belt 4e-6 too stiff": (
        part("Effects", stiffness=1.0 + 4e-6),
        [
            "belt_stiffness: belt x 1: released, accuracy 1e-06",
            "belt_stiffness: belt x 10: whole pass",
            "hub_speed: 0 rad/s: released, accuracy 1e-09",
        ],
    ),
    "damping off by a thousandth": (
        part("Effects", damping=1.001),
        ["damping: ratio 0.5: decay", "damping: ratio 0.5: whole pass"],
    ),
    "a belt that freezes": ((extrapolation, "MOST_DAMPING", 1e9), ["damping: ratio 100: decay"]),
    "a hub 1e-5 too fast": (
        part("Mechanism", hub_speed=1.0 + 1e-5),
        ["hub_speed: 1000 rad/s: whole pass"],
    ),
    "coarse integration": (
        (scene_simulate, "stepper_for", lambda *_: Extrapolation(1e-4)),
        ["long_run: 10 hub turns, accuracy 1e-09"],
    ),
    "touches that are not located": (
        (touches, "settle", lambda _progress, _value, interval, _near, _tolerance: interval.end),
        ["tunnelling: accuracy 1e-06, hub 1 to 1e5 rad/s, bars from 3e-11 m and the workpart"],
    ),
    "another restitution": (
        law(livelier),
        ["jam: default pass, friction 0.001 off the jam"],
    ),
    "a jam that is not seen": (
        (scene_collisions, "_least_opening_rate", lambda *_: math.inf),
        ["touching: wedged in, restitution 0.5"],
    ),
    "a budget that is not kept": (
        (scene_simulate, "Plan", later),
        ["belt_stiffness: belt x 1e+06: whole pass"],
    ),
}
"""What is broken, by which attribute of which module and how, and the cases that must notice it."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.nightly if "budget" in name else ()) for name in BROKEN],
)
def test_broken_physics_is_noticed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    (owner, attribute, broken), cases = BROKEN[name]
    monkeypatch.setattr(owner, attribute, broken)
    for wanted in cases:
        assert not CASES[wanted].run().ok, wanted
