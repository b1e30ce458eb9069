"""Trials with input that is no number, out of range or at the very ends of its range: one clear line, or a finite result."""

from __future__ import annotations

import dataclasses
import inspect
import math
import random
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, TypeVar

import numpy as np

from bristle_sim import parameters
from bristle_sim.contact_space.energetic_contact import EnergeticContact
from bristle_sim.declared import Choice, Computed, Range
from bristle_sim.parameters import (
    Bar,
    Belt,
    Bristle,
    Contact,
    DoublePendulum,
    Hub,
    Strike,
    Surface,
    Tool,
    Workpart,
)
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.strike import Chain, strike
from bristle_sim.scene.tool import build_tool
from bristle_sim.settings import Settings
from bristle_sim.theory.impact import LAWS
from bristle_sim.trajectory import Trajectory
from bristle_sim.units import shown
from promises.attempts import BAD, Tally, finite

T = TypeVar("T")

CLASSES: tuple[type[Any], ...] = (
    *(
        getattr(parameters, name)
        for name in parameters.__all__
        if inspect.isclass(getattr(parameters, name))
    ),
    Settings,
)
"""Every class of parameters."""

CORNER_STEPS = 2000
"""Engine steps of a pass at a corner; a spent budget is a result."""

STRIKE_STEPS = 20_000
"""Engine steps of a strike at a corner: a spent budget is a refusal."""


def trials() -> dict[str, Callable[[], Tally]]:
    """Return the trials by name."""
    return {
        **{f"every value of {kind.__name__}": partial(_values_of, kind) for kind in CLASSES},
        "every argument of simulate()": _simulate,
        "every argument of EnergeticContact": _energetic_contact,
        "every argument of the impact laws": _theory,
        **{
            f"ends of all ranges, a strike, {law}": partial(_strikes, law, n)
            for law, n in STRIKES.items()
        },
        f"ends of all ranges, a pass of {CORNER_STEPS} steps": partial(_passes, 30),
    }


STRIKES = {"energetic": 60, "engine": 60, "compliant": 20}
"""Number of strikes at the ends of ranges, by law."""


def _values_of(kind: type[Any]) -> Tally:
    tally = Tally()
    for each in dataclasses.fields(kind):
        key = each.metadata["declaration"].key if "declaration" in each.metadata else each.name
        for value in BAD:
            call = partial(_made, kind, {each.name: value})
            tally.attempt(f"{key} = {shown(value)}", call, partial(_holds_plain, each.name), key)
    return tally


def _made(kind: type[Any], values: dict[str, Any]) -> Any:
    return kind(**values)


def _holds_plain(name: str, part: object) -> bool:
    """Return whether a part holds a plain number or word, whatever it was given as."""
    held = getattr(part, name)
    known = type(held) in (float, Computed, int, str, type(None)) or dataclasses.is_dataclass(held)
    return known and (not isinstance(held, float) or math.isfinite(held))


def _simulate() -> Tally:
    tally = Tally()
    bare = Tool(bar=None, workpart=None)
    few = Settings(maximum_steps=100)
    names = (
        "tool",
        "settings",
        "start_hub_angle",
        "start_relative_angle",
        "start_relative_rate",
        "stop_after",
    )
    for name in names:
        for value in BAD:
            if name == "settings" and value is None:
                continue  # the default, with a budget of its own
            given: dict[str, Any] = {"tool": bare, "settings": few, name: value}
            tally.attempt(f"{name} = {shown(value)}", partial(simulate, **given), finite, name)
    for name in ("samples_per_period", "hub_turn"):
        for value in BAD:
            tally.attempt(
                f"{name} = {shown(value)}", partial(_run_with, bare, name, value), finite, name
            )
    return tally


def _run_with(tool: Tool, name: str, value: Any) -> Trajectory:
    return simulate(tool, Settings(**{"maximum_steps": 100, name: value}))


def _energetic_contact() -> Tally:
    tally = Tally()
    good = {"collision_type_a": 1, "collision_type_b": 2, "friction": 0.3, "restitution": 0.4}
    names = ("space", *good, "restitution_friction", "resting_speed", "report")
    for name in names:
        for value in BAD:
            given: dict[str, Any] = {
                "space": build_tool(Tool())[0].space,
                **good,
                name: value,
            }

            def known(contact: EnergeticContact) -> bool:
                (pair,) = contact.pairs.values()
                return finite((pair.friction, pair.restitution_friction, contact.resting_speed))

            tally.attempt(
                f"{name} = {shown(value)}", partial(EnergeticContact, **given), known, name
            )
    contact = EnergeticContact(build_tool(Tool())[0].space, 1, 2, friction=0.3, restitution=0.4)
    for value in BAD:
        tally.attempt(
            f"duration = {shown(value)}", partial(contact.step, value), _any_answer, "duration"
        )
    return tally


def _any_answer(answer: object) -> bool:
    del answer
    return True


def _theory() -> Tally:
    tally = Tally()
    good = {"friction": 0.5, "restitution": 0.42, "restitution_friction": 0.3}
    good |= {"inverse_mass": np.array([[1.0, 0.2], [0.2, 2.0]]), "velocity": (-1.0, 0.5)}
    for law in LAWS.values():
        for argument in good:
            for value in (*BAD, [True], [0.5, False], ["0.5"]):
                call = partial(law, **{**good, argument: value})
                tally.attempt(f"{law.__name__}, {argument} = {shown(value)}", call, finite)
    return tally


def corner(
    kind: type[T], chance: random.Random, share: float = 0.4, without: tuple[str, ...] = ()
) -> T:
    """Return parameters of a class, a part of them at one end of their ranges, the rest as by default."""
    values = dict(_ends(kind, chance, share, without))
    if kind is Bristle:
        # At the ends of length and diameter the mass that follows from them is out of its own range.
        values.setdefault("mass", 8.387e-5)
    return kind(**values)


def _ends(
    kind: type[Any], chance: random.Random, share: float, without: tuple[str, ...]
) -> Iterator[tuple[str, Any]]:
    for each in dataclasses.fields(kind):
        declared = each.metadata.get("declaration")
        if declared is None or declared.key in without or chance.random() > share:
            continue
        if isinstance(declared, Choice):
            yield each.name, chance.choice(declared.options)
        elif isinstance(declared, Range):
            least = (
                declared.lowest
                if declared.lowest_allowed
                else math.nextafter(declared.lowest, math.inf)
            )
            yield each.name, chance.choice((least, declared.highest))


def _strikes(law: str, number: int) -> Tally:
    tally = Tally()
    chance = random.Random(f"strikes {law}")
    for _ in range(number):
        chain = _one_rod(chance) if chance.random() < 0.5 else _two_rods(chance)
        contact = _contact(chance, law)
        settings = dataclasses.replace(corner(Settings, chance), maximum_steps=STRIKE_STEPS)
        call = partial(strike, chain, corner(Surface, chance), contact, settings)
        tally.attempt(f"{chain}, {contact}", call, finite)
    return tally


def _contact(chance: random.Random, law: str) -> Contact:
    """Return a contact of the law, whose duration is at one end of its range at times if the law has one."""
    ends = dict(_ends(Contact, chance, 0.4, ("contact",)))
    return Contact(law, ends.get("duration") if law == "compliant" else None)


def _one_rod(chance: random.Random) -> Chain:
    hub = corner(Hub, chance)
    bristle = corner(Bristle, chance)
    state = corner(Strike, chance)
    gamma = math.radians(state.impact_angle_deg)
    rate = state.speed_ratio * hub.speed
    return Chain(
        (bristle.mass,), (bristle.length,), (-gamma,), (rate,), hub.radius, hub.speed, -gamma
    )


def _two_rods(chance: random.Random) -> Chain:
    rods = corner(DoublePendulum, chance)
    angles = (-math.radians(rods.angle_1_deg), -math.radians(rods.angle_2_deg))
    return Chain(
        (rods.mass_ratio * rods.mass, rods.mass),
        (rods.length,) * 2,
        angles,
        (-rods.rate_1, -rods.rate_2),
    )


def _passes(number: int) -> Tally:
    tally = Tally()
    chance = random.Random("passes")
    for _ in range(number):
        tally.attempt("pass", partial(_pass, chance), finite)
    return tally


def _pass(chance: random.Random) -> Trajectory:
    hub, belt, bristle, bar, part = (
        corner(kind, chance, 0.1) for kind in (Hub, Belt, Bristle, Bar, Workpart)
    )
    settings = dataclasses.replace(
        corner(Settings, chance, 0.2, ("hub_turn",)), maximum_steps=CORNER_STEPS
    )
    contact = _contact(chance, chance.choice(("energetic", "compliant", "engine")))
    tool = Tool(
        hub, belt, bristle, chance.choice((None, bar)), chance.choice((None, part)), contact
    )  # type: ignore[arg-type]
    return simulate(
        tool,
        settings,
        start_relative_angle=chance.choice((0.0, -0.5, 0.5 * math.pi)),
        start_relative_rate=chance.choice((0.0, 0.0, 1e9, -1e9)),
    )
