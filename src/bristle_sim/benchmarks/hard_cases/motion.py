"""Hard cases of motion: extreme belts, damping, hub speeds and sizes, thin bars, and wires that
bend.

Long runs and small step budgets are here too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row, within, worst
from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    AS_REFERENCE,
    RELEASED,
    SPENT,
    agrees_with_energy_integral,
    agrees_with_reference,
    spends_budget,
)
from bristle_sim.parameters import Bar, Belt, Tool, tool_keys
from bristle_sim.scene.pairs import LEAST_REACH
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings, StopReason

TOOL = Tool()
FREE = Tool(bar=None, workpart=None)
STIFFNESS = Belt().stiffness

FINE = 1e-9
"""Requested accuracy of the more accurate runs, a thousandth of the default."""

BUDGET = 20_000
"""Step budget, in engine steps, that the pass with the stiffest belt must exhaust."""


def released(theme: str, name: str, accuracy: float, **changes: float) -> HardCase:
    """Return the case that compares the release of a changed tool with the energy integral."""
    promise = f"highest speed and its time as by the energy integral to {accuracy:g}, the requested accuracy"
    given = (FREE.replace(**changes), accuracy)
    return row(
        theme,
        f"{name}: released, accuracy {accuracy:g}",
        promise,
        agrees_with_energy_integral,
        *given,
    )


def whole(theme: str, name: str, **changes: float) -> HardCase:
    """Return the case that compares the whole pass of a changed tool with the reference."""
    tool = TOOL.replace(**changes)
    promise = AS_REFERENCE.format(ACCURACY)
    return row(theme, f"{name}: whole pass", promise, agrees_with_reference, tool)


def belt_stiffness() -> Iterator[HardCase]:
    """Yield releases and whole passes over nine decades of belt stiffness."""
    for factor, accuracy in ((1e-3, ACCURACY), (1.0, ACCURACY), (1e6, FINE)):
        yield released(
            "belt_stiffness", f"belt x {factor:g}", accuracy, belt_stiffness=factor * STIFFNESS
        )
    for factor in (1e-3, 10.0):
        yield whole("belt_stiffness", f"belt x {factor:g}", belt_stiffness=factor * STIFFNESS)
    stiff = TOOL.replace(belt_stiffness=1e6 * STIFFNESS)
    yield row("belt_stiffness", "belt x 1e+06: whole pass", SPENT, spends_budget, stiff, BUDGET)


def damping() -> Iterator[HardCase]:
    """Yield decays at damping ratios up to 100, which end while the bristle still moves, and a
    whole pass.
    """
    promise = AS_REFERENCE.format(ACCURACY)
    for ratio, turn in ((0.5, 0.5), (1.0, 0.5), (100.0, 0.2)):
        free = FREE.replace(belt_damping_ratio=ratio)
        name = f"ratio {ratio:g}: decay"
        yield row(
            "damping", name, promise, agrees_with_reference, free, start=RELEASED, hub_turn=turn
        )
    yield whole("damping", "ratio 0.5", belt_damping_ratio=0.5)


def hub_speed() -> Iterator[HardCase]:
    """Yield the release on a resting hub, and whole passes at up to 1e5 rad/s, with and without a
    belt.
    """
    yield released("hub_speed", "0 rad/s", FINE, hub_speed=0.0)
    for speed in (0.0, 1e3, 1e5):
        yield whole("hub_speed", f"{speed:g} rad/s", hub_speed=speed)
    yield whole("hub_speed", "0.001 rad/s, no belt", hub_speed=1e-3, belt_stiffness=0.0)


def size() -> Iterator[HardCase]:
    """Yield passes of very large and very small tools, rigid and resolved in time.

    Lengths, masses and times are multiplied by powers of two. Such a factor rounds nothing, so the
    results must agree to the last bit.
    """
    huge = (2.0**7, 2.0**24, 2.0**5)
    tiny = (2.0**-15, 2.0**-26, 2.0**-8)
    promise = "the default's motion to the last bit"
    yield row("size", "3.5 m, 1.4e3 kg: whole pass", promise, _scales, "energetic", *huge)
    yield row("size", "0.82 um, 1.2e-12 kg: whole pass", promise, _scales, "energetic", *tiny)
    yield row(
        "size", "0.82 um, 1.2e-12 kg: whole pass, in time", promise, _scales, "compliant", *tiny
    )


def _scales(law: str, length: float, mass: float, time: float) -> Finding:
    """Compare the passes of two similar tools bit by bit.

    The factors ``length``, ``mass`` and ``time`` make the second tool of the first.
    """
    factors = {"m": length, "kg": mass, "rad/s": 1.0 / time, "m/s^2": length / time**2}
    factors["N m/rad"] = mass * (length / time) ** 2
    one = TOOL.replace(gravity=3e3, contact=law)
    changes = dict[str, float]()
    for part, keys in tool_keys().items():
        owner = getattr(one, part) if part else one
        changes |= {
            key: getattr(owner, name) * factors[each.unit]
            for key, (name, each) in keys.items()
            if each.unit in factors
        }
    first, second = simulate(one), simulate(one.replace(**changes))
    same = np.array_equal(first.angles, second.angles) and np.array_equal(
        first.time * time, second.time
    )
    return Finding(
        "the same bits" if same else "different", same, first.cost.steps + second.cost.steps
    )


def budget() -> Iterator[HardCase]:
    """Yield motions that exceed their step budget: in flight, in a pass, and in a contact resolved
    in time.
    """
    case = partial(row, "budget")
    promise = f"{SPENT}, within an interval of it"
    turns = Settings(hub_turn=1e4)
    soft = TOOL.replace(bar=None, contact="compliant", contact_duration=1e-3)
    yield case("flight; 1 engine steps", promise, spends_budget, FREE, 1, turns, RELEASED)
    yield case("pass; 2000 engine steps", promise, spends_budget, TOOL, 2000, turns)
    yield case("soft strike; 10 engine steps", promise, spends_budget, soft, 10, turns)


ROOT = TOOL.hub.radius
TIP = TOOL.hub.radius + TOOL.bristle.length
"""Radii of the circles of a radial bristle's root and tip, m."""

THINNEST = 1.001 * LEAST_REACH * TOOL.bristle.length
"""Radius of the thinnest bar that may meet a wire of zero width, m."""


def tunnelling() -> Iterator[HardCase]:
    """Yield passes at many accuracies and hub speeds, and at bars far thinner than a step.

    A straight bristle without gravity remains radial until it touches an obstacle, so geometry
    gives the instant of the touch.
    """
    for accuracy in (0.1, 1e-6, 1e-11):
        name = f"accuracy {accuracy:g}, hub 1 to 1e5 rad/s, bars from {THINNEST:.1g} m and the workpart"
        promise = f"all met, their instants right to {accuracy:g} of them, the requested accuracy"
        yield row("tunnelling", name, promise, _meets_at_accuracy, accuracy)


def with_bar_at(
    distance: float, radius: float, speed: float = TOOL.hub.speed, angle: float = 1.2
) -> Tool:
    """Return a tool with a bar at a distance (m) from the hub axis; its wire has no width.

    The bar stands ``angle`` (rad) before the direction of the workpart.
    """
    bar = Bar(
        radius=radius, horizontal=distance * math.sin(angle), vertical=distance * math.cos(angle)
    )
    return TOOL.replace(hub_speed=speed, bar=bar, wire_diameter=0.0, bristle_mass=TOOL.bristle.mass)


def first_bar_touch(tool: Tool) -> float:
    """Return the instant at which a radial bristle meets the bar, s.

    Either the wire's end meets the bar (law of cosines), or its flank does (tangent).
    """
    assert tool.bar is not None
    distance = math.hypot(tool.bar.horizontal, tool.bar.vertical)
    reach = tool.bar_reach
    if distance * distance - reach * reach > TIP * TIP:
        between = math.acos((distance**2 + TIP**2 - reach**2) / (2.0 * distance * TIP))
    else:
        between = math.asin(reach / distance)
    return (
        -tool.start_hub_angle - math.atan2(tool.bar.horizontal, tool.bar.vertical) - between
    ) / tool.hub.speed


def _meets_at_accuracy(accuracy: float) -> Finding:
    """Compare the instants at which runs meet bars and the workpart with geometry."""
    settings = Settings(accuracy=accuracy, samples_per_period=1)
    late = list[float]()
    steps = 0
    for speed in (1.0, 261.8, 1e5):
        bare = TOOL.replace(hub_speed=speed, bar=None)
        bars = [with_bar_at(0.9 * TIP, radius, speed) for radius in (THINNEST, 1e-6, 1e-3)]
        tried = [
            (bare, "strike", (-bare.start_hub_angle - math.acos(bare.workpart_depth / TIP)) / speed)
        ]
        for tool, event, expected in tried + [
            (each, "bar touch", first_bar_touch(each)) for each in bars
        ]:
            run = simulate(tool, settings, stop_after=event)
            at = run.event_time(event)
            late.append(math.inf if at is None else at / expected - 1.0)
            steps += run.cost.steps
    met = Finding(f"{sum(map(math.isfinite, late))} of {len(late)} met", True)
    return all_of(met, within(worst(late), accuracy, "off by", steps))


def long_run() -> Iterator[HardCase]:
    """Yield free swings over up to a thousand turns of the hub, at two accuracies."""
    promise = "energy in the hub's frame changes by {0:g} a turn at most, the requested accuracy"
    for n, e in ((10, 1e-9), (1000, 1e-6)):
        name = f"{n} hub turns, accuracy {e:g}"
        yield row("long_run", name, promise.format(e), _swings, e, n, quick=n == 10)


def _swings(accuracy: float, turns: int) -> Finding:
    """Check that Jacobi's integral of the rotating frame is conserved.

    It is I alpha'^2/2 + k alpha^2/2 + m r_h (L/2) omega^2 (1 - cos alpha). The limit is
    ``accuracy`` a turn of the hub.
    """
    settings = Settings(
        accuracy, maximum_steps=10**9, hub_turn=turns * math.tau, samples_per_period=6
    )
    run = simulate(FREE, settings, **RELEASED)
    bristle = FREE.bristle
    hub = FREE.hub
    field = bristle.mass * hub.radius * bristle.length * hub.speed**2
    turning = (
        bristle.inertia_about_root * run.relative_rate**2
        + FREE.belt.stiffness * run.relative_angle**2
    )
    energy = turning + field * (1.0 - np.cos(run.relative_angle))
    return all_of(
        within((energy[-1] / energy[0] - 1.0) / turns, accuracy, "change a turn", run.cost.steps),
        Finding(
            f"{run.hub_angle[-1] - run.hub_angle[0]:.9g} rad turned",
            run.stop_reason is StopReason.END,
        ),
    )


WIRE_LIMIT = 1e-5
"""Requested accuracy of a wire's pass, and limit of its relative difference from the reference."""


def wires() -> Iterator[HardCase]:
    """Yield passes of wires that bend, stiff and soft."""
    promise = f"the reference's, to {WIRE_LIMIT:g}"
    for links, factor in ((2, 1e2), (3, 1e-3)):
        tool = TOOL.replace(wire_links=links, wire_modulus=factor * TOOL.bristle.modulus)
        name = f"pass of {links} links to the strike, modulus times {factor:g}"
        given = (tool, WIRE_LIMIT)
        yield row(
            "wires",
            name,
            promise,
            agrees_with_reference,
            *given,
            stop_after="strike",
            quick=links > 2,
        )
