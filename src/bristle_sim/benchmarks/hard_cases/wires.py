"""Wires that bend and wires that touch each other where it is hard: stiff, soft, of many or of unequal links, nearly parallel."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row, within, worst
from bristle_sim.benchmarks.hard_cases.measures import (
    agrees_with_reference,
    end_difference,
    obeys_law,
    strike_difference,
    struck,
)
from bristle_sim.parameters import Bristle, ContactStiffness, Strike, Tool, Workpart
from bristle_sim.scene.strike import Chain
from bristle_sim.scene.tool import simulate_row
from bristle_sim.settings import Settings
from bristle_sim.studies.flexible_wire import FlexibleStrike
from bristle_sim.trajectory import ContactRecord

STEEL = Bristle().modulus

LIMIT = 1e-5
"""Largest relative difference from the reference: ten times the accuracy requested of strikes, 1e-6, and that requested of passes;
wires that are nearly parallel magnify errors, and are run to 1e-8."""

ANGLE = math.radians(Strike().impact_angle_deg)
RATE = Strike().speed_ratio * Tool().hub.speed

LENGTHS = (1.0, 0.1, 1.0, 0.1)


def wires() -> Iterator[HardCase]:
    """Yield strikes and passes of wires of links, and two wires that are nearly parallel."""
    case = partial(row, "wires")
    strikes = f"impulse, peak force and time in touch of the reference, to {LIMIT:g}"
    for links, factor in ((4, 1e3), (8, 1e-3), (8, 1e-6), (32, 1.0)):
        name = f"strike of {links} links, modulus times {factor:g}"
        yield case(name, strikes, _strikes, links, factor, quick=links < 32)
    same = f"the reference's end and strike, to {LIMIT:g}"
    for links, factor, quick in ((2, 1e2, False), (3, 1e-3, True)):
        tool = Tool(bristle=Bristle(links=links, modulus=factor * STEEL))
        name = f"pass of {links} links to the strike, modulus times {factor:g}"
        yield case(name, same, agrees_with_reference, tool, LIMIT, stop_after="strike", quick=quick)
    law = "restitution returns e*^2 of the work of compression, no energy gained, to 1e-9"
    yield case("strike of rods of lengths 1, 0.1, 1, 0.1", law, _unequal, LENGTHS)
    yield case("strike of rods of lengths 1, 1e-3, 1, 1e-3", law, _unequal, tuple(each**3 for each in LENGTHS))
    yield case("two bristles 3 deg apart, nearly parallel", same, _nearly_parallel, 3.0)


def _strikes(links: int, factor: float) -> Finding:
    """Strike a contact of the stiffness of the rigid bristle's, radially, in the scene and in the reference."""
    reach = Tool().hub.radius + Tool().bristle.length
    part = Workpart(friction=0.0, penetration=reach * (1.0 - math.cos(ANGLE)))
    tool = Tool(bristle=Bristle(links=links, modulus=factor * STEEL), bar=None, workpart=part)
    strike = FlexibleStrike(tool, ANGLE, RATE, ContactStiffness(), Settings())
    found = strike.run()
    ours, theirs = (measures(each) for each in (found.contact, strike.reference()))
    return within(worst(ours / theirs - 1.0), LIMIT, "off by", found.steps)


def measures(contact: ContactRecord) -> Array:
    """Return impulse, peak force and time in touch of a contact resolved in time."""
    assert contact.history is not None
    return np.array([contact.impulse[0], contact.history.normal_force.max(), contact.duration])


def _unequal(lengths: tuple[float, ...]) -> Finding:
    """Strike with rods of masses in proportion to their lengths."""
    angles, rates = (-0.4, -0.7, -0.2, -0.5), (1.0, 0.5, 2.0, 1.0)
    hit = struck(Chain(lengths, lengths, angles, rates), 0.3, 0.5)
    rebounds = Finding(hit.contact.outcome, hit.contact.outcome == "rebound", hit.steps)
    return all_of(obeys_law(hit.contact, 0.5, 1e-9), rebounds)


def _nearly_parallel(pitch_deg: float) -> Finding:
    """Let two rigid bristles touch each other along their flanks up to the strike, in the scene and in the reference."""
    from bristle_sim.reference import simulate_row_reference

    surface = {"neighbour_friction": 0.2, "neighbour_restitution": 0.5}
    given: dict[str, Any] = {"bristles": 2, "pitch": math.radians(pitch_deg), "stop_after": "strike", **surface}
    runs = simulate_row(Tool(), Settings(accuracy=1e-8), **given)
    others = simulate_row_reference(Tool(), accuracy=1e-10, **given)
    pairs = list(zip(runs, others, strict=True))
    off = worst(each for pair in pairs for each in (*end_difference(*pair), *strike_difference(*pair)))
    touches = sum(each.obstacle == "wire" for each in runs[0].contacts)
    return all_of(Finding(f"{touches} touches", touches > 0), within(off, LIMIT, "off by", runs[0].cost.steps))
