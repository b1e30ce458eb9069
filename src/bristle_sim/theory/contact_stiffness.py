"""Stiffness at which a contact on a spring with energetic restitution lasts a given time.

Units are SI or any other consistent ones.
"""

from __future__ import annotations

import math

from bristle_sim.theory.impact import Impact

# Rounding error of the change of velocity in a phase, as a fraction of the velocities at its ends.
# A phase with a smaller change is treated as a motion at constant velocity.
ROUNDING = 1e-12


def frictionless_stiffness(inverse_mass: float, restitution: float, duration: float) -> float:
    """Return the normal stiffness at which a frictionless contact lasts a given time.

    The stiffness is k = (pi (1 + e*)/(2 T))^2/K_nn, where K_nn is the inverse mass along the
    normal, e* the energetic coefficient of restitution and T the duration.

    A point of 1 kg on a spring of 1 N/m is in contact for half a period, pi s:

    >>> print(f"{frictionless_stiffness(1.0, 1.0, math.pi):.6f}")
    1.000000
    """
    return (0.5 * math.pi * (1.0 + restitution) / duration) ** 2 / inverse_mass


def stiffness_for_duration(
    impact: Impact, velocity: float, restitution: float, duration: float
) -> float:
    """Return the normal stiffness at which a contact lasts a given time.

    The result holds in the limit of short contacts, in which the duration is inversely proportional
    to the square root of the stiffness.

    Args:
        impact: result of the rigid-body law for the same impact.
        velocity: normal velocity before the impact, which is negative.
        restitution: energetic coefficient of restitution.
        duration: required duration of the contact.

    A point of 1 kg that is in contact for pi/2 s needs a stiffness of 4 N/m, as half a period of
    its oscillation is then pi/2 s:

    >>> from bristle_sim.theory.impact import energetic_impact
    >>> impact = energetic_impact([[1.0, 0.0], [0.0, 1.0]], (-3.0, 0.0), 0.0, 1.0)
    >>> print(f"{stiffness_for_duration(impact, -3.0, 1.0, math.pi / 2.0):.6f}")
    4.000000
    """
    return (time_at_unit_stiffness(impact, velocity, restitution) / duration) ** 2


def time_at_unit_stiffness(impact: Impact, velocity: float, restitution: float) -> float:
    """Return the duration of a contact of normal stiffness 1, in the limit of short contacts.

    Within a phase of the impact the normal velocity v and the normal force N obey v' = a N and N' =
    -k v, where a is the change of v per unit normal impulse in that phase. The phase is therefore
    part of a harmonic motion. Its duration follows from v and N at its ends, which the impact law
    gives.
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
        if change <= ROUNDING * max(map(abs, velocities)):
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
