"""Motion where it is hard: belts, damping, hub speeds, sizes, thin bars, long runs, small budgets, wires that bend."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, refusal, row, within, worst
from bristle_sim.benchmarks.hard_cases.measures import (
    ACCURACY,
    RELEASED,
    agrees_with_energy_integral,
    agrees_with_reference,
    meets,
    spends_budget,
)
from bristle_sim.parameters import Bar, Belt, Bristle, Contact, ContactStiffness, Hub, Strike, Tool, Workpart
from bristle_sim.scene.contact.obstacles import LEAST_REACH
from bristle_sim.scene.tool import START, simulate
from bristle_sim.settings import Settings
from bristle_sim.stop_reason import StopReason
from bristle_sim.studies.flexible_wire import FlexibleStrike
from bristle_sim.trajectory import ContactRecord

TOOL, FREE = Tool(), Tool(bar=None, workpart=None)

FINE = 1e-9
"""Accuracy of runs that are requested a thousand times more accurate."""

BUDGET = 20_000
"""Engine steps of a run that is to spend them."""

CLOSED_FORM = "highest speed and its time as by the energy integral to {:g}, the requested accuracy"
AS_REFERENCE = f"strike and end as in the reference to {ACCURACY:g}, the requested accuracy"
SPENT = "says that its step budget is spent"


def belt_stiffness() -> Iterator[HardCase]:
    """Yield the release and the whole pass, over nine decades of stiffness."""
    case = partial(row, "belt_stiffness")
    for factor, accuracy in ((1e-3, ACCURACY), (1.0, ACCURACY), (1.0, FINE), (1e6, ACCURACY)):
        name, free = f"belt x {factor:g}: released, accuracy {accuracy:g}", replace(FREE, belt=_belt(factor))
        yield case(name, CLOSED_FORM.format(accuracy), agrees_with_energy_integral, free, accuracy)
    for factor in (1e-3, 10.0, 1e3):
        name, whole = f"belt x {factor:g}: whole pass", Tool(belt=_belt(factor))
        yield case(name, AS_REFERENCE, agrees_with_reference, whole, quick=factor < 1e3)
    yield case("belt x 1e+06: whole pass", SPENT, spends_budget, Tool(belt=_belt(1e6)), BUDGET)


def _belt(factor: float) -> Belt:
    return Belt(stiffness=factor * Belt().stiffness)


def damping() -> Iterator[HardCase]:
    """Yield decays compared with their closed form and whole passes, for ratios up to 1000."""
    case = partial(row, "damping")
    promise = f"angle and rate as in closed form to {ACCURACY:g}, the requested accuracy; energy rises by no more"
    for ratio in (0.5, 1.0, 100.0):
        yield case(f"ratio {ratio:g}: decay", promise, _decays, ratio)
    for ratio in (0.5, 10.0):
        tool = Tool(belt=Belt(damping_ratio=ratio))
        yield case(f"ratio {ratio:g}: whole pass", AS_REFERENCE, agrees_with_reference, tool)
    highest = Tool(belt=Belt(damping_ratio=1e3))
    yield case("ratio 1000: whole pass", SPENT, spends_budget, highest, BUDGET)


def damped_decay(ratio: float, phase: Array) -> tuple[Array, Array]:
    """Return angle over its start and rate over start times natural rate, released from rest, at natural rate times time.

    With s = sqrt(zeta^2 - 1), e^(-zeta p) (cosh(s p) + zeta sinh(s p)/s) and -e^(-zeta p) sinh(s p)/s. The two exponents are
    written without the difference -zeta + s, which would lose the slow one's digits.
    """
    square = (ratio - 1.0) * (ratio + 1.0)
    root = math.sqrt(abs(square))
    if not square:
        even, odd, fading = np.ones_like(phase), phase, np.exp(-phase)
    elif square < 0.0:
        even, odd, fading = np.cos(root * phase), np.sin(root * phase) / root, np.exp(-ratio * phase)
    else:
        slow, fast = np.exp(-phase / (ratio + root)), np.exp(-phase * (ratio + root))
        even, odd, fading = 0.5 * (slow + fast), 0.5 * (slow - fast) / root, np.ones_like(phase)
    return fading * (even + ratio * odd), -fading * odd


def _decays(ratio: float) -> Finding:
    """Release a bristle whose root is on the hub's axis, so that its decay is the damped oscillator's at any speed."""
    tool = replace(FREE, hub=Hub(radius=0.0), belt=Belt(damping_ratio=ratio))
    start, rate = RELEASED["start_relative_angle"], math.sqrt(tool.belt.stiffness / tool.bristle.inertia_about_root)
    # A tenth of the longest decay, which takes the more steps the more it is damped, shows as much.
    run = simulate(tool, Settings(hub_turn=0.47 if ratio > 50.0 else 4.7), **RELEASED)
    angle, speed = run.relative_angle / start, run.relative_rate / (start * rate)
    exact_angle, exact_speed = damped_decay(ratio, rate * run.time)
    off = worst([np.abs(angle - exact_angle).max(), np.abs(speed - exact_speed).max()])
    return all_of(
        within(off, ACCURACY, "off by", run.cost.steps),
        within(float(np.diff(angle**2 + speed**2).max(initial=0.0)), ACCURACY, "energy rises by"),
    )


def hub_speed() -> Iterator[HardCase]:
    """Yield the release and the whole pass on hubs at rest and up to 1e5 rad/s, with a belt and without."""
    case = partial(row, "hub_speed")
    for speed, accuracy in ((0.0, FINE), (1e-3, ACCURACY), (1e5, ACCURACY)):
        name, free = f"{speed:g} rad/s: released, accuracy {accuracy:g}", replace(FREE, hub=Hub(speed=speed))
        yield case(name, CLOSED_FORM.format(accuracy), agrees_with_energy_integral, free, accuracy)
    still = f"remains where it is to {ACCURACY:g}; touches nothing"
    yield case("0 rad/s: whole pass", still, _remains)
    for speed, belt in ((1e3, Belt()), (1e5, Belt()), (1e-3, Belt(stiffness=0.0))):
        name, tool = f"{speed:g} rad/s: whole pass{'' if belt.stiffness else ', no belt'}", Tool(Hub(speed=speed), belt)
        yield case(name, AS_REFERENCE, agrees_with_reference, tool)
    yield case("1e-300 rad/s: whole pass", SPENT, spends_budget, Tool(hub=Hub(speed=1e-300)), BUDGET)


def _remains() -> Finding:
    run = simulate(Tool(hub=Hub(speed=0.0)))
    rate = math.sqrt(TOOL.belt.stiffness / TOOL.bristle.inertia_about_root)
    moved = worst([np.abs(run.relative_angle).max(), np.abs(run.relative_rate).max() / rate])
    names = [event.name for event in run.events]
    told = Finding(", ".join(names), names == ["bar not touched", "workpart not reached"] and not run.contacts)
    return all_of(within(moved, ACCURACY, "moved by", run.cost.steps), told)


SIZES = {"14 m, 1.4e3 kg": (2.0**9, 2.0**24, 2.0**5), "0.82 um, 1.2e-12 kg": (2.0**-15, 2.0**-26, 2.0**-8)}
"""Powers of two by which lengths, masses and times are multiplied: nothing is rounded, so that not a bit may differ."""


def size() -> Iterator[HardCase]:
    """Yield whole passes of tools of any size, rigid and resolved in time."""
    for name, factors in SIZES.items():
        for contact in (Contact(), Contact("compliant")):
            what = f"{name}: whole pass" + (", in time" if contact.law == "compliant" else "")
            yield row("size", what, "the default's motion to the last bit", _scales, contact, *factors)


def _scales(contact: Contact, length: float, mass: float, time: float) -> Finding:
    """A rate goes as 1/t, a belt's stiffness as m l^2/t^2 and gravity as l/t^2."""
    one = replace(TOOL, gravity=3e3, contact=contact)
    assert one.bar is not None
    assert one.workpart is not None
    names = {"bar": ("radius", "horizontal", "vertical"), "bristle": ("length", "wire_diameter")}
    bar, bristle = (
        replace(getattr(one, part), **{name: length * getattr(getattr(one, part), name) for name in keys})
        for part, keys in names.items()
    )
    other = Tool(
        Hub(one.hub.speed / time, one.hub.radius * length),
        Belt(one.belt.stiffness * mass * (length / time) ** 2),
        replace(bristle, mass=bristle.mass * mass),
        bar,
        replace(one.workpart, penetration=one.workpart.penetration * length),
        contact,
        one.gravity * length / time**2,
    )
    first, second = simulate(one), simulate(other)
    same = np.array_equal(first.angles, second.angles) and np.array_equal(first.time * time, second.time)
    return Finding("the same bits" if same else "different", same, first.cost.steps + second.cost.steps)


def budget() -> Iterator[HardCase]:
    """Yield motions that need more engine steps than they have, in flight, in contact and in a contact resolved in time."""
    turns = Settings(hub_turn=1e4)
    soft = Tool(bar=None, contact=Contact("compliant", duration=1e-3))
    for name, tool, budgets in (("flight", FREE, (1,)), ("pass", TOOL, (2000,)), ("soft strike", soft, (10,))):
        for steps in budgets:
            given = partial(spends_budget, tool, steps, settings=turns, start=RELEASED if name == "flight" else None)
            yield row("budget", f"{name}; {steps} engine steps", f"{SPENT}, within an interval of it", given)


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
    words = ("bar_radius + wire_diameter / 2", f"{LEAST_REACH:g}")
    for radius in (0.9 * LEAST_REACH * TOOL.bristle.length,):
        thin = partial(simulate, with_bar_at(0.9 * TIP, radius))
        yield case(f"bar of {radius:.2g} m, wire of no width", "refused in one line", refusal, thin, *words)


def with_bar_at(distance: float, radius: float, speed: float = TOOL.hub.speed, angle: float = 1.2) -> Tool:
    """Return a tool with a bar at a distance (m), ``angle`` before the workpart's direction, and a wire of no width."""
    bar = Bar(radius=radius, horizontal=distance * math.sin(angle), vertical=distance * math.cos(angle))
    return replace(TOOL, hub=Hub(speed=speed), bar=bar, bristle=replace(TOOL.bristle, wire_diameter=0.0))


def first_bar_touch(tool: Tool, start: float = START) -> float:
    """Return when a radial bristle meets the bar, s: its end on the reach (law of cosines) or its flank (tangent)."""
    assert tool.bar is not None
    distance, reach = math.hypot(tool.bar.horizontal, tool.bar.vertical), tool.bar_reach
    if distance * distance - reach * reach > TIP * TIP:
        between = math.acos((distance**2 + TIP**2 - reach**2) / (2.0 * distance * TIP))
    else:
        between = math.asin(reach / distance)
    return (-start - math.atan2(tool.bar.horizontal, tool.bar.vertical) - between) / tool.hub.speed


def all_met(met: list[Finding]) -> Finding:
    """Join findings of many runs into one, which names the first that missed."""
    missed = [each.reached for each in met if not each.ok]
    told = f"{len(met) - len(missed)} of {len(met)} met" + (f"; {missed[0]}" if missed else "")
    return Finding(told, not missed, sum(each.steps for each in met))


def _meets_at_accuracy(accuracy: float) -> Finding:
    settings, met = Settings(accuracy=accuracy, samples_per_period=1), []
    for speed in (1.0, 261.8, 1e5):
        for radius in (THINNEST, 1e-6, 1e-3):
            tool = with_bar_at(0.9 * TIP, radius, speed)
            expected = first_bar_touch(tool)
            met.append(meets(tool, settings, "bar touch", expected, accuracy * expected))
        bare = replace(TOOL, hub=Hub(speed=speed), bar=None)
        expected = (-START - math.acos(bare.workpart_depth / TIP)) / speed
        met.append(meets(bare, settings, "strike", expected, accuracy * expected))
    return all_met(met)


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


LIMIT = 1e-5
"""Largest relative difference from the reference: ten times the accuracy requested of strikes, 1e-6, and that of passes."""


def wires() -> Iterator[HardCase]:
    """Yield strikes and passes of wires that bend: stiff, soft, of many links."""
    case = partial(row, "wires")
    promise = f"impulse, peak force and time in touch of the reference, to {LIMIT:g}"
    for links, factor in ((4, 1e3), (8, 1e-6), (32, 1.0)):
        name = f"strike of {links} links, modulus times {factor:g}"
        yield case(name, promise, _strikes, links, factor, quick=links < 32)
    for links, factor, quick in ((2, 1e2, False), (3, 1e-3, True)):
        tool, given = Tool(bristle=_wire(links, factor)), {"stop_after": "strike"}
        name, promise = (
            f"pass of {links} links to the strike, modulus times {factor:g}",
            f"the reference's, to {LIMIT:g}",
        )
        yield case(name, promise, agrees_with_reference, tool, LIMIT, quick=quick, **given)


def _wire(links: int, factor: float) -> Bristle:
    return Bristle(links=links, modulus=factor * Bristle().modulus)


def _strikes(links: int, factor: float) -> Finding:
    """Strike a contact of the stiffness of the rigid bristle's, radially, in the scene and in the reference."""
    angle, rate = math.radians(Strike().impact_angle_deg), Strike().speed_ratio * TOOL.hub.speed
    part = Workpart(friction=0.0, penetration=TIP * (1.0 - math.cos(angle)))
    tool = Tool(bristle=_wire(links, factor), bar=None, workpart=part)
    strike = FlexibleStrike(tool, angle, rate, ContactStiffness(), Settings())
    found = strike.run()
    ours, theirs = (_measures(each) for each in (found.contact, strike.reference()))
    return within(worst(ours / theirs - 1.0), LIMIT, "off by", found.steps)


def _measures(contact: ContactRecord) -> Array:
    """Return impulse, peak force and time in touch of a contact resolved in time."""
    assert contact.history is not None
    return np.array([contact.impulse[0], contact.history.normal_force.max(), contact.duration])
