"""Impacts with coefficients at the ends of their ranges, and measures of a strike that other themes share."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, all_of, row, within, worst
from bristle_sim.benchmarks.hard_cases.impacts import ANGLES, ROUNDING
from bristle_sim.benchmarks.hard_cases.measures import STRIKE_ACCURACY, impacts_of, obeys_law, rate_difference, struck
from bristle_sim.parameters import Bar, Contact, Tool, Workpart
from bristle_sim.scene.strike import Chain
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings

MIRRORED = 1e-12
"""Limit of differences between mirrored strikes: rounding."""

FRICTIONS = (0.0, 0.3, 1e6, 1e9)


LIMITS = {"energetic": ROUNDING, "compliant": 10.0 * STRIKE_ACCURACY}
"""Limits of velocities and works, relative to those of the approach: rounding, or ten times the requested accuracy."""

CHAINS = {
    "single rod": Chain((5.0,), (1.0,), ANGLES[1:], (0.2,)),
    "radial bristle on a hub": Chain((8.387e-5,), (0.027,), ANGLES[1:], (845.6,), 0.0275, 261.8, ANGLES[1]),
    "two rods": Chain((5.0, 5.0), (1.0, 1.0), ANGLES, (0.1, 0.2)),
}
"""Chains that strike. Single rods jam with friction from tan 30 deg on; two slip, stick or reverse as friction is small or
large."""


def limits() -> list[HardCase]:
    """Return strikes and passes with restitution 0 and 1 and friction from 0 to 1e9, and mirrored strikes, by both laws."""
    rows, case = [], partial(row, "limits")
    for law, limit in LIMITS.items():
        timed = "" if law == "energetic" else ", in time"
        works = f"restitution returns e*^2 of the work of compression; no energy gained, to {limit:g}"
        for e in (0.0, 1.0):
            for mu in (0.0, 0.3, 1e9):
                for word, chain in CHAINS.items():
                    name = f"{word}, restitution {e:g}, friction {mu:g}{timed}"
                    rows.append(case(name, works, _obeys, chain, e, mu, law))
                tool = Tool(bar=Bar(restitution=e), workpart=Workpart(mu, None, e), contact=Contact(law))
                name = f"whole pass, restitution {e:g}, friction {mu:g}{timed}"
                rows.append(case(name, works, _pass_obeys, tool, e, limit))
            for word, chain in CHAINS.items():
                promise = f"the mirrored result, at any friction: equal words, numbers to {MIRRORED:g}"
                rows.append(case(f"{word}, restitution {e:g}, mirrored{timed}", promise, _mirrors, chain, e, law))
            rough = Tool(bar=Bar(friction=1e6, restitution=e), contact=Contact(law))
            promise = f"{works}; jams at the bar, and the run ends there by that name"
            name = f"bar's friction 1e+06, restitution {e:g}{timed}"
            rows.append(case(name, promise, _pass_obeys, rough, e, limit, "jam"))
    return rows


def _obeys(chain: Chain, restitution: float, friction: float, law: str) -> Finding:
    hit, limit = struck(chain, friction, restitution, law), LIMITS[law]
    contact = hit.contact
    found = [obeys_law(contact, restitution, limit), Finding(contact.outcome, True, hit.steps)]
    if restitution == 0.0 and contact.outcome != "jam":
        found.append(within(contact.velocity_after[0] / contact.velocity_before[0], limit, "normal velocity after"))
    if hit.kinetic_energy_ratio is not None and not chain.hub_radius:
        found.append(within(max(0.0, hit.kinetic_energy_ratio - 1.0), limit, "energy ratio above 1"))
    return all_of(*found)


def _pass_obeys(tool: Tool, restitution: float, limit: float, end: str | None = None) -> Finding:
    """Compare every impact of a pass with the law; the pass strikes the workpart, or ends for the given reason."""
    run = simulate(tool, Settings(accuracy=STRIKE_ACCURACY, maximum_steps=200_000))
    hits = impacts_of(run)
    off = [obeys_law(each, restitution, limit) for each in hits]
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
