"""Invariants that every pass of a bristle past bar and workpart must satisfy, whatever the tool:
energy, no overlap, friction, and the impact law at the strike.

The invariants, and the geometry of a rigid wire's contacts, are computed from the trajectory and
the tool's parameters alone, independently of the simulation. Points and directions are complex
numbers x + i y from the hub's centre, m. The first axis of arrays runs over n instants.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, rows
from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

Points = NDArray[np.complex128]

X_Y = np.array([1.0, 1j])
"""Points (x, y) in the last axis of an array times X_Y are complex numbers x + i y."""

# Tolerance of an invariant, divided by the requested accuracy. The relative error of an angular
# velocity doubles in its square, and the errors of two contacts and two flights add up.
MAGNIFIED = 10.0
# Smallest relative tolerance. Energies are sums over several hundred intervals, each with an error
# of 1e-13.
LEAST_TOLERANCE = 1e-9
# Smallest relative tolerance with contacts that are resolved in time. Rounding error of the
# penetration keeps the duration of a contact above about 1e-6 of the motion's time scale. The
# relative difference from the rigid-body limit is of the same size.
LEAST_COMPLIANT_TOLERANCE = 1e-5
# Largest time between contacts with bar and workpart that count as simultaneous, divided by the
# duration of the run. The law of a single impact is not tested on simultaneous contacts.
SAME_INSTANT = 1e-9

WORDS = {
    "energy_balance": "energy",
    "deepest_overlap": "gap",
    "impulse_momentum_error": "impulse law",
    "restitution_work_error": "impulse law",
    "friction_cone_excess": "friction",
    "friction_work": "friction",
}
"""Word for each invariant in the sentence that lists the satisfied invariants."""


def invariant_rows(tool: Tool, settings: Settings, run: Trajectory) -> tuple[Quantity, ...]:
    """Return the errors of a pass's invariants, with tolerances that follow from the accuracy.

    In theory every error is 0. Each error is a fraction of a reference value:

    - ``energy_balance``: largest imbalance of energy in a flight or an impact, divided by the
      largest kinetic energy.
    - ``deepest_overlap``: deepest overlap of wire and obstacle, divided by the bristle's length.
    - ``impulse_momentum_error``: magnitude of (v' - v) - K p at the strike, divided by that of v. v
      and v' are the contact point's velocities before and after, K is the inverse mass matrix, and
      p the impulse.
    - ``restitution_work_error``: |W_r + e*^2 W_c| at the strike, divided by |W_c|. W_c and W_r are
      the works of the normal force in compression and restitution, e* is the energetic restitution.
    - ``friction_cone_excess``: tangential impulse at the strike beyond mu_1 p_c + mu_2 (p_f - p_c),
      divided by p_f. mu_1 and mu_2 are the friction coefficients in compression and restitution.
      p_c and p_f are the normal impulses at the end of compression and at the end of the impact.
    - ``friction_work``: largest positive work of friction in a contact, divided by the largest
      kinetic energy. Friction should do negative work.

    Energy balance and impulse-momentum error are defined for a rigid bristle alone.
    """
    least = LEAST_COMPLIANT_TOLERANCE if tool.contact.law == "compliant" else LEAST_TOLERANCE
    within = dict.fromkeys(WORDS, max(least, MAGNIFIED * settings.accuracy))
    # The scale has a lower bound, as the kinetic energy of a bristle at rest is mere rounding
    # error.
    static = tool.bristle.mass * math.hypot(*tool.bristle.centre)
    field = tool.belt.stiffness + static * (tool.hub.radius * tool.hub.speed**2 + tool.gravity)
    size = max(float(run.kinetic_energy.max()), LEAST_TOLERANCE * field, 1e-300)
    frictions = [each.work[1] for each in run.contacts if each.work is not None]
    found = _strike_errors(tool, run) | {
        "deepest_overlap": _deepest_overlap(tool, run),
        "friction_work": max([0.0, *frictions]) / size,
    }
    if tool.bristle.links == 1:
        energy, uncertainty = _energy_imbalance(tool, run)
        found["energy_balance"] = energy / size
        within["energy_balance"] += uncertainty / size
    return rows(
        dict.fromkeys(WORDS, ("", "1")), found, dict.fromkeys(found, 0.0), tolerances=within
    )


def invariants_in_words(invariants: Sequence[Quantity]) -> str:
    """Return a sentence with the satisfied invariants and the largest of their errors."""
    kept = {each.name: abs(each.simulated or 0.0) for each in invariants if each.ok}
    *others, last = dict.fromkeys(map(WORDS.__getitem__, kept))
    return f"{' and '.join(filter(None, [', '.join(others), last]))} are satisfied to {max(kept.values()):.0e}"


def _energy_imbalance(tool: Tool, run: Trajectory) -> tuple[float, float]:
    """Return the largest energy imbalance of a flight or an impact, J.

    The balance is that of Jacobi's integral, the energy in the frame that rotates with the hub.
    It is the sum of kinetic, belt, centrifugal and gravity energy. In flight this sum decreases per
    unit time by

        c alpha'^2 - omega m g x,

    where c is the belt's damping coefficient, alpha the bristle's angle relative to the hub, omega
    the hub speed, m g the bristle's weight, and x the horizontal coordinate of its centre. An
    impact changes the integral by the work of the impulse minus omega times the impulse's moment
    about the hub's centre. Sustained contacts are left out, since in them the obstacle's shape
    prescribes the bristle's motion.

    Returns:
        The largest imbalance, J.
        The largest bound of the error of the integration over a flight, J.
    """
    bristle = tool.bristle
    omega = tool.hub.speed
    inertia = bristle.inertia_about_root
    weight = bristle.mass * tool.gravity
    relative = run.relative_rate
    root = run.centre_line[:, 0] @ X_Y
    arm = complex(*bristle.centre) * np.exp(1j * run.angles[:, 0])
    place = root + arm
    energy = 0.5 * inertia * relative**2 + 0.5 * tool.belt.stiffness * run.relative_angle**2
    jacobi = energy + weight * place.imag - 0.5 * bristle.mass * omega**2 * abs(place) ** 2
    driven = bristle.mass * omega**2 * (np.conj(arm) * root).imag - weight * arm.real
    resisted = tool.belt.stiffness * run.relative_angle + tool.belt_damping * relative
    power = tool.belt_damping * relative**2 - omega * weight * place.real
    forward = -omega * root.imag - run.rates[:, 0] * arm.imag
    slope = 2.0 * tool.belt_damping * relative * (driven - resisted) / inertia
    slope -= omega * weight * forward

    def lost(at: Array) -> Array:
        """Return the energy lost between consecutive samples, J; ``at`` holds their indices.

        The power lost is integrated over time by the trapezoidal rule with end corrections, which
        is of fourth order.
        """
        step = np.diff(run.time[at])
        mean = 0.5 * (power[at][1:] + power[at][:-1])
        return np.asarray(step * (mean - step / 12.0 * np.diff(slope[at])))

    def error(flight: Array) -> float:
        """Return a bound of the error of the energy lost in a flight, J.

        The loss over each pair of neighbouring intervals is compared with the loss over both as one
        interval. The rule's error is proportional to the fifth power of a small interval. The bound
        is twice the sum of the errors' magnitudes, since not all intervals are that small.
        """
        steps = np.diff(run.time[flight])
        over_both = np.array([lost(flight[i : i + 3 : 2])[0] for i in range(len(flight) - 2)])
        excess = abs(over_both - pairs(lost(flight)))
        return float(2.0 * (excess * pairs(steps**5) / (pairs(steps) ** 5 - pairs(steps**5))).sum())

    def pairs(values: Array) -> Array:
        """Return the sum of each pair of neighbouring values."""
        return values[1:] + values[:-1]

    middle = 0.5 * (run.time[1:] + run.time[:-1])
    free = np.diff(run.time) > 0.0
    for each in run.contacts:
        free &= (middle < each.time) | (middle > each.time + each.duration)
    found = [0.0]
    uncertain = [0.0]
    # A flight lasts from one contact to the next.
    for first, last in np.flatnonzero(np.diff(free, prepend=False, append=False)).reshape(-1, 2):
        flight = np.arange(first, last + 1)
        found.append(abs(float(jacobi[last] - jacobi[first]) + lost(flight).sum()))
        uncertain.append(error(flight))
    for each in run.contacts:
        if _is_rigid(tool, each) and each.work is not None:
            before, after = each.rates_before[0] - omega, each.rates_after[0] - omega
            expected = sum(each.work) - omega * impulse_moment(tool, each)
            found.append(abs(0.5 * inertia * (after**2 - before**2) - expected))
    return max(found), max(uncertain)


def _is_rigid(tool: Tool, contact: ContactRecord) -> bool:
    """Return whether the rigid-body impact law applies to a contact.

    It does not apply to a sustained contact, to a contact whose duration was requested, or to a
    jam.
    """
    lasting = contact.duration and tool.contact.duration is not None
    return contact.law != "sustained" and contact.outcome != "jam" and not lasting


def _deepest_overlap(tool: Tool, run: Trajectory) -> float:
    """Return the deepest overlap of wire and obstacle at any sample, divided by the wire's length.

    It is 0 if nothing overlaps. A contact whose duration was requested is left out, because the
    wire then penetrates the workpart by design.
    """
    depths = [0.0]
    lines = run.centre_line @ X_Y
    if tool.workpart is not None and tool.contact.duration is None:
        # Of a wire of links only the end is checked; its joints may pass through the workpart.
        corners = lines[:, 1:] if tool.bristle.links == 1 else lines[:, -1:]
        depths.append(-tool.workpart_depth - float(corners.imag.min()))
    if tool.bar is not None:
        away = tool.bar.closest(lines) - complex(*tool.bar.centre)
        depths.append(tool.bar_reach - float(abs(away).min()))
    return max(depths) / tool.bristle.length


def _strike_errors(tool: Tool, run: Trajectory) -> dict[str, float]:
    """Return the errors in the rigid-body impact law at the first strike of a run.

    The keys are those of :func:`invariant_rows`. The dictionary is empty if there is no strike, or
    if the law does not apply to the strike.
    """
    strike = run.first_contact("workpart")
    part = tool.workpart
    if strike is None or part is None or not _is_rigid(tool, strike):
        return {}
    near = SAME_INSTANT * float(run.time[-1])
    for each in run.contacts:
        since = strike.time - each.time
        if each.obstacle == "bar" and -near <= since <= each.duration + near:
            return {}
    errors = dict[str, float]()
    speed = math.hypot(*strike.velocity_before)
    if speed and tool.bristle.links == 1:
        assert strike.place is not None
        normal, point = surface_point(tool, "workpart", complex(*strike.place))
        hub_angle = run.hub_angle[0] + run.hub_speed * strike.time
        arm = point + 1j * tool.hub.radius * np.exp(1j * hub_angle)
        spin = (np.conj(arm) * in_plane(normal, strike.impulse)).imag
        change = np.subtract(strike.velocity_after, strike.velocity_before)
        gain = 1j * arm * spin / tool.bristle.inertia_about_root
        errors["impulse_momentum_error"] = float(abs(in_plane(normal, change) - gain)) / speed
    pushed = strike.impulse[0]
    compressive = pushed if strike.compressive_impulse is None else strike.compressive_impulse[0]
    cone = part.friction * compressive + part.friction_in_restitution * (pushed - compressive)
    errors["friction_cone_excess"] = max(abs(strike.impulse[1]) - cone, 0.0) / (pushed or 1.0)
    first = (strike.compressive_work or (0.0, 0.0))[0]
    if strike.outcome == "rebound" and first and strike.restitutive_work is not None:
        # After stiction there is no restitution; a contact that lasts too long is cut off during
        # it.
        second = strike.restitutive_work[0]
        errors["restitution_work_error"] = abs(second + part.restitution**2 * first) / abs(first)
    return errors


def in_plane(normal: Any, pair: Any) -> Any:
    """Return a vector as a complex number x + i y, given its components at a contact.

    ``normal`` is the unit vector out of the obstacle, a complex number. ``pair`` has the normal and
    the tangential component.
    """
    return normal * (pair[0] - 1j * pair[1])


def surface_point(tool: Tool, obstacle: str, place: Any) -> tuple[Any, Any]:
    """Return the outward normal of an obstacle, and the point at which the wire touches it.

    ``place`` is the point of the wire's centre line at the contact. Points and the unit normal are
    complex numbers x + i y. Points are in m, from the hub's centre.
    """
    if tool.bar is None or obstacle == "workpart":
        return 1j, place
    away = place - complex(*tool.bar.centre)
    normal = away / abs(away)
    return normal, place - 0.5 * tool.bristle.wire_diameter * normal


def impulse_moment(tool: Tool, contact: ContactRecord) -> float:
    """Return the moment of an impact's impulse about the hub's centre, N m s."""
    assert contact.place is not None
    normal, point = surface_point(tool, contact.obstacle, complex(*contact.place))
    return float((np.conj(point) * in_plane(normal, contact.impulse)).imag)
