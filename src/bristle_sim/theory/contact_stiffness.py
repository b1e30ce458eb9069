"""Stiffness of a spring with energetic restitution at which a contact lasts a given time.

Units are SI or any other consistent ones.
"""

from __future__ import annotations

import math

from bristle_sim.theory.impact import Impact


def frictionless_stiffness(inverse_mass: float, restitution: float, duration: float) -> float:
    """Return k = (pi (1 + e*)/(2 T))^2/K_nn, at which a frictionless contact lasts the time T.

    K_nn is the inverse mass along the normal.

    A point of 1 kg on a spring of 1 N/m is in contact for half a period, pi s:

    >>> print(f"{frictionless_stiffness(1.0, 1.0, math.pi):.6f}")
    1.000000
    """
    return (0.5 * math.pi * (1.0 + restitution) / duration) ** 2 / inverse_mass


def stiffness_for_duration(
    impact: Impact, velocity: float, restitution: float, duration: float
) -> float:
    """Return the stiffness at which a contact lasts a given time, in the limit of short contacts.

    ``impact`` is the result of the rigid-body law. The duration scales with 1/sqrt(k). ``velocity``
    is the normal velocity before the impact, which is negative.

    The point of ``frictionless_stiffness``, in contact for half the time, needs four times the
    stiffness:

    >>> from bristle_sim.theory.impact import energetic_impact
    >>> impact = energetic_impact([[1.0, 0.0], [0.0, 1.0]], (-3.0, 0.0), 0.0, 1.0)
    >>> print(f"{stiffness_for_duration(impact, -3.0, 1.0, math.pi / 2.0):.6f}")
    4.000000
    """
    return (time_at_unit_stiffness(impact, velocity, restitution) / duration) ** 2


def time_at_unit_stiffness(impact: Impact, velocity: float, restitution: float) -> float:
    """Return the duration of the contact for k = 1 in the rigid-body limit; it scales with 1/sqrt(k).

    Within a phase the normal velocity and force obey v' = a N, N' = -k v with the phase's own compliance a, so the phase is
    part of a harmonic motion; the impact law gives the velocities and forces at its ends.
    """
    works = impact.phase_work_normal.tolist()
    time = 0.0
    stored = 0.0
    for index, impulse in enumerate(impact.phase_impulse.tolist()):
        if impulse <= 0.0:
            continue
        stiffness = 1.0
        if index >= 2:
            stiffness = 1.0 / restitution**2
            stored = sum(works[index:])
        left = stored - works[index]
        change = 2.0 * (works[index] / impulse - velocity)
        forces = [math.sqrt(2.0 * stiffness * max(energy, 0.0)) for energy in (stored, left)]
        compliance = change / impulse
        velocities = (velocity, velocity + change)
        if change <= 1e-12 * max(map(abs, velocities)):
            time += 2.0 * impulse / sum(forces) if any(forces) else 0.0
        else:
            impedance = math.sqrt(compliance / stiffness)
            before, after = (
                math.atan2(v, impedance * f) for v, f in zip(velocities, forces, strict=True)
            )
            time += (after - before) / math.sqrt(compliance * stiffness)
        stored = left
        velocity = velocity + change
    return time
