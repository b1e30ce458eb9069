"""Invariants of every pass, whatever its parameters: energy, no overlap, friction, and the impact law at its strike.

All of it is evaluated with NumPy from the trajectory and the tool's parameters, apart from the scene that produced it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, rows
from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.studies.wire_contact import complex_points, levers, nearest, touched, wire_lines
from bristle_sim.trajectory import ContactRecord, Trajectory

MAGNIFIED = 10.0
"""Errors of the invariants over the requested accuracy: a squared rate doubles an error, and two contacts and two
flights add up theirs."""

LEAST_TOLERANCE = 1e-9
"""Least tolerance, relative: differences of energies that are summed up in some hundred intervals of 1e-13 each."""

LEAST_COMPLIANT_TOLERANCE = 1e-5
"""Least tolerance with contacts resolved in time: rounding of the penetration lets them be no shorter than some 1e-6 of
the motion's time scale, and that far from the rigid-body limit."""

SAME_INSTANT = 1e-9
"""Contacts with bar and workpart within this fraction of the run's time act together; the law is for one at a time."""

GROUPS = {
    "energy": ("energy_balance",),
    "gap": ("deepest_overlap",),
    "impulse law": ("impulse_momentum_error", "restitution_work_error"),
    "friction": ("friction_cone_excess", "friction_work"),
}
"""Invariants by the words of the sentence that says that they hold."""


def invariant_rows(tool: Tool, settings: Settings, run: Trajectory) -> tuple[Quantity, ...]:
    """Return the errors of a pass's invariants, each 0 in theory, with the tolerance that follows from the accuracy.

    ``energy_balance``: largest imbalance of energy in a flight or an impact, of the largest kinetic energy.
    ``deepest_overlap``: of wire and obstacle, of the bristle's length.
    ``impulse_momentum_error``: (v' - v) - K p at the strike, of the speed before it.
    ``restitution_work_error``: W_r + e*^2 W_c of the normal force at the strike, of W_c.
    ``friction_cone_excess``: tangential impulse beyond mu_1 p_c + mu_2 (p_f - p_c) at the strike, of the normal impulse.
    ``friction_work``: largest work that friction does in a contact, of the largest kinetic energy.
    Energy balance and impulse-momentum error are those of a rigid bristle, and None for a wire of several links.
    """
    compliant, bristle = tool.contact.law == "compliant", tool.bristle
    tolerance = max(LEAST_COMPLIANT_TOLERANCE if compliant else LEAST_TOLERANCE, MAGNIFIED * settings.accuracy)
    found = dict.fromkeys(name for names in GROUPS.values() for name in names) | _strike_errors(tool, run)
    found["deepest_overlap"] = _deepest_overlap(tool, run)
    # A bristle at rest moves by rounding alone, whose energy balances with nothing.
    static = bristle.mass * math.hypot(*bristle.centre)
    field = tool.belt.stiffness + static * (tool.hub.radius * tool.hub.speed**2 + tool.gravity)
    size, uncertainty = max(float(run.kinetic_energy.max()), LEAST_TOLERANCE * field), 0.0
    if size > 0.0:
        works = (sum(each[1] for each in (c.compressive_work, c.restitutive_work) if each) for c in run.contacts)
        found["friction_work"] = max(0.0, *works, 0.0) / size
        if bristle.links == 1:
            energy, uncertainty = _energy_imbalance(tool, run)
            found["energy_balance"], uncertainty = energy / size, uncertainty / size
    theory = {name: None if value is None else 0.0 for name, value in found.items()}
    widened = {"energy_balance": tolerance + uncertainty}
    return rows(dict.fromkeys(found, "1"), found, theory, tolerance=lambda name: widened.get(name, tolerance))


def invariants_in_words(invariants: Sequence[Quantity]) -> str:
    """Return the sentence that says to what the invariants hold, by the largest error of those that hold and apply."""
    errors = {each.name: abs(each.simulated) for each in invariants if each.ok and each.simulated is not None}
    kept = [word for word, names in GROUPS.items() if any(name in errors for name in names)]
    return f"{' and '.join(filter(None, [', '.join(kept[:-1]), kept[-1]]))} hold to {max(errors.values()):.0e}"


def _energy_imbalance(tool: Tool, run: Trajectory) -> tuple[float, float]:
    """Return the largest imbalance of a flight or an impact, and how uncertain its quadrature makes it, J.

    The balance is that of Jacobi's integral, the energy in the frame that turns with the hub: kinetic, belt, centrifugal
    and gravity. In flight it falls at the rate c alpha'^2 - omega m g x; an impact changes it by its impulse's work less
    omega times its moment. Sustained contacts are left out: the obstacle's shape prescribes their motion.
    """
    bristle, omega, damping, weight = tool.bristle, tool.hub.speed, tool.belt_damping, tool.bristle.mass * tool.gravity
    relative, inertia = run.relative_rate, bristle.inertia_about_root
    root = wire_lines(tool, run.hub_angle, run.angles[:, 0])[:, 0]
    arm = complex(*bristle.centre) * np.exp(1j * run.angles[:, 0])
    place = root + arm
    energy = 0.5 * inertia * relative**2 + 0.5 * tool.belt.stiffness * run.relative_angle**2
    jacobi = energy + bristle.mass * (tool.gravity * place.imag - 0.5 * omega**2 * abs(place) ** 2)
    torque = -tool.belt.stiffness * run.relative_angle - damping * relative - weight * arm.real
    acceleration = (torque + bristle.mass * omega**2 * (np.conj(arm) * root).imag) / inertia
    power = damping * relative**2 - omega * weight * place.real
    forward = -omega * root.imag - run.rates[:, 0] * arm.imag
    slope = 2.0 * damping * relative * acceleration - omega * weight * forward
    found, uncertain = [0.0], [0.0]
    for flight in _flights(run):
        # The trapezoidal rule, corrected by the slopes at both ends, is of fourth order.
        fine, coarse = (
            float((0.5 * step * (power[at][1:] + power[at][:-1]) + step**2 / 12.0 * -np.diff(slope[at])).sum())
            for at in (flight, np.unique(np.append(flight[::2], flight[-1])))
            for step in (np.diff(run.time[at]),)
        )
        found.append(abs(float(jacobi[flight[-1]] - jacobi[flight[0]]) + fine))
        uncertain.append(abs(fine - coarse))
    for each in run.contacts:
        if _is_rigid(tool, each):
            before, after = each.rates_before[0] - omega, each.rates_after[0] - omega
            work = float(np.dot(each.impulse, np.add(each.velocity_before, each.velocity_after) / 2.0))
            if each.compressive_work is not None and each.restitutive_work is not None:
                work = sum(each.compressive_work) + sum(each.restitutive_work)
            moment = float(_arms_at(tool, run, each) @ each.impulse)
            found.append(abs(0.5 * inertia * (after**2 - before**2) - work + omega * moment))
    return max(found), max(uncertain)


def _flights(run: Trajectory) -> list[Array]:
    """Return the rows of the samples of each flight, from one contact to the next."""
    middle = 0.5 * (run.time[1:] + run.time[:-1])
    free = np.diff(run.time) > 0.0
    for each in run.contacts:
        free &= (middle < each.time) | (middle > each.time + each.duration)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], free.astype(int), [0]))))
    return [np.arange(start, end + 1) for start, end in zip(edges[::2], edges[1::2], strict=True)]


def _is_rigid(tool: Tool, contact: ContactRecord) -> bool:
    """Whether the law of instantaneous impacts applies: not in a sustained contact, one as long as requested, or a jam."""
    lasting = contact.duration and tool.contact.duration is not None
    return contact.law != "sustained" and contact.outcome != "jam" and not lasting


def _arms_at(tool: Tool, run: Trajectory, contact: ContactRecord, *, of_root: bool = False) -> Array:
    """Return the moments of unit normal and tangential forces at a contact about the hub's centre, or the root; shape (2,), m."""
    hub_angle = np.array([run.hub_angle[0] + run.hub_speed * contact.time])
    lines = wire_lines(tool, hub_angle, np.array(contact.angles))
    normal, point = touched(tool, contact.obstacle, lines)
    return np.asarray(levers(normal, point - lines[:, 0] if of_root else point)[0])


def _deepest_overlap(tool: Tool, run: Trajectory) -> float:
    """Return the deepest overlap of wire and obstacle at any sample, over the wire's length; 0 if there is none.

    A contact resolved in time over a requested duration leaves a crater, which is no error.
    """
    deepest = 0.0
    if tool.workpart is not None and (tool.contact.law != "compliant" or tool.contact.duration is None):
        deepest = max(deepest, float((-tool.workpart_depth - run.tip[:, 1]).max()))
    if tool.bar is not None:
        point = nearest(tool, complex_points(run.centre_line))[2]
        deepest = max(deepest, float((tool.bar_reach - abs(point - complex(*tool.bar.centre))).max()))
    return deepest / tool.bristle.length


def _strike_errors(tool: Tool, run: Trajectory) -> dict[str, float | None]:
    """Return the first strike's violations of the impact law; none where that law does not apply."""
    strike = run.first_contact("workpart")
    if strike is None or tool.workpart is None or not _is_rigid(tool, strike):
        return {}
    near, bars = SAME_INSTANT * float(run.time[-1]), [each for each in run.contacts if each.obstacle == "bar"]
    if any(each.time - near <= strike.time <= each.time + each.duration + near for each in bars):
        return {}
    pushed, part, errors = strike.impulse[0], tool.workpart, dict[str, float | None]()
    speed = math.hypot(*strike.velocity_before)
    if speed and tool.bristle.links == 1:
        arms = _arms_at(tool, run, strike, of_root=True)
        gain = arms * (arms @ strike.impulse) / tool.bristle.inertia_about_root
        change = np.subtract(strike.velocity_after, strike.velocity_before)
        errors["impulse_momentum_error"] = float(np.abs(change - gain).max()) / speed
    if pushed > 0.0:
        compressive = pushed if strike.compressive_impulse is None else strike.compressive_impulse[0]
        cone = part.friction * compressive + part.friction_in_restitution * (pushed - compressive)
        errors["friction_cone_excess"] = max(abs(strike.impulse[1]) - cone, 0.0) / pushed
    works = strike.compressive_work, strike.restitutive_work
    if strike.outcome != "stiction" and works[0] and works[1] and works[0][0]:  # stiction leaves no restitution
        errors["restitution_work_error"] = abs(works[1][0] + part.restitution**2 * works[0][0]) / abs(works[0][0])
    return errors
