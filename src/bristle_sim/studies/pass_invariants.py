"""Invariants of every pass, whatever its parameters: energy, no overlap, and the impact law at its strike.

All of it is evaluated with NumPy from the trajectory and the tool's parameters, apart from the scene that produced it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, rows
from bristle_sim.parameters import Tool
from bristle_sim.settings import Settings
from bristle_sim.trajectory import ContactRecord, Trajectory

MAGNIFIED = 10.0
"""Errors of the invariants over the requested accuracy: a squared rate doubles an error, and two contacts and two
flights add up theirs."""

ROUNDING = 1e-9
"""Least tolerance, relative: differences of energies that are summed up in some hundred intervals of 1e-13 each."""

NEAREST = 1e-5
"""Least tolerance with contacts resolved in time: rounding of the penetration lets them be no shorter than some 1e-6 of
the motion's time scale, and that far from the rigid-body limit."""

SAME_INSTANT = 1e-9
"""Contacts with bar and workpart within this fraction of the run's time act together; the law is for one at a time."""

STRIKE = ("impulse_momentum_error", "restitution_work_error", "friction_cone_excess")


def invariant_rows(tool: Tool, settings: Settings, run: Trajectory) -> tuple[Quantity, ...]:
    """Return the errors of a pass's invariants, each 0 in theory, with the tolerance that follows from accuracy or step.

    ``energy_balance``: largest imbalance of energy in a flight or an impact, of the largest kinetic energy.
    ``deepest_overlap``: of wire and obstacle, of the bristle's length.
    ``impulse_momentum_error``: (v' - v) - K p at the strike, of the speed before it.
    ``restitution_work_error``: W_r + e*^2 W_c of the normal force at the strike, of W_c.
    ``friction_cone_excess``: tangential impulse beyond mu_1 p_c + mu_2 (p_f - p_c) at the strike, of the normal impulse.
    Energy balance and impulse-momentum error are those of a rigid bristle, and None for a wire of several links.
    """
    tolerance, rigid = _tolerance(tool, settings, run), tool.bristle.links == 1
    energy, uncertainty = _energy_imbalance(tool, run) if rigid else (None, 0.0)
    found = {"energy_balance": energy, "deepest_overlap": _deepest_overlap(tool, run), **dict.fromkeys(STRIKE)}
    found |= _strike_errors(tool, run)
    theory = {name: None if value is None else 0.0 for name, value in found.items()}
    widened = {"energy_balance": tolerance + uncertainty}
    return rows(dict.fromkeys(found, "1"), found, theory, tolerance=lambda name: widened.get(name, tolerance))


def _tolerance(tool: Tool, settings: Settings, run: Trajectory) -> float:
    if settings.step is None:
        least = NEAREST if tool.contact.law == "compliant" else ROUNDING
        return max(least, MAGNIFIED * settings.accuracy)
    # Plain steps are of first order: their error is the motion within a step.
    own = math.sqrt(_field(tool) / tool.bristle.inertia_about_root)
    return MAGNIFIED * settings.step * max(tool.hub.speed, own, float(np.abs(run.rates).max()))


def _field(tool: Tool) -> float:
    """Torsional stiffness of belt, hub's turning and gravity together, N m/rad."""
    static = tool.bristle.mass * math.hypot(*tool.bristle.centre)
    return tool.belt.stiffness + static * (tool.hub.radius * tool.hub.speed**2 + tool.gravity)


class _Motion(NamedTuple):
    """The bristle at some instants: arms to the root and from there to the mass centre, whose place and velocity these are."""

    hub_angle: Array
    angle: Array
    rate: Array
    root: Array
    arm: Array
    place: Array
    velocity: Array


def _turned(vector: Array | tuple[float, float], angle: Array) -> Array:
    """Turn a vector by each angle; shape (n, 2)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]], axis=-1)


def _motion(tool: Tool, hub_angle: Array, angle: Array, rate: Array) -> _Motion:
    root, arm = _turned((0.0, -tool.hub.radius), hub_angle), _turned(tool.bristle.centre, angle)
    velocity = tool.hub.speed * _rotated(root) + rate[:, np.newaxis] * _rotated(arm)
    return _Motion(hub_angle, angle, rate, root, arm, root + arm, velocity)


def _cross(first: Array, second: Array) -> Array:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def _rotated(vector: Array) -> Array:
    """Turn vectors by a quarter turn; times a rate that is a velocity."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def _jacobi(tool: Tool, motion: _Motion) -> Array:
    """E - omega L, with E the energy of bristle and belt and L the angular momentum about the hub's centre, J.

    The hub's drive does the work omega M, and M = dL/dt - M_contacts - M_gravity, so that this changes by known terms
    alone: work of contacts less omega M_contacts, damping's loss, and -omega M_gravity.
    """
    bristle, omega = tool.bristle, tool.hub.speed
    energy = (
        0.5 * bristle.mass * (motion.velocity**2).sum(axis=-1) + 0.5 * bristle.inertia_about_centre * motion.rate**2
    )
    energy += 0.5 * tool.belt.stiffness * (motion.angle - motion.hub_angle) ** 2
    energy += bristle.mass * tool.gravity * motion.place[:, 1]
    momentum = bristle.mass * _cross(motion.place, motion.velocity) + bristle.inertia_about_centre * motion.rate
    return np.asarray(energy - omega * momentum)


def _power(tool: Tool, motion: _Motion) -> tuple[Array, Array]:
    """Rate at which the Jacobi integral falls in flight, c alpha'^2 - omega m g x, and its derivative."""
    bristle, omega, damping = tool.bristle, tool.hub.speed, tool.belt_damping
    lag, relative = motion.angle - motion.hub_angle, motion.rate - omega
    weight = bristle.mass * tool.gravity
    torque = -tool.belt.stiffness * lag - damping * relative - weight * motion.arm[:, 0]
    torque += bristle.mass * omega**2 * _cross(motion.arm, motion.root)
    acceleration = torque / bristle.inertia_about_root
    power = damping * relative**2 - omega * weight * motion.place[:, 0]
    return power, 2.0 * damping * relative * acceleration - omega * weight * motion.velocity[:, 0]


def _energy_imbalance(tool: Tool, run: Trajectory) -> tuple[float | None, float]:
    """Return the largest imbalance of a flight or an impact, and how uncertain its quadrature makes it; relative.

    Sustained contacts are left out: the obstacle's shape prescribes their motion.
    """
    motion = _motion(tool, run.hub_angle, run.angles[:, 0], run.rates[:, 0])
    # A bristle at rest moves by rounding alone, whose energy balances with nothing.
    size = max(float(run.kinetic_energy.max()), ROUNDING * _field(tool))
    if not size > 0.0:
        return None, 0.0
    jacobi, (power, slope) = _jacobi(tool, motion), _power(tool, motion)
    found, uncertain = [0.0], [0.0]

    def lost(each: Array) -> float:
        # The trapezoidal rule corrected by the slopes at both ends of each interval: of fourth order.
        values, slopes, step = power[each], slope[each], np.diff(run.time[each])
        whole = 0.5 * step * (values[1:] + values[:-1]) + step**2 / 12.0 * (slopes[:-1] - slopes[1:])
        return float(whole.sum())

    for flight in _flights(run):
        fine, coarse = lost(flight), lost(np.unique(np.append(flight[::2], flight[-1])))
        found.append(abs(float(jacobi[flight[-1]] - jacobi[flight[0]]) + fine))
        uncertain.append(abs(fine - coarse))
    found += [abs(_impact_imbalance(tool, run, each)) for each in run.contacts if _is_rigid(tool, each)]
    return max(found) / size, max(uncertain) / size


def _flights(run: Trajectory) -> list[Array]:
    """Rows of the samples of each flight, from one contact to the next."""
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


def _at_impact(tool: Tool, run: Trajectory, contact: ContactRecord, rate: float) -> _Motion:
    hub_angle = run.hub_angle[0] + run.hub_speed * contact.time
    return _motion(tool, np.array([hub_angle]), np.array(contact.angles), np.array([rate]))


def _impact_imbalance(tool: Tool, run: Trajectory, contact: ContactRecord) -> float:
    """Return the change of the Jacobi integral in an impact less its impulse's work and omega times its moment, J."""
    before, after = (_at_impact(tool, run, contact, rates[0]) for rates in (contact.rates_before, contact.rates_after))
    change = float((_jacobi(tool, after) - _jacobi(tool, before))[0])
    velocity = np.add(contact.velocity_before, contact.velocity_after) / 2.0
    work = float(np.dot(contact.impulse, velocity))
    if contact.compressive_work is not None and contact.restitutive_work is not None:
        work = sum(contact.compressive_work) + sum(contact.restitutive_work)
    normal, arm = _touched(tool, contact.obstacle, before)
    impulse = contact.impulse[0] * normal - contact.impulse[1] * _rotated(normal)
    return change - work + tool.hub.speed * float(_cross(before.root + arm, impulse)[0])


def _touched(tool: Tool, obstacle: str, motion: _Motion) -> tuple[Array, Array]:
    """Return the obstacle's normal, and the contact point from the root; shape (n, 2)."""
    if obstacle == "workpart" or tool.bar is None:
        arm = _turned(tool.bristle.path[-1], motion.angle)
        return np.broadcast_to([0.0, 1.0], arm.shape), arm
    lines = np.stack([motion.root + _turned(each, motion.angle) for each in ((0.0, 0.0), *tool.bristle.path)], axis=1)
    away = _from_bar(tool, lines)
    normal = away / np.linalg.norm(away, axis=-1, keepdims=True)
    point = np.add(tool.bar.centre, away) - 0.5 * tool.bristle.wire_diameter * normal
    return normal, point - motion.root


def _from_bar(tool: Tool, lines: Array) -> Array:
    """Return the shortest vector from the bar's centre to centre lines of shape (n, corners, 2); shape (n, 2)."""
    assert tool.bar is not None
    starts, along = lines[:, :-1], np.diff(lines, axis=1)
    to_bar = np.subtract(tool.bar.centre, starts)
    fraction = np.clip((to_bar * along).sum(axis=-1) / (along**2).sum(axis=-1), 0.0, 1.0)
    ways = fraction[..., np.newaxis] * along - to_bar
    nearest = np.argmin((ways**2).sum(axis=-1), axis=1)
    return np.asarray(ways[np.arange(len(nearest)), nearest])


def _deepest_overlap(tool: Tool, run: Trajectory) -> float:
    """Return the deepest overlap of wire and obstacle at any sample, over the wire's length; 0 if there is none.

    A contact resolved in time over a requested duration leaves a crater, which is no error.
    """
    deepest = 0.0
    if tool.workpart is not None and (tool.contact.law != "compliant" or tool.contact.duration is None):
        deepest = max(deepest, float((-tool.workpart_depth - run.tip[:, 1]).max()))
    if tool.bar is not None:
        distance = np.linalg.norm(_from_bar(tool, run.centre_line), axis=-1)
        deepest = max(deepest, float((tool.bar_reach - distance).max()))
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
        errors["impulse_momentum_error"] = _momentum_error(tool, run, strike) / speed
    if pushed > 0.0:
        compressive = pushed if strike.compressive_impulse is None else strike.compressive_impulse[0]
        cone = part.friction * compressive + part.friction_in_restitution * (pushed - compressive)
        errors["friction_cone_excess"] = max(abs(strike.impulse[1]) - cone, 0.0) / pushed
    # Stiction leaves no restitution.
    if strike.outcome == "stiction":
        return errors
    if strike.compressive_work and strike.restitutive_work and strike.compressive_work[0]:
        taken, returned = strike.compressive_work[0], strike.restitutive_work[0]
        errors["restitution_work_error"] = abs(returned + part.restitution**2 * taken) / abs(taken)
    return errors


def _momentum_error(tool: Tool, run: Trajectory, strike: ContactRecord) -> float:
    """Return the largest component of (v' - v) - K p, m/s."""
    normal, arm = _touched(tool, "workpart", _at_impact(tool, run, strike, strike.rates_before[0]))
    levers = np.array([_cross(arm, normal)[0], -_cross(arm, _rotated(normal))[0]])
    change = np.subtract(strike.velocity_after, strike.velocity_before)
    return float(np.abs(change - levers * (levers @ strike.impulse) / tool.bristle.inertia_about_root).max())
