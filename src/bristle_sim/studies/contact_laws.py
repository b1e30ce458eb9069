"""One impact of a chain of rods: its simulation by every contact law, and the velocities of the
contact point as functions of the normal impulse.

Let p be the normal impulse and p_t the tangential impulse. The velocities of the contact point are
piecewise linear in p: v = v(0) + K (p, p_t), where K is the inverse mass matrix. In slip with the
friction mu, p_t changes by -mu sign(v_t) dp (Zhang 2020, eqs. 2.34, 2.43, 2.74, 2.80, 2.98). A
contact simulated over time passes through the same velocities, whatever its stiffness, since time
enters only through p = integral of the normal force.
"""

from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.parameters import Contact, Surface
from bristle_sim.scene.strike import Chain, ChainStrike, strike
from bristle_sim.settings import Settings
from bristle_sim.theory.impact import energetic_impact
from bristle_sim.trajectory import ContactHistory
from bristle_sim.trajectory.interpolation import integral

LAWS = ("energetic", "compliant", "engine")


@dataclass(frozen=True, slots=True)
class Impacts:
    """One impact of a chain of rods on a surface, computed by every contact law.

    Attributes:
        chain: the rods before the impact.
        surface: the surface.
        contact: the contact law that the user requested, with its parameters.
        strikes: simulated impact by each contact law, by the name of the law.
        refusals: reason why a law cannot compute the impact, by the name of the law.
        timing: sentence that states how the duration of the contact was chosen, for laws with a
            contact of finite duration.
    """

    chain: Chain
    surface: Surface
    contact: Contact
    strikes: dict[str, ChainStrike]
    refusals: dict[str, str]
    timing: str


def all_laws(chain: Chain, surface: Surface, contact: Contact, settings: Settings) -> Impacts:
    """Simulate an impact by the requested contact law, and by every other law that can compute it.

    Raises:
        ValueError: if the requested law cannot compute the impact, or a rod turns too slowly to be
            distinguished from rest.
    """
    strikes = dict[str, ChainStrike]()
    refusals = dict[str, str]()
    for law in LAWS:
        elastic = 0.0 if law == "engine" else contact.tangential_compliance
        other = Contact(law, tangential_compliance=elastic)
        try:
            strikes[law] = strike(
                chain, surface, contact if law == contact.law else other, settings
            )
        except ValueError as error:
            if law == contact.law:
                raise
            refusals[law] = str(error)
    timing = "rigid-body limit" if contact.duration is None else "contact_duration as requested"
    return Impacts(chain, surface, contact, strikes, refusals, timing)


@dataclass(frozen=True, slots=True)
class ImpulseCourse:
    """Velocities of the contact point during an impact, as functions of the normal impulse.

    Attributes:
        impulse: normal impulse, ascending from 0 (N s), shape (n,).
        normal_velocity: velocity v_n away from the surface (m/s), shape (n,).
        tangential_velocity: velocity v_t along the surface (m/s), shape (n,).
        phases: names of the n - 1 phases between consecutive values of the impulse; empty if
            unknown.
    """

    impulse: Array
    normal_velocity: Array
    tangential_velocity: Array
    phases: tuple[str, ...] = ()


def contact_inverse_mass(chain: Chain) -> Array:
    """Return the inverse mass matrix K = J M^-1 J^T at the tip of a chain of hinged uniform rods.

    K is in 1/kg, with the components (normal, tangential). Rod i has the length L_i, the angle
    theta_i and the mass m_i. The generalised speeds are u_i = L_i theta_i'. With them the velocity
    of the tip, J u, has the components

        v_n = sum of u_i sin theta_i,   v_t = sum of u_i cos theta_i.

    The kinetic energy is u^T M u/2, where M_ii is m_i/3 plus the masses of all rods beyond rod i,
    and

        M_ij = cos(theta_i - theta_j) (m_j/2 + masses of all rods beyond rod j)   for i < j.

    The hub turns at constant speed and does not respond to the impact.
    """
    masses = np.array(chain.masses)
    angles = np.array(chain.angles)
    carried = masses.sum() - np.cumsum(masses)
    order = np.arange(masses.size)
    inertia = (masses / 2.0 + carried)[np.maximum.outer(order, order)] * np.cos(
        np.subtract.outer(angles, angles)
    )
    inertia[order, order] = masses / 3.0 + carried
    jacobian = np.stack([np.sin(angles), np.cos(angles)])
    return np.asarray(jacobian @ np.linalg.solve(inertia, jacobian.T))


def tip_velocity(chain: Chain) -> tuple[float, float]:
    """Return the absolute velocity (normal, tangential) of the tip, m/s.

    The motion of the hub is included.
    """
    speeds = np.array(
        [chain.hub_radius * chain.hub_speed, *np.multiply(chain.lengths, chain.rates)]
    )
    angles = np.array([chain.hub_angle, *chain.angles])
    return float(speeds @ np.sin(angles)), float(speeds @ np.cos(angles))


def energetic_course(chain: Chain, surface: Surface) -> ImpulseCourse:
    """Return the contact point's velocities during an impact that obeys the energetic law.

    They are piecewise linear in the normal impulse, from the touch to the separation. If the tip
    does not approach the surface, there is a single point.
    """
    inverse_mass = contact_inverse_mass(chain)
    before = tip_velocity(chain)
    later = surface.friction_in_restitution
    impact = energetic_impact(inverse_mass, before, surface.friction, surface.restitution, later)
    (normal, coupling), (_, tangential) = inverse_mass.tolist()
    slip = impact.phase_slip
    friction = np.array([surface.friction, surface.friction, later, later])
    # Friction in restitution is at most so large that it keeps the normal velocity constant.
    friction[2:] *= normal / np.maximum(normal, slip[2:] * coupling * later)
    stick = -coupling / tangential if tangential > 0.0 else 0.0
    ratios = np.where(slip, -friction * slip, stick)
    steps = np.stack([impact.phase_impulse, ratios * impact.phase_impulse])
    steps = np.hstack([np.zeros((2, 1)), steps[:, impact.phase_impulse > 0.0]])
    sums = np.cumsum(steps, axis=1)
    normal_speed, slip_speed = np.array(before)[:, None] + inverse_mass @ sums
    return ImpulseCourse(sums[0], normal_speed, slip_speed, impact.phases)


def recorded_course(history: ContactHistory) -> ImpulseCourse:
    """Return the contact point's velocities as functions of the normal impulse, for a contact
    resolved in time.

    The normal impulse is the time integral of the recorded normal force. In each phase of the
    contact the force is interpolated by a cubic spline.
    """
    impulse = integral(history.time, history.normal_force)
    return ImpulseCourse(impulse, history.normal_velocity, history.tangential_velocity)
