"""A run in closed form for pictures: a bristle that swings, strikes and swings back."""

from __future__ import annotations

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.settings import StopReason
from bristle_sim.trajectory import ContactRecord, Cost, Event, Trajectory

FREQUENCY = 1100.0
AMPLITUDE = 0.7
STRIKE = 1.4e-3
END = 2.5e-3
HUB_START = -0.75


def swing(time):
    """Angle and rate relative to the hub: a harmonic from a lag of 0.7 rad, reflected at the strike."""
    later = 2.0 * STRIKE - time
    before = -AMPLITUDE * np.cos(FREQUENCY * time), AMPLITUDE * FREQUENCY * np.sin(FREQUENCY * time)
    after = (
        -AMPLITUDE * np.cos(FREQUENCY * later),
        -AMPLITUDE * FREQUENCY * np.sin(FREQUENCY * later),
    )
    return before, after


def straight_wire(tool, hub, angle, rate):
    """Root and tip, and their velocities, by (sin, -cos) and its derivative (cos, sin)."""
    arm = tool.bristle.length
    root = tool.hub.radius
    places = [root * np.array([np.sin(hub), -np.cos(hub)])]
    places.append(places[0] + arm * np.array([np.sin(angle), -np.cos(angle)]))
    velocities = [root * tool.hub.speed * np.array([np.cos(hub), np.sin(hub)])]
    velocities.append(velocities[0] + arm * rate * np.array([np.cos(angle), np.sin(angle)]))
    return np.moveaxis(places, -1, 0), np.moveaxis(velocities, -1, 0)


def make_trajectory(samples: int = 60, events: tuple[Event, ...] | None = None) -> Trajectory:
    """A run in closed form, with two samples at the strike's instant."""
    tool = Tool()
    first, second = np.linspace(0.0, STRIKE, samples), np.linspace(STRIKE, END, samples)
    time = np.concatenate([first, second])
    alpha = np.concatenate([swing(first)[0][0], swing(second)[1][0]])
    rate = np.concatenate([swing(first)[0][1], swing(second)[1][1]])
    hub = HUB_START + tool.hub.speed * time
    angle = hub + alpha
    absolute = rate + tool.hub.speed
    lines, velocities = straight_wire(tool, hub, angle, absolute)
    named = (
        Event("bar release", 0.2e-3),
        Event("strike", STRIKE),
        Event("largest retraction", 2.3e-3),
    )
    return Trajectory(
        time=time,
        hub_angle=hub,
        angles=angle[:, None],
        rates=absolute[:, None],
        centre_line=lines,
        centre_line_velocity=velocities,
        kinetic_energy=0.5 * tool.bristle.inertia_about_root * absolute**2,
        potential_energy=0.5 * tool.belt.stiffness * alpha**2,
        normal_force=np.zeros_like(time),
        hub_speed=tool.hub.speed,
        events=named if events is None else events,
        contacts=(make_contact(angle[samples], absolute[samples - 1], absolute[samples]),),
        stop_reason=StopReason.END,
        cost=Cost(0.0, 0.0, 1),
    )


def make_contact(angle, before, after, outcome="rebound"):
    return ContactRecord(
        obstacle="workpart",
        law="energetic",
        outcome=outcome,
        time=STRIKE,
        duration=0.0,
        impulse=(2e-3, -1e-3),
        compressive_impulse=None,
        compressive_work=None,
        restitutive_work=None,
        velocity_before=(-10.0, 20.0),
        velocity_after=(4.0, -8.0),
        angles=(float(angle),),
        rates_before=(float(before),),
        rates_after=(float(after),),
    )


def artist(owner, gid):
    (found,) = owner.findobj(lambda each: each.get_gid() == gid)
    return found
