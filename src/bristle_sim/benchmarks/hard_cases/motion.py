"""Motion where it is hard: belts, damping, hub speeds, sizes, thin bars, long runs, small budgets, wires that bend."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, row, within, worst
from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    AS_REFERENCE,
    RELEASED,
    agrees_with_energy_integral,
    agrees_with_reference,
    spends_budget,
)
from bristle_sim.parameters import Bar, Belt, Hub, Tool
from bristle_sim.scene.contact.obstacles import LEAST_REACH
from bristle_sim.scene.simulate import simulate
from bristle_sim.scene.tool import START
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason

TOOL, FREE = Tool(), Tool(bar=None, workpart=None)

FINE = 1e-9
"""Accuracy of runs that are requested a thousand times more accurate."""

BUDGET = 20_000
"""Engine steps of a run that is to spend them."""

CLOSED_FORM = "highest speed and its time as by the energy integral to {:g}, the requested accuracy"
SPENT = "says that its step budget is spent"


def belt_stiffness() -> Iterator[HardCase]:
    """Yield the release and the whole pass, over nine decades of stiffness."""
    case = partial(row, "belt_stiffness")
    belts = {factor: Belt(stiffness=factor * Belt().stiffness) for factor in (1e-3, 1.0, 10.0, 1e3, 1e6)}
    for factor, accuracy in ((1e-3, ACCURACY), (1.0, ACCURACY), (1e6, FINE)):
        name, free = f"belt x {factor:g}: released, accuracy {accuracy:g}", replace(FREE, belt=belts[factor])
        yield case(name, CLOSED_FORM.format(accuracy), agrees_with_energy_integral, free, accuracy)
    for factor in (1e-3, 10.0, 1e3):
        name, whole, quick = f"belt x {factor:g}: whole pass", Tool(belt=belts[factor]), factor < 1e3
        yield case(name, AS_REFERENCE.format(ACCURACY), agrees_with_reference, whole, quick=quick)
    yield case("belt x 1e+06: whole pass", SPENT, spends_budget, Tool(belt=belts[1e6]), BUDGET)


def damping() -> Iterator[HardCase]:
    """Yield decays compared with their closed form and whole passes, for ratios up to 1000."""
    case = partial(row, "damping")
    promise = f"angle and rate as in closed form to {ACCURACY:g}, the requested accuracy; energy rises by no more"
    for ratio in (0.5, 1.0, 100.0):
        yield case(f"ratio {ratio:g}: decay", promise, _decays, ratio)
    for ratio in (0.5, 10.0):
        tool = Tool(belt=Belt(damping_ratio=ratio))
        yield case(f"ratio {ratio:g}: whole pass", AS_REFERENCE.format(ACCURACY), agrees_with_reference, tool)
    yield case("ratio 1000: whole pass", SPENT, spends_budget, Tool(belt=Belt(damping_ratio=1e3)), BUDGET)


def damped_decay(ratio: float, phase: Array) -> tuple[Array, Array]:
    """Return angle over its start and rate over start times natural rate, released from rest, at natural rate times time.

    With s = sqrt(zeta^2 - 1), e^(-zeta p) (cosh(s p) + zeta sinh(s p)/s) and -e^(-zeta p) sinh(s p)/s. The slow exponent is
    written without the difference -zeta + s, which would lose its digits; a critical ratio is 1 + 1e-12, so that s is not 0.
    """
    ratio = 1.0 + 1e-12 if ratio == 1.0 else ratio
    root = cmath.sqrt((ratio - 1.0) * (ratio + 1.0))
    slow, fast = np.exp(-phase / (ratio + root)), np.exp(-phase * (ratio + root))
    even, odd = 0.5 * (slow + fast), 0.5 * (slow - fast) / root
    return (even + ratio * odd).real, -odd.real


def _decays(ratio: float) -> Finding:
    """Release a bristle whose root is on the hub's axis, so that its decay is the damped oscillator's at any speed."""
    tool = replace(FREE, hub=Hub(radius=0.0), belt=Belt(damping_ratio=ratio))
    start, rate = RELEASED["start_relative_angle"], math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)
    # A tenth of the longest decay, which takes the more steps the more it is damped, shows as much.
    run = simulate(tool, Settings(hub_turn=0.47 if ratio > 50.0 else 4.7), **RELEASED)
    found = np.array([run.relative_angle / start, run.relative_rate / (start * rate)])
    off = np.abs(found - damped_decay(ratio, rate * run.time)).max()
    rise = float(np.diff((found**2).sum(axis=0)).max(initial=0.0))
    return all_of(within(float(off), ACCURACY, "off by", run.cost.steps), within(rise, ACCURACY, "energy rises by"))


def hub_speed() -> Iterator[HardCase]:
    """Yield the release and the whole pass on hubs at rest and up to 1e5 rad/s, with a belt and without."""
    case = partial(row, "hub_speed")
    for speed, accuracy in ((0.0, FINE), (1e5, ACCURACY)):
        name, free = f"{speed:g} rad/s: released, accuracy {accuracy:g}", replace(FREE, hub=Hub(speed=speed))
        yield case(name, CLOSED_FORM.format(accuracy), agrees_with_energy_integral, free, accuracy)
    for speed, belt in ((0.0, Belt()), (1e3, Belt()), (1e5, Belt()), (1e-3, Belt(stiffness=0.0))):
        name, tool = f"{speed:g} rad/s: whole pass{'' if belt.stiffness else ', no belt'}", Tool(Hub(speed=speed), belt)
        yield case(name, AS_REFERENCE.format(ACCURACY), agrees_with_reference, tool)
    yield case("1e-300 rad/s: whole pass", SPENT, spends_budget, Tool(hub=Hub(speed=1e-300)), BUDGET)


SIZES = {"14 m, 1.4e3 kg": (2.0**9, 2.0**24, 2.0**5), "0.82 um, 1.2e-12 kg": (2.0**-15, 2.0**-26, 2.0**-8)}
"""Powers of two by which lengths, masses and times are multiplied: nothing is rounded, so that not a bit may differ."""


def size() -> Iterator[HardCase]:
    """Yield whole passes of tools of any size, rigid and resolved in time."""
    for name, factors in SIZES.items():
        for law, words in (("energetic", ""), ("compliant", ", in time")):
            yield row(
                "size", f"{name}: whole pass{words}", "the default's motion to the last bit", _scales, law, *factors
            )


def _scales(law: str, length: float, mass: float, time: float) -> Finding:
    """A rate goes as 1/t, a belt's stiffness as m l^2/t^2 and gravity as l/t^2."""
    one = TOOL.replace(gravity=3e3, contact=law)
    assert one.bar is not None
    assert one.workpart is not None
    other = one.replace(
        hub_speed=one.hub.speed / time,
        hub_radius=one.hub.radius * length,
        belt_stiffness=one.belt.stiffness * mass * (length / time) ** 2,
        bristle_length=one.bristle.length * length,
        bristle_mass=one.bristle.mass * mass,
        wire_diameter=one.bristle.wire_diameter * length,
        bar_radius=one.bar.radius * length,
        bar_horizontal=one.bar.horizontal * length,
        bar_vertical=one.bar.vertical * length,
        penetration=one.workpart.penetration * length,
        gravity=one.gravity * length / time**2,
    )
    first, second = simulate(one), simulate(other)
    same = np.array_equal(first.angles, second.angles) and np.array_equal(first.time * time, second.time)
    return Finding("the same bits" if same else "different", same, first.cost.steps + second.cost.steps)


def budget() -> Iterator[HardCase]:
    """Yield motions that need more engine steps than they have, in flight, in contact and in a contact resolved in time."""
    turns, soft = Settings(hub_turn=1e4), TOOL.replace(bar=None, contact="compliant", contact_duration=1e-3)
    for name, tool, steps, start in (
        ("flight", FREE, 1, RELEASED),
        ("pass", TOOL, 2000, {}),
        ("soft strike", soft, 10, {}),
    ):
        promise = f"{SPENT}, within an interval of it"
        yield row("budget", f"{name}; {steps} engine steps", promise, spends_budget, tool, steps, turns, start)


ROOT, TIP = TOOL.hub.radius, TOOL.hub.radius + TOOL.bristle.length
"""Radii of the circles of a radial bristle's root and tip, m."""

THINNEST = 1.001 * LEAST_REACH * TOOL.bristle.length
"""Radius of the thinnest bar that an infinitely thin wire may meet, m."""


def tunnelling() -> Iterator[HardCase]:
    """Yield every accuracy with every speed, and bars too thin to have a side.

    A straight bristle without gravity remains radial until it touches something, so that the instant is plain geometry.
    """
    case = partial(row, "tunnelling")
    for accuracy in (0.1, 1e-6, 1e-11):
        name = f"accuracy {accuracy:g}, hub 1 to 1e5 rad/s, bars from {THINNEST:.1g} m and the workpart"
        promise = f"all met, their instants right to {accuracy:g} of them, the requested accuracy"
        yield case(name, promise, _meets_at_accuracy, accuracy)
    radius, words = 0.9 * LEAST_REACH * TOOL.bristle.length, ("bar_radius + wire_diameter / 2", f"{LEAST_REACH:g}")
    thin = partial(simulate, with_bar_at(0.9 * TIP, radius))
    yield case(f"bar of {radius:.2g} m, wire of no width", "refused in one line", refusal, thin, *words)


def with_bar_at(distance: float, radius: float, speed: float = TOOL.hub.speed, angle: float = 1.2) -> Tool:
    """Return a tool with a bar at a distance (m), ``angle`` before the workpart's direction, and a wire of no width."""
    bar = Bar(radius=radius, horizontal=distance * math.sin(angle), vertical=distance * math.cos(angle))
    return TOOL.replace(hub_speed=speed, bar=bar, wire_diameter=0.0)


def first_bar_touch(tool: Tool, start: float = START) -> float:
    """Return when a radial bristle meets the bar, s: its end on the reach (law of cosines) or its flank (tangent)."""
    assert tool.bar is not None
    distance, reach = math.hypot(tool.bar.horizontal, tool.bar.vertical), tool.bar_reach
    if distance * distance - reach * reach > TIP * TIP:
        between = math.acos((distance**2 + TIP**2 - reach**2) / (2.0 * distance * TIP))
    else:
        between = math.asin(reach / distance)
    return (-start - math.atan2(tool.bar.horizontal, tool.bar.vertical) - between) / tool.hub.speed


def _meets_at_accuracy(accuracy: float) -> Finding:
    """Compare the instants at which runs meet bars and the workpart with geometry."""
    settings, late, steps = Settings(accuracy=accuracy, samples_per_period=1), list[float](), 0
    for speed in (1.0, 261.8, 1e5):
        bare = TOOL.replace(hub_speed=speed, bar=None)
        bars = [with_bar_at(0.9 * TIP, radius, speed) for radius in (THINNEST, 1e-6, 1e-3)]
        tried = [(bare, "strike", (-START - math.acos(bare.workpart_depth / TIP)) / speed)]
        for tool, event, expected in tried + [(each, "bar touch", first_bar_touch(each)) for each in bars]:
            run = simulate(tool, settings, stop_after=event)
            at = run.event_time(event)
            late.append(math.inf if at is None else at / expected - 1.0)
            steps += run.cost.steps
    return all_of(
        Finding(f"{sum(map(math.isfinite, late))} of {len(late)} met", True),
        within(worst(late), accuracy, "off by", steps),
    )


def long_run() -> Iterator[HardCase]:
    """Yield free swings over up to a thousand turns of the hub, at two accuracies."""
    promise = "energy in the hub's frame changes by {0:g} a turn at most, the requested accuracy"
    for n, e in ((10, 1e-9), (1000, 1e-6)):
        name = f"{n} hub turns, accuracy {e:g}"
        yield row("long_run", name, promise.format(e), _swings, e, n, quick=n == 10)


def jacobi_energy(tool: Tool, angle: Array, rate: Array) -> Array:
    """Return I alpha'^2/2 + k alpha^2/2 + m r_h l Omega^2 (1 - cos alpha) in J, from relative angle (rad) and rate (rad/s).

    It is Jacobi's integral of the rotating frame, with the inertia I about the root and the centre of mass at l from there.
    """
    bristle, hub = tool.bristle, tool.hub
    field = bristle.mass * hub.radius * math.hypot(*bristle.centre) * hub.speed**2
    elastic = bristle.inertia_about_root * rate**2 + tool.belt.stiffness * angle**2
    return np.asarray(0.5 * elastic + field * (1.0 - np.cos(angle)))


def _swings(accuracy: float, turns: int) -> Finding:
    settings = Settings(accuracy, maximum_steps=10**9, hub_turn=turns * math.tau, samples_per_period=6)
    run = simulate(FREE, settings, **RELEASED)
    energy = jacobi_energy(FREE, run.relative_angle, run.relative_rate)
    return all_of(
        within((energy[-1] / energy[0] - 1.0) / turns, accuracy, "change a turn", run.cost.steps),
        Finding(f"{run.hub_angle[-1] - run.hub_angle[0]:.9g} rad turned", run.stop_reason is StopReason.END),
    )


WIRE_LIMIT = 1e-5
"""Accuracy requested of a wire's pass, and its largest relative difference from the reference."""


def wires() -> Iterator[HardCase]:
    """Yield passes of wires that bend, stiff and soft."""
    for links, factor in ((2, 1e2), (3, 1e-3)):
        tool = TOOL.replace(wire_links=links, wire_modulus=factor * TOOL.bristle.modulus)
        name, promise = (
            f"pass of {links} links to the strike, modulus times {factor:g}",
            f"the reference's, to {WIRE_LIMIT:g}",
        )
        yield row("wires", name, promise, agrees_with_reference, tool, WIRE_LIMIT, stop_after="strike", quick=links > 2)
