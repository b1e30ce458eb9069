"""The strike of a wire that bends, compared with the strike of a rigid bristle on a contact of the
same stiffness.

The end of a straight radial wire strikes while the whole wire turns at one angular velocity. The
contact is a spring with energetic restitution. The spring's stiffness is stated as the duration
that the contact of the rigid bristle would have. Unlike the results of an instantaneous impact,
those of this strike converge as the number of links grows.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, rows
from bristle_sim.parameters import (
    Belt,
    Bristle,
    ContactStiffness,
    Hub,
    Strike,
    Surface,
    Tool,
    Workpart,
)
from bristle_sim.readable import amount
from bristle_sim.scene.strike import ChainStrike, strike_wire, wire_frequencies
from bristle_sim.settings import Settings
from bristle_sim.studies.strike_point import crater_depth
from bristle_sim.studies.whole_pass import record_fields
from bristle_sim.theory.crater import CUTTING_FRICTION
from bristle_sim.theory.wire import beam_frequencies, chain_frequencies
from bristle_sim.trajectory import ContactRecord

RATIO = "impulse_ratio_to_rigid"

MEASURES = {
    "normal_final_impulse": ("normal impulse p_fy", "N s"),
    "peak_force": ("largest normal force", "N"),
    "time_in_touch": ("time in touch", "s"),
    "crater_depth": ("crater depth by energy", "m"),
}

FREQUENCIES = {
    "first_bending_frequency": ("first bending frequency", "Hz"),
    "second_bending_frequency": ("second bending frequency", "Hz"),
}

REFERENCE_ACCURACY = 1e-9
# Largest coefficient of friction for which the reference is computed. Higher friction shortens the
# slip, which the reference then resolves by shorter steps.
REFERENCE_FRICTION = 10.0
STUDY_ACCURACY = 1e-4  # accuracy of the strikes in the figure: errors far below the width of a line
# Contact stiffnesses of the figure, each stated as the duration that the contact of the rigid
# bristle has, divided by the requested duration
STIFFNESSES = tuple(np.geomspace(0.07, 14.0, 13).tolist())

ALONE = "There is a reference for the frequencies alone"

LONGEST_CONTACT = 10.0  # longest contact of the reference, divided by that of the rigid bristle


@dataclass(frozen=True, slots=True)
class FlexibleStrike:
    """A strike of a wire's end on an elastic contact.

    Attributes:
        tool: tool whose workpart touches the end of the radial wire at ``impact_angle``.
        impact_angle: angle between the radial wire and the workpart's normal, rad.
        rate: angular velocity of all links before the strike, rad/s.
        contact: duration that the contact would have if the wire were rigid, s. It determines the
            stiffness of the contact.
        settings: accuracy and limits of the simulation.
    """

    tool: Tool
    impact_angle: float
    rate: float
    contact: ContactStiffness
    settings: Settings

    @property
    def stiffness(self) -> float:
        """Stiffness of the contact, N/m.

        It follows from a rigid bristle's contact duration and inverse normal mass at the tip, K_nn
        = L^2 sin^2(gamma)/I, with length L, impact angle gamma, and inertia I about the root.
        """
        bristle = self.tool.bristle
        part = self.tool.workpart
        assert part is not None
        inverse_mass = (
            bristle.length * math.sin(self.impact_angle)
        ) ** 2 / bristle.inertia_about_root
        return self.contact.stiffness(inverse_mass, part.restitution)

    def of(self, links: int, **changes: Any) -> FlexibleStrike:
        """Return a copy with ``links`` links in the wire, and with changed values of attributes."""
        return dataclasses.replace(self, tool=self.tool.replace(wire_links=links), **changes)

    def run(self, flight: float = 0.0) -> ChainStrike:
        """Simulate the strike, and the free motion for ``flight`` seconds after the contact."""
        return strike_wire(
            *self._start(), self.settings, duration=self.contact.duration, flight=flight
        )

    def reference(self) -> ContactRecord:
        """Return the contact, computed with the independent reference solver."""
        from bristle_sim.reference import strike_reference

        longest = LONGEST_CONTACT * self.contact.duration
        return strike_reference(*self._start(), longest=longest, accuracy=REFERENCE_ACCURACY)

    def _start(self) -> tuple[Tool, float, list[float], list[float], float]:
        links = self.tool.bristle.links
        return (
            self.tool,
            -self.impact_angle,
            [-self.impact_angle] * links,
            [self.rate] * links,
            self.stiffness,
        )


@dataclass(frozen=True, slots=True)
class FlexibleWire:
    """Results of the study: the strike of a wire that bends, and that of a rigid bristle.

    Attributes:
        strike: the requested strike.
        wire, rigid: simulated strikes of the wire of links and of the rigid bristle.
    """

    strike: FlexibleStrike
    wire: ChainStrike
    rigid: ChainStrike


def flexible_wire(
    hub: Hub,
    belt: Belt,
    bristle: Bristle,
    strike: Strike,
    surface: Surface,
    contact: ContactStiffness,
    settings: Settings,
    *,
    with_reference: bool = True,
) -> Report:
    """Simulate the strike of a wire of links, and compare it with the strike of the rigid bristle.

    Raises:
        ValueError: if parameters contradict each other, or the contact does not end.
    """
    if not hub.speed:
        raise ValueError("hub_speed = 0: must be above 0, or nothing strikes (in rad/s)")
    if not bristle.wire_diameter:
        raise ValueError("wire_diameter = 0: must be above 0, or no elastic wire strikes (in m)")
    gamma = math.radians(strike.impact_angle_deg)
    tool = tool_at_surface(hub, belt, bristle, surface, gamma)
    struck = FlexibleStrike(tool, gamma, strike.speed_ratio * hub.speed, contact, settings)
    wire, rigid = (each.run(contact.duration) for each in (struck, struck.of(1)))
    own = measures(struck, wire.contact)
    stiff = measures(struck, rigid.contact)
    outcome = rigid.contact.outcome
    simulated = own | {RATIO: ratios(own, stiff)["normal_final_impulse"]}
    units = MEASURES | {RATIO: ("impulse divided by the rigid bristle's", "1")}
    remarks = [
        f"theory: the beam for the frequencies, else the rigid bristle at the contact stiffness of {struck.stiffness:.4g} N/m",
        f"The crater is cut in API 5L steel with mu = {CUTTING_FRICTION:g} by the energy that the tip loses in compression.",
    ]
    if outcome != "rebound":
        remarks.append(
            f"The rigid bristle's outcome is {outcome}; its values are those up to the end of compression."
        )
    reference = dict[str, float]()
    friction = max(surface.friction, surface.friction_in_restitution)
    if with_reference and friction > REFERENCE_FRICTION:
        remarks.append(
            f"{ALONE}: with a friction of more than {REFERENCE_FRICTION:g} it takes long."
        )
    elif with_reference:
        try:
            found = measures(struck, struck.reference())
            if outcome == "rebound":
                other = measures(struck, struck.of(1).reference())
                found[RATIO] = ratios(found, other)["normal_final_impulse"]
            reference = found
        except ValueError as error:
            remarks.append(f"{ALONE}: {error}.")
    within = dict.fromkeys(reference, max(1e-8, 10.0 * settings.accuracy))
    return Report(
        **record_fields(wire, strike=0.0, release=wire.contact.duration),
        quantities=(
            *_frequencies(tool, with_reference),
            *rows(units, simulated, stiff, reference, tolerances=within),
        ),
        remarks=tuple(remarks),
        subject=FlexibleWire(struck, wire, rigid),
        answer=_answer(bristle.links, own, stiff, second_touch(wire)),
    )


def _answer(
    links: int, own: Mapping[str, float], stiff: Mapping[str, float], second: float | None
) -> str:
    wire, rigid = (
        [amount(each[name], unit) for name, (_, unit) in MEASURES.items()] for each in (own, stiff)
    )
    found = (
        f"With {links} links the impulse is {wire[0]}, the largest force {wire[1]} and the crater {wire[3]} deep; the rigid"
        f" bristle at the same contact stiffness has {rigid[0]}, {rigid[1]} and {rigid[3]}."
    )
    if second is None:
        return found
    return f"{found} The wire's end touches again {amount(second, 's')} after the first touch, which these numbers leave out."


def second_touch(wire: ChainStrike) -> float | None:
    """Return the time (s) between the first two touches of the wire's end; None for one touch."""
    depth = wire.centre_line[0, -1, 1] - wire.centre_line[:, -1, 1]
    deeper = (wire.time > wire.contact.duration) & (depth > 0.0) & (np.gradient(depth) > 0.0)
    return float(wire.time[np.argmax(deeper)]) if deeper.any() else None


def measures(strike: FlexibleStrike, contact: ContactRecord) -> dict[str, float]:
    """Return impulse, peak force, duration and crater depth of a contact.

    ``MEASURES`` lists their names and units.

    Raises:
        ValueError: if the contact has no time history, because the wire's end barely touches.
    """
    if contact.history is None or contact.compressive_work is None:
        raise ValueError(
            "speed_ratio, impact_angle_deg: must let the wire's end enter the workpart; it barely touches"
        )
    lost = -sum(contact.compressive_work)
    wire = strike.tool.bristle.wire_diameter
    return {
        "normal_final_impulse": contact.impulse[0],
        "peak_force": float(contact.history.normal_force.max()),
        "time_in_touch": contact.duration,
        "crater_depth": float(crater_depth(lost, CUTTING_FRICTION, strike.impact_angle, wire)),
    }


def ratios(first: dict[str, float], second: dict[str, float]) -> dict[str, float]:
    """Return each measure of the first strike divided by that of the second; NaN instead of x/0."""
    return {name: first[name] / second[name] if second[name] else math.nan for name in first}


def tool_at_surface(
    hub: Hub, belt: Belt, bristle: Bristle, surface: Surface, impact_angle: float
) -> Tool:
    """Return a tool whose workpart just touches the end of the radial wire at the impact angle.

    ``impact_angle`` is the angle between the wire and the workpart's normal, rad.

    Raises:
        ValueError: if the angle is so large that the hub's rim would touch the workpart.
    """
    reach = hub.radius + bristle.length
    if reach * math.cos(impact_angle) <= hub.radius:
        limit = math.degrees(math.acos(hub.radius / reach))
        raise ValueError(
            f"impact_angle_deg = {math.degrees(impact_angle):g}: must be less than {limit:.6g}, or the hub's rim would touch"
            " the workpart (in deg)"
        )
    part = Workpart(
        **dataclasses.asdict(surface), penetration=reach * (1.0 - math.cos(impact_angle))
    )
    return Tool(hub=hub, belt=belt, bristle=bristle, bar=None, workpart=part)


def _frequencies(tool: Tool, with_reference: bool) -> tuple[Quantity, ...]:
    """Compare the simulated wire's bending frequencies with those of a beam and of a chain."""
    bristle = tool.bristle
    beam = (bristle.mass, bristle.length, bristle.wire_diameter, bristle.modulus)
    wire = (*beam, tool.belt.stiffness)
    chain = chain_frequencies(*wire, bristle.links)
    # Mode 0, the swing of the wire on the belt, is left out.
    simulated, theory, reference = (
        dict(zip(FREQUENCIES, modes[1:], strict=False))
        for modes in (wire_frequencies(tool), beam_frequencies(*wire, 3), chain)
    )
    if not with_reference:
        reference = {}
    within = {}
    for name, value in reference.items():
        # Eigenvalues are squared frequencies, with the rounding error of the largest one.
        rounding = math.ulp(1.0) * (chain[-1] / value) ** 2
        if rounding < 1.0:
            within[name] = max(1e-6, rounding)
    return rows(FREQUENCIES, simulated, theory, reference, tolerances=within)


@dataclass(frozen=True, slots=True)
class WireStudy:
    """Measures of a wire's strike divided by those of the rigid bristle's strike.

    Attributes:
        durations: the contact stiffnesses, each stated as the duration (s) of the contact that it
            gives the rigid bristle.
        by_duration: ratios at each of ``durations``, for the requested number of links, by name of
            the measure.
        links: numbers of links.
        by_links: ratios at each of ``links``, for the requested stiffness, by name of the measure.
    """

    durations: Array
    by_duration: dict[str, Array]
    links: Array
    by_links: dict[str, Array]


def wire_study(strike: FlexibleStrike, stiffnesses: Sequence[float] = STIFFNESSES) -> WireStudy:
    """Simulate strikes on contacts of several stiffnesses, and strikes of wires with fewer links.

    Args:
        strike: the requested strike.
        stiffnesses: durations of the rigid bristle's contact divided by the requested duration.
    """
    most = strike.tool.bristle.links
    durations = strike.contact.duration * np.array(stiffnesses)
    numbers = range(1, max(2, most) + 1)
    coarse = dataclasses.replace(strike.settings, accuracy=STUDY_ACCURACY)

    def compared(strikes: Iterable[FlexibleStrike]) -> dict[str, Array]:
        """Return measures of strikes divided by the rigid bristle's; NaN without end of contact."""
        found = []
        for each in strikes:
            try:
                both = (measures(one, one.run().contact) for one in (each, each.of(1)))
                found.append(ratios(*both))
            except ValueError:
                found.append(dict.fromkeys(MEASURES, math.nan))
        return {name: np.array([each[name] for each in found]) for name in MEASURES}

    contacts = [ContactStiffness(duration) for duration in durations.tolist()]
    by_duration = compared(strike.of(most, contact=each, settings=coarse) for each in contacts)
    by_links = compared(strike.of(links, settings=coarse) for links in numbers)
    return WireStudy(durations, by_duration, np.array(numbers, dtype=float), by_links)
