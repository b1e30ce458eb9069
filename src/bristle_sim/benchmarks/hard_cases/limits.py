"""Coefficients at the ends of their ranges: restitution 0 and 1, friction 0 and huge."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from bristle_sim.benchmarks.hard_cases.case import Finding, HardCase, both, within, worst
from bristle_sim.parameters import Bar, Contact, Surface, Tool, Workpart
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.scene.tool import simulate
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord

__all__ = ["CHAINS", "cases", "mirrored"]

THEME = "limits"

ACCURACY = 1e-6

LIMITS = {"energetic": 1e-12, "compliant": 10.0 * ACCURACY}
"""Of velocities and works relative to those of the approach: rounding, or ten times the accuracy asked for."""

_ANGLE = -math.radians(30.0)

CHAINS = {
    "single rod": Chain((5.0,), (1.0,), (_ANGLE,), (0.2,)),
    "radial bristle on a hub": Chain((8.387e-5,), (0.027,), (_ANGLE,), (845.6,), 0.0275, 261.8, _ANGLE),
    "two rods": Chain((5.0, 5.0), (1.0, 1.0), (-math.radians(20.0), _ANGLE), (0.1, 0.2)),
}
"""What strikes. Single rods jam with friction from tan 30 deg on; two slip, stick or reverse as friction is small or large."""

FRICTIONS = (0.0, 0.3, 1e6, 1e9)

HIGHEST_OF_BAR = 1e6
"""Friction that a bar may have."""


def cases(full: bool) -> tuple[HardCase, ...]:
    """Everything that strikes with each coefficient at both its ends, by both laws; in full with more frictions."""
    frictions = FRICTIONS if full else (FRICTIONS[0], FRICTIONS[1], FRICTIONS[-1])
    single = [(word, mu, law) for law in LIMITS for word in CHAINS for mu in frictions]
    passes = [(e, mu, law) for law in LIMITS for e in (0.0, 1.0) for mu in frictions]
    return (
        *(_dead(*each) for each in single),
        *(_smooth(word, law) for law in LIMITS for word in CHAINS),
        *(_rough(*each) for each in single if each[1]),
        *(_mirrored(word, e, law) for law in LIMITS for word in CHAINS for e in (0.0, 1.0)),
        *(_pass(*each) for each in passes),
        *(_rough_bar(e, law) for law in LIMITS for e in (0.0, 1.0)),
    )


def _hit(chain: Chain, friction: float, restitution: float, law: str) -> ChainStrike:
    return strike(chain, Surface(friction, None, restitution), Contact(law), Settings(accuracy=ACCURACY))


def _name(law: str) -> str:
    return "" if law == "energetic" else ", in time"


def _dead(word: str, friction: float, law: str) -> HardCase:
    def measure() -> Finding:
        one = _hit(CHAINS[word], friction, 0.0, law)
        share = one.contact.velocity_after[0] / one.contact.velocity_before[0]
        return within(share, LIMITS[law], "normal velocity after over before", one.steps)

    return HardCase(
        THEME,
        f"{word}, no restitution, friction {friction:g}{_name(law)}",
        f"leaves with no normal velocity to {LIMITS[law]:g}",
        measure,
    )


def _smooth(word: str, law: str) -> HardCase:
    def measure() -> Finding:
        one = _hit(CHAINS[word], 0.0, 1.0, law)
        change = sum(_works(one.contact)) / one.contact.compressive_work[0]  # type: ignore[index]
        told = within(change, LIMITS[law], "works left over", one.steps)
        if CHAINS[word].hub_radius:
            return told
        return both(told, within(_ratio(one) - 1.0, LIMITS[law], "energy ratio less 1"))

    return HardCase(
        THEME,
        f"{word}, restitution 1, no friction{_name(law)}",
        f"keeps the energy to {LIMITS[law]:g}; on a hub, works are nothing",
        measure,
    )


def _ratio(one: ChainStrike) -> float:
    assert one.kinetic_energy_ratio is not None
    return one.kinetic_energy_ratio


def _works(contact: ContactRecord) -> tuple[float, float, float, float]:
    """Compressive and restitutive works, each normal and tangential."""
    assert contact.compressive_work is not None
    assert contact.restitutive_work is not None
    return (*contact.compressive_work, *contact.restitutive_work)


def _law_kept(contact: ContactRecord, restitution: float) -> float:
    """What restitution returned beyond e*^2 of the normal work of compression, over that work.

    A point that no impulse can part from the surface, and one that never came to rest, may return less.
    """
    taken, _, returned, _ = _works(contact)
    beyond = (returned + restitution**2 * taken) / -taken if taken else returned
    return max(beyond, 0.0) if contact.outcome in ("stiction", "jam") else beyond


def _gained(contact: ContactRecord) -> float:
    """Energy that normal and tangential impulse brought the body, over the normal work of compression; 0 for a loss."""
    taken, *others = _works(contact)
    return max(0.0, (taken + sum(others)) / -taken) if taken else max(0.0, sum(others))


def _rough(word: str, friction: float, law: str) -> HardCase:
    def measure() -> Finding:
        one = _hit(CHAINS[word], friction, 1.0, law)
        kept = within(_law_kept(one.contact, 1.0), LIMITS[law], f"{one.contact.outcome}; off the law by", one.steps)
        if CHAINS[word].hub_radius:
            return kept
        return both(kept, within(max(0.0, _ratio(one) - 1.0), LIMITS[law], "energy gained"))

    return HardCase(
        THEME,
        f"{word}, restitution 1, friction {friction:g}{_name(law)}",
        f"normal work comes back, or stiction; no energy gained; to {LIMITS[law]:g}",
        measure,
    )


def mirrored(chain: Chain) -> Chain:
    """The chain seen in a mirror on the surface's normal."""
    return replace(
        chain,
        angles=tuple(-angle for angle in chain.angles),
        rates=tuple(-rate for rate in chain.rates),
        hub_speed=-chain.hub_speed,
        hub_angle=-chain.hub_angle,
    )


def _mirrored(word: str, restitution: float, law: str) -> HardCase:
    def measure() -> Finding:
        off, same, steps = [], True, 0
        for friction in FRICTIONS:
            one, other = (_hit(each, friction, restitution, law) for each in (CHAINS[word], mirrored(CHAINS[word])))
            same &= (one.contact.outcome, one.contact.phases) == (other.contact.outcome, other.contact.phases)
            off += _differences(one.contact, other.contact)
            steps += one.steps
        return both(within(worst(off), LIMITS["energetic"], "off by", steps), Finding(f"words the same: {same}", same))

    return HardCase(
        THEME,
        f"{word}, restitution {restitution:g}, mirrored{_name(law)}",
        f"the mirrored result, whatever the friction: words the same, numbers to {LIMITS['energetic']:g}",
        measure,
    )


def _differences(one: ContactRecord, other: ContactRecord) -> list[float]:
    """Of a contact and one seen in the mirror: rates, impulse and velocity, over the largest number of the kind."""
    (push, rub), (away, along) = one.impulse, one.velocity_after
    pairs = (
        ([-rate for rate in one.rates_after], other.rates_after, one.rates_before),
        ([push, -rub], other.impulse, one.impulse),
        ([away, -along], other.velocity_after, one.velocity_before),
    )
    return [(a - b) / max(map(abs, size)) for first, second, size in pairs for a, b in zip(first, second, strict=True)]


def _pass(restitution: float, friction: float, law: str) -> HardCase:
    tool = Tool(bar=Bar(restitution=restitution), workpart=Workpart(friction, None, restitution), contact=Contact(law))
    return HardCase(
        THEME,
        f"whole pass, restitution {restitution:g}, friction {friction:g}{_name(law)}",
        f"every impact by the law, none gains energy or leaves too fast, to {LIMITS[law]:g}; workpart struck",
        partial(_measure_pass, tool, restitution, LIMITS[law], "workpart"),
    )


def _rough_bar(restitution: float, law: str) -> HardCase:
    bar = Bar(friction=HIGHEST_OF_BAR, restitution=restitution)
    return HardCase(
        THEME,
        f"bar's friction {HIGHEST_OF_BAR:g}, restitution {restitution:g}{_name(law)}",
        "the bristle jams at the bar: named, no energy gained, and the run ends there",
        partial(_jams, Tool(bar=bar, contact=Contact(law)), restitution, LIMITS[law]),
    )


def _measure_pass(tool: Tool, restitution: float, limit: float, struck: str) -> Finding:
    run = simulate(tool, Settings(accuracy=ACCURACY, maximum_steps=200_000))
    hits = [each for each in run.contacts if each.law != "hold"]
    off = worst([_law_kept(each, restitution) for each in hits])
    gained = worst([_gained(each) for each in hits])
    told = [within(off, limit, "off the law by", run.cost.steps), within(gained, limit, "gained")]
    if restitution == 0.0:
        shares = [each.velocity_after[0] / each.velocity_before[0] for each in hits if each.outcome != "jam"]
        told.append(within(worst([0.0, *shares]), limit, "normal velocity after"))
    first = run.first_contact(struck)
    return both(*told, Finding(f"{struck}: {first.outcome if first else 'not struck'}", first is not None))


def _jams(tool: Tool, restitution: float, limit: float) -> Finding:
    run = simulate(tool, Settings(accuracy=ACCURACY, maximum_steps=200_000))
    last = run.contacts[-1]
    return both(
        within(_gained(last), limit, "gained", run.cost.steps),
        within(_law_kept(last, restitution), limit, "off the law by"),
        Finding(f"{last.obstacle}: {last.outcome}, {run.stop_reason}", last.outcome == run.stop_reason == "jam"),
    )
