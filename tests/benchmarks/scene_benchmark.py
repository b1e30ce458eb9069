"""Drops, slides and rolls on a floor: energy and height by pymunk and by EnergeticContact, beside the exact values.

``python tests/benchmarks/scene_benchmark.py`` prints medians and largest errors over random cases. A drop is compared after its
first impact: energy, and the height to which its centre of mass then rises, both relative to the height of the fall. The exact
impulse is the law's, with K by the bodies' equations of motion, at the root of the lowest point's height; slides stop after
v^2/(2 mu g); a disc that starts without spin rolls with 2/3 of its speed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pymunk
from scipy.optimize import brentq

from bristle_sim import EnergeticContact, energetic_impact
from bristle_sim.benchmarks.machine import surroundings

GRAVITY = 9.81
CASES = 20
Bodies = list[pymunk.Body]


@dataclass(frozen=True)
class Case:
    """Bodies that stand in a space over a floor, their coefficients, and the exact results at a time."""

    make: Callable[[], tuple[pymunk.Space, Bodies]]
    friction: float
    restitution: float
    time: float
    exact: tuple[float, float]
    measure: Callable[[Bodies, float], tuple[float, float]]


def floor() -> pymunk.Space:
    space = pymunk.Space()
    space.gravity = (0.0, -GRAVITY)
    space.collision_slop = 1e-4
    space.add(pymunk.Segment(space.static_body, (-1e3, -1.0), (1e3, -1.0), 1.0))
    return space


def add(space: pymunk.Space, body: pymunk.Body, shape: pymunk.Shape) -> pymunk.Body:
    shape.filter = pymunk.ShapeFilter(group=1)
    space.add(body, shape)
    return body


def state(bodies: Bodies, step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Masses, places of mass centres and velocities, order (x, y, angle); the engine's velocities are half a step ahead."""
    masses = np.array([[each.mass, each.mass, each.moment] for each in bodies])
    places = np.array([[*each.position, each.angle] for each in bodies])
    velocities = np.array([[*each.velocity, each.angular_velocity] for each in bodies])
    return masses, places, velocities + np.array([0.0, 0.5 * GRAVITY * step, 0.0])


def energy_and_rise(
    masses: np.ndarray, places: np.ndarray, velocities: np.ndarray
) -> tuple[float, float]:
    """Energy, and the height to which the common centre of mass rises."""
    weights = masses[:, 1] / masses[:, 1].sum()
    height = weights @ places[:, 1]
    speed = weights @ velocities[:, 1]
    energy = 0.5 * (masses * velocities**2).sum() + GRAVITY * (masses[:, 1] @ places[:, 1])
    return float(energy), float(height + speed * abs(speed) / (2.0 * GRAVITY))


def measured(bodies: Bodies, step: float) -> tuple[float, float]:
    return energy_and_rise(*state(bodies, step))


def drop(kind: str, chance: np.random.Generator) -> Case:
    """A circle, box or jointed pair that falls and rises without touching again for two steps; pairs do not turn before."""
    tilt = chance.uniform(0.2, 0.6)
    spin = 0.0 if kind == "pair" else chance.uniform(-4.0, 4.0)
    height = chance.uniform(1.3, 2.0)
    slide = chance.uniform(-1.0, 1.0)
    friction = float(chance.uniform(0.0, 0.6))
    restitution = float(chance.choice([0.3, 0.6, 0.9, 1.0]))

    def make() -> tuple[pymunk.Space, Bodies]:
        space = floor()
        if kind == "circle":
            bodies = [add(space, body := pymunk.Body(1.0, 0.004), pymunk.Circle(body, 0.1))]
        elif kind == "box":
            bodies = [
                add(
                    space,
                    body := pymunk.Body(1.0, 0.13 / 12.0),
                    pymunk.Poly.create_box(body, (0.2, 0.3)),
                )
            ]
        else:
            bodies = [pymunk.Body(1.0, 1.0 / 12.0) for _ in range(2)]
            for body in bodies:
                add(space, body, pymunk.Poly(body, [(0, 0.5), (0.001, 0.0), (0, -0.5)]))
        for number, body in enumerate(bodies):
            body.angle = tilt
            body.angular_velocity = spin
            body.velocity = (slide, 0.0)
            body.position = (number * math.sin(tilt), height + 1.0 - number * math.cos(tilt))
        if kind == "pair":
            hinge = pymunk.PivotJoint(*bodies, (0.0, -0.5), (0.0, 0.5))
            space.add(hinge)
        return space, bodies

    def lowest(places: np.ndarray) -> np.ndarray:
        x, y, angle = places[-1]
        if kind == "circle":
            return np.array([x, y - 0.1])
        corners = (
            [(0.1, 0.15), (0.1, -0.15), (-0.1, 0.15), (-0.1, -0.15)]
            if kind == "box"
            else [(0.0, -0.5)]
        )
        turned = [
            (
                x + a * math.cos(angle) - b * math.sin(angle),
                y + a * math.sin(angle) + b * math.cos(angle),
            )
            for a, b in corners
        ]
        return np.array(min(turned, key=lambda each: each[1]))

    masses, places, velocities = state(make()[1], 0.0)

    def flight(time: float) -> tuple[np.ndarray, np.ndarray]:
        fall = np.array([0.0, -GRAVITY, 0.0])
        return places + time * velocities + 0.5 * time**2 * fall, velocities + time * fall

    touch = brentq(lambda time: lowest(flight(time)[0])[1], 0.0, 1.0, xtol=1e-15)
    at, before = flight(touch)
    rows = np.zeros((2, *masses.shape))
    arm = lowest(at) - at[-1, :2]
    rows[0, -1], rows[1, -1] = (0.0, 1.0, arm[0]), (1.0, 0.0, -arm[1])
    response = (rows / masses).reshape(2, -1)
    if kind == "pair":
        upper, lower = (
            0.5 * np.array([math.sin(tilt), -math.cos(tilt)]),
            0.5 * np.array([-math.sin(tilt), math.cos(tilt)]),
        )
        joint = np.array([[1, 0, -upper[1], -1, 0, lower[1]], [0, 1, upper[0], 0, -1, -lower[0]]])
        inverse = joint / masses.reshape(-1)
        response = response - response @ joint.T @ np.linalg.solve(inverse @ joint.T, inverse)
    contact = rows.reshape(2, -1)
    impact = energetic_impact(
        response @ contact.T, contact @ before.reshape(-1), friction, restitution
    )
    change = np.array([impact.impulse_normal, impact.impulse_tangential]) @ response
    after = before + change.reshape(before.shape)
    later = [
        at + time * after + 0.5 * time**2 * np.array([0.0, -GRAVITY, 0.0])
        for time in np.linspace(1e-3, 0.04, 40)
    ]
    if min(lowest(each)[1] for each in later) < 1e-4:
        return drop(kind, chance)
    return Case(
        make, friction, restitution, touch + 0.02, energy_and_rise(masses, at, after), measured
    )


def slide(_: str, chance: np.random.Generator) -> Case:
    """A box that slides to rest: where it stops, and its height."""
    speed = float(chance.uniform(0.5, 3.0))
    friction = float(chance.uniform(0.1, 0.6))

    def make() -> tuple[pymunk.Space, Bodies]:
        space = floor()
        body = add(
            space, each := pymunk.Body(1.0, 0.13 / 12.0), pymunk.Poly.create_box(each, (0.3, 0.2))
        )
        body.position = (0.0, 0.1)
        body.velocity = (speed, 0.0)
        return space, [body]

    end = speed**2 / (2.0 * friction * GRAVITY)
    return Case(
        make,
        friction,
        0.5,
        speed / friction / GRAVITY + 0.2,
        (end, 0.1),
        lambda b, _: tuple(b[0].position),
    )


def roll(_: str, chance: np.random.Generator) -> Case:
    """A disc that slides, then rolls: its energy of motion, and its height."""
    speed = float(chance.uniform(0.5, 3.0))
    friction = float(chance.uniform(0.1, 0.6))

    def make() -> tuple[pymunk.Space, Bodies]:
        space = floor()
        body = add(space, each := pymunk.Body(1.0, 0.005), pymunk.Circle(each, 0.1))
        body.position = (0.0, 0.1)
        body.velocity = (speed, 0.0)
        return space, [body]

    def measure(bodies: Bodies, _: float) -> tuple[float, float]:
        (body,) = bodies
        return 0.5 * body.velocity.x**2 + 0.0025 * body.angular_velocity**2, body.position.y

    return Case(
        make, friction, 0.5, speed / friction / GRAVITY + 0.2, (speed**2 / 3.0, 0.1), measure
    )


KINDS: dict[str, Callable[[str, np.random.Generator], Case]] = {
    "circle, drop": drop,
    "box, drop": drop,
    "pair, drop": drop,
    "box, slide": slide,
    "circle, roll": roll,
}


def errors(case: Case, frequency: int, energetic: bool) -> tuple[float, float]:
    """Relative errors of energy (or way) and height at the first step after the time."""
    space, bodies = case.make()
    step = 1.0 / frequency
    for shape in space.shapes:
        shape.friction = math.sqrt(case.friction)
        shape.elasticity = math.sqrt(case.restitution)
    for body in bodies if case.measure is measured else ():
        body.velocity -= (0.0, 0.5 * GRAVITY * step)
    take = space.step
    if energetic:
        take = EnergeticContact(
            space, 0, 0, friction=case.friction, restitution=case.restitution
        ).step
    for _ in range(math.ceil(case.time / step)):
        take(step)
    found = np.array(case.measure(bodies, step))
    first, second = np.abs(found - case.exact) / np.abs(case.exact)
    return float(first), float(second)


def table(cases: int = CASES) -> list[tuple[str, int, str, np.ndarray]]:
    """Kind, steps a second, method, and errors of shape (cases, 2)."""
    found = []
    for name, build in KINDS.items():
        chance = np.random.default_rng(1)
        built = [build(name.split(",", maxsplit=1)[0], chance) for _ in range(cases)]
        for frequency in (60, 240):
            for method in ("pymunk", "EnergeticContact"):
                values = [errors(each, frequency, method == "EnergeticContact") for each in built]
                found.append((name, frequency, method, np.array(values)))
    return found


def main() -> None:
    """Print the table, on what it was measured, and how to measure it again."""
    print(
        "relative errors: energy (of a slide: way), median and largest; height, median and largest"
    )
    for name, frequency, method, values in table():
        (energy, height), (most_energy, most_height) = np.median(values, axis=0), values.max(axis=0)
        print(
            f"{name:<13} 1/{frequency:<4} {method:<17} {energy:9.1e} {most_energy:9.1e}   {height:9.1e} {most_height:9.1e}"
        )
    for name, value in surroundings().items():
        print(f"{name}: {value}")
    print("command: python tests/benchmarks/scene_benchmark.py")


if __name__ == "__main__":
    main()
