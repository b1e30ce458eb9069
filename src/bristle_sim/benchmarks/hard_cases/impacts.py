"""Impacts with coefficients at the ends of their ranges, and measures of a strike that other themes share."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, within, worst
from bristle_sim.benchmarks.hard_cases.measures import impacts_of
from bristle_sim.parameters import Bar, Contact, Surface, Tool, Workpart
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord

__all__ = ["LEAST_DIGIT", "agrees_in_time", "limits", "mirrored", "rate_difference", "struck"]

ACCURACY = 1e-6
"""Requested accuracy of contacts resolved in time; their outcome is the rigid-body limit to ten times that."""

LEAST_DIGIT = 0.1
"""Relative error that leaves no digit: where it is expected, a contact in time may also refuse in one line."""


def struck(chain: Chain, friction: float, restitution: float, law: str = "energetic") -> ChainStrike:
    """Return a chain's strike with the same friction in compression and restitution."""
    return strike(chain, Surface(friction, None, restitution), Contact(law), Settings(accuracy=ACCURACY))


def rate_difference(found: tuple[float, ...], expected: tuple[float, ...], before: tuple[float, ...]) -> float:
    """Return the largest difference of rates over the largest rate."""
    size = max(map(abs, (*before, *expected)))
    return worst((one - two) / size for one, two in zip(found, expected, strict=True))


def agrees_in_time(
    chain: Chain, friction: float, restitution: float, limit: float, *, may_refuse: bool = False
) -> Finding:
    """Compare a contact resolved in time with the rigid-body limit: its outcome, and its rates to a limit.

    Where the limit leaves no digit, any end by name that gains no energy is right, and a refusal in one line.
    """
    rigid = struck(chain, friction, restitution).contact
    may_refuse |= limit > LEAST_DIGIT
    try:
        timed = struck(chain, friction, restitution, "compliant")
    except ValueError as error:
        return Finding("refused in one line", may_refuse and "\n" not in str(error))
    outcome, after = timed.contact.outcome, timed.contact.rates_after
    if limit > LEAST_DIGIT:
        lossy = (timed.kinetic_energy_ratio or 0.0) <= 1.0 and bool(np.isfinite(after).all())
        return Finding(outcome, lossy and outcome in ("rebound", "no rebound", "stiction"), timed.steps)
    off = rate_difference(after, rigid.rates_after, rigid.rates_before)
    return all_of(Finding(outcome, outcome == rigid.outcome), within(off, limit, "off by", timed.steps))


LIMITS = {"energetic": 1e-12, "compliant": 10.0 * ACCURACY}
"""Limits of velocities and works, relative to those of the approach: rounding, or ten times the requested accuracy."""

MIRRORED = 1e-12
"""Limit of differences between mirrored strikes: rounding."""

ANGLE = -math.radians(30.0)

CHAINS = {
    "single rod": Chain((5.0,), (1.0,), (ANGLE,), (0.2,)),
    "radial bristle on a hub": Chain((8.387e-5,), (0.027,), (ANGLE,), (845.6,), 0.0275, 261.8, ANGLE),
    "two rods": Chain((5.0, 5.0), (1.0, 1.0), (-math.radians(20.0), ANGLE), (0.1, 0.2)),
}
"""Chains that strike. Single rods jam with friction from tan 30 deg on; two slip, stick or reverse as friction is small or
large."""

FRICTIONS = (0.0, 0.3, 1e6, 1e9)


def limits() -> list[HardCase]:
    """Return strikes and passes with restitution 0 and 1 and friction from 0 to 1e9, by both laws."""
    rows = []
    for law, limit in LIMITS.items():
        timed = "" if law == "energetic" else ", in time"
        works = f"restitution returns e*^2 of the work of compression; no energy gained, to {limit:g}"
        for e in (0.0, 1.0):
            for mu in FRICTIONS:
                for word, chain in CHAINS.items():
                    name = f"{word}, restitution {e:g}, friction {mu:g}{timed}"
                    rows.append(HardCase("limits", name, works, partial(_obeys, chain, e, mu, law), mu != 1e6))
                tool = Tool(bar=Bar(restitution=e), workpart=Workpart(mu, None, e), contact=Contact(law))
                name = f"whole pass, restitution {e:g}, friction {mu:g}{timed}"
                rows.append(HardCase("limits", name, works, partial(_pass_obeys, tool, e, limit), mu != 1e6))
            for word, chain in CHAINS.items():
                promise = f"the mirrored result, at any friction: equal words, numbers to {MIRRORED:g}"
                mirror = partial(_mirrors, chain, e, law)
                rows.append(HardCase("limits", f"{word}, restitution {e:g}, mirrored{timed}", promise, mirror))
            rough = Tool(bar=Bar(friction=1e6, restitution=e), contact=Contact(law))
            promise = f"{works}; jams at the bar, and the run ends there by that name"
            name = f"bar's friction 1e+06, restitution {e:g}{timed}"
            rows.append(HardCase("limits", name, promise, partial(_pass_obeys, rough, e, limit, "jam")))
    return rows


def _obeys(chain: Chain, restitution: float, friction: float, law: str) -> Finding:
    hit, limit = struck(chain, friction, restitution, law), LIMITS[law]
    contact = hit.contact
    found = [_obeys_law(contact, restitution, limit), Finding(contact.outcome, True, hit.steps)]
    if restitution == 0.0 and contact.outcome != "jam":
        found.append(within(contact.velocity_after[0] / contact.velocity_before[0], limit, "normal velocity after"))
    if hit.kinetic_energy_ratio is not None and not chain.hub_radius:
        gained = max(0.0, hit.kinetic_energy_ratio - 1.0)
        found.append(within(gained, limit, "energy ratio above 1"))
        if friction == 0.0 and restitution == 1.0:
            found.append(within(hit.kinetic_energy_ratio - 1.0, limit, "energy ratio less 1"))
    return all_of(*found)


def _obeys_law(contact: ContactRecord, restitution: float, limit: float) -> Finding:
    """Compare the work of restitution with e*^2 of the normal work of compression, and the sum of works with 0.

    A point that no impulse can part from the surface, and one that never came to rest, may return less.
    """
    assert contact.compressive_work is not None
    assert contact.restitutive_work is not None
    taken, rubbed, returned, later = (*contact.compressive_work, *contact.restitutive_work)
    size = -taken if taken else 1.0
    beyond = (returned + restitution**2 * taken) / size
    if contact.outcome in ("stiction", "jam"):
        beyond = max(beyond, 0.0)
    gained = max(0.0, (taken + rubbed + returned + later) / size)
    return all_of(within(beyond, limit, "off the law by"), within(gained, limit, "gained"))


def _pass_obeys(tool: Tool, restitution: float, limit: float, end: str | None = None) -> Finding:
    """Hold every impact of a pass to the law; the pass strikes the workpart, or ends for the given reason."""
    run = simulate(tool, Settings(accuracy=ACCURACY, maximum_steps=200_000))
    hits = impacts_of(run)
    off = [_obeys_law(each, restitution, limit) for each in hits]
    broken = [each.reached for each in off if not each.ok]
    law = Finding(f"{len(hits)} impacts, {broken[0] if broken else 'all by the law'}", not broken, run.cost.steps)
    last = run.contacts[-1]
    if end is not None:
        return all_of(law, Finding(f"{last.obstacle}: {last.outcome}", last.outcome == run.stop_reason == end))
    first = run.first_contact("workpart")
    return all_of(law, Finding(f"workpart: {first.outcome if first else 'not struck'}", first is not None))


def mirrored(chain: Chain) -> Chain:
    """Return the chain as seen in a mirror on the surface's normal."""
    return replace(
        chain,
        angles=tuple(-angle for angle in chain.angles),
        rates=tuple(-rate for rate in chain.rates),
        hub_speed=-chain.hub_speed,
        hub_angle=-chain.hub_angle,
    )


def _mirrors(chain: Chain, restitution: float, law: str) -> Finding:
    off, alike, steps = [], True, 0
    for friction in FRICTIONS:
        hit, image = (struck(each, friction, restitution, law) for each in (chain, mirrored(chain)))
        one, two = hit.contact, image.contact
        alike &= (one.outcome, one.phases) == (two.outcome, two.phases)
        off.append(rate_difference(tuple(-rate for rate in two.rates_after), one.rates_after, one.rates_before))
        (push, rub), size = one.impulse, max(map(abs, one.impulse))
        off += [(push - two.impulse[0]) / size, (rub + two.impulse[1]) / size]
        steps += hit.steps
    words = Finding(f"words {'equal' if alike else 'different'}", alike)
    return all_of(within(worst(off), MIRRORED, "off by", steps), words)
