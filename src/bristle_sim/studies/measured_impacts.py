"""Measured impacts compared with the impact laws: spheres that strike glass obliquely, and a planar
ellipse on a floor.

Spheres: aluminium oxide, 5 mm, on soda-lime glass at 3.9 m/s (Kharaz, Gorham and Salman 2001,
Powder Technology 120, 281-291). The points were read off the published figures. Nothing is fitted:
the inverse mass matrix is K = diag(1, 7/2)/m, the energetic restitution e* = 0.98, and the friction
mu = 0.092.

Ellipse: the planar impact data set of Fazeli, Donlon, Drumwright and Rodriguez (2017), in a file
that the user gives. Friction and restitution are fitted to every second impact, and each law
predicts the other impacts.
"""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Measured
from bristle_sim.theory.impact import Impact, energetic_impact, newton_impact, poisson_impact

# Speed (m/s), radius (m), friction and restitution of the spheres (Kharaz et al. 2001)
SPEED = 3.9
RADIUS = 0.0025
FRICTION = 0.092
RESTITUTION = 0.98

# Measured pairs by Kharaz et al. 2001: the angle of incidence from the normal (deg), and one value.
# This value is the tangential velocity of the centre after the impact divided by that before
# (restitution), the angular velocity after the impact (spin, rad/s), or the angle of the rebound
# from the normal (rebound_angle, deg).
MEASURED_SPHERES = {
    "restitution": np.array([
        (1.84, 0.79344), (3.703, 0.74533), (9.496, 0.67257), (20.012, 0.59691), (30.127, 0.68756), (39.382, 0.77148),
        (49.694, 0.84761), (60.02, 0.90142),
    ]),
    "spin": np.array([
        (6.143, 136.18), (10.991, 265.69), (21.251, 577.65), (31.157, 612.88), (39.143, 595.49), (50.348, 453.21),
        (60.328, 382.09),
    ]),
    "rebound_angle": np.array([
        (0.016, 0.074), (2.15, 1.733), (4.096, 2.962), (9.826, 6.518), (20.567, 12.208), (30.29, 21.67),
        (39.535, 32.613), (49.747, 45.125), (60.208, 57.474),
    ]),
}  # fmt: skip
SPHERE_ERRORS = {
    "restitution_error": "1",
    "spin_error": "rad/s",
    "rebound_angle_error_deg": "deg",
}
"""Names and units of the errors of the predicted values, in the order of MEASURED_SPHERES."""

# Mass (kg), half axes (m) and radius of gyration (m) of the ellipse, by the data set's description
MASS = 0.0364
HALF_AXES = (0.035, 0.025)
GYRATION = 0.0192
INERTIA = np.array([MASS, MASS, MASS * GYRATION**2])

Law = Callable[..., Impact]


class Ellipse(NamedTuple):
    """Measured impacts of an elliptical body on the floor.

    Attributes:
        before: velocities (v_x, v_y, angular velocity) before each impact, shape (n, 3), in m/s and
            rad/s. The angular velocity is positive clockwise, as in the file.
        after: velocities after each impact, in the same form.
        jacobian: contact Jacobian of each impact, shape (n, 2, 3). It maps the body's velocities to
            those of the contact point.
    """

    before: Array
    after: Array
    jacobian: Array

    @property
    def inverse_mass(self) -> Array:
        """Inverse mass matrix K at the contact of each impact (1/kg), shape (n, 2, 2)."""
        return np.asarray((self.jacobian / INERTIA) @ self.jacobian.swapaxes(1, 2))

    def at_contact(self, velocity: Array) -> Array:
        """Return the velocities (normal, tangential) of the contact point (m/s), shape (n, 2).

        ``velocity`` are the body's velocities, as in ``before``.
        """
        return np.asarray((self.jacobian @ velocity[..., np.newaxis])[..., 0])

    def predicted(self, law: Law, friction: float, restitution: float) -> Array:
        """Return the impulses (normal, tangential) that a contact law gives (N s), shape (n, 2).

        The impulses follow from the measured velocities before the impacts.
        """
        approach = self.at_contact(self.before)
        hit = law(self.inverse_mass, approach, friction, restitution)
        return np.stack([hit.impulse_normal, hit.impulse_tangential], axis=-1)

    def misfit(self, impulse: Array) -> float:
        """Return the mean relative error of the velocities after the impacts.

        The velocities are computed with ``impulse``, the impulses (normal, tangential) in N s,
        shape (n, 2). The error is |v computed - v measured|/|v measured|, in the norm that the
        kinetic energy defines.
        """
        change = np.einsum("kij,ki->kj", self.jacobian, impulse) / INERTIA
        missed = self.before + change - self.after
        return float(np.sqrt((missed**2 @ INERTIA) / (self.after**2 @ INERTIA)).mean())

    def best_impulse(self) -> Array:
        """Return the impulses that best explain the measured velocities after the impacts.

        The impulses minimise the distance between computed and measured velocities, in the norm
        that the kinetic energy defines. They are (normal, tangential) in N s, shape (n, 2).
        """
        change = self.at_contact(self.after - self.before)
        return np.asarray(np.linalg.solve(self.inverse_mass, change[..., np.newaxis])[..., 0])


def sphere_rebound(angle_deg: Array, compliance: float) -> dict[str, Array]:
    """Return the predicted rebound of spheres at given angles of incidence.

    Args:
        angle_deg: angles between the velocity and the surface's normal, deg.
        compliance: ratio eta^2 of tangential to normal compliance of the contact.

    Returns:
        ``restitution`` is the tangential velocity after the impact divided by that before it.
            ``spin`` is the angular velocity after the impact, rad/s. ``rebound_angle`` is measured
            from the normal, deg.
    """
    angle = np.radians(angle_deg)
    velocity = SPEED * np.stack([-np.cos(angle), np.sin(angle)], axis=-1)
    hit = energetic_impact(
        np.diag([1.0, 3.5]), velocity, FRICTION, RESTITUTION, tangential_compliance=compliance
    )
    along = velocity[..., 1] + hit.impulse_tangential
    return {
        "restitution": along / velocity[..., 1],
        "spin": -2.5 * hit.impulse_tangential / RADIUS,
        "rebound_angle": np.degrees(np.arctan2(along, hit.velocity_normal)),
    }


def spheres(compliance: float) -> dict[str, float]:
    """Return the root mean square error of each predicted quantity of the spheres, by name.

    ``compliance`` is the ratio eta^2 of tangential to normal compliance of the contact.
    """
    found = {}
    for name, at in MEASURED_SPHERES.items():
        missed = sphere_rebound(at[:, 0], compliance)[name] - at[:, 1]
        found[name] = float(np.sqrt(np.mean(missed**2)))
    return found


# Longest time to read a file, s. Usually it takes 1 s, on a busy machine less than 10 s.
LONGEST_READING = 60.0

READER = """
import sys
import numpy as np
try:
    import resource
    resource.setrlimit(resource.RLIMIT_AS, (2**32, 2**32))  # bytes: a damaged length would fill the memory
except (ImportError, OSError, ValueError):  # Windows, macOS
    pass
from scipy.io import loadmat
bounces = np.atleast_1d(loadmat(sys.argv[1], squeeze_me=True, struct_as_record=False)["bounce_array"])
chosen = [each.states for each in bounces if not np.any(each.flags)]
np.save(sys.stdout.buffer, np.array(chosen, dtype=float).reshape(-1, 12))
"""
"""Program that reads a MATLAB file and writes the states before and after its impacts.

It runs in a process of its own, since SciPy's reader may crash on a damaged file."""


def read_ellipse(path: str) -> Ellipse:
    """Read the measured impacts of the elliptical body from a file, with their contact Jacobians.

    Only impacts whose flags are all 0 are read. In the file the body's angle phi is positive
    clockwise. With the half axes a and b the contact point is at the depth

        h = sqrt(a^2 sin^2 phi + b^2 cos^2 phi)

    below the body's centre, and at the horizontal distance x = (a^2 - b^2) sin phi cos phi/h from
    the centre. The velocity of the contact point is v_n = v_y - x w and v_t = v_x - h w, with the
    angular velocity w.

    Raises:
        ValueError: if the file does not exist or has fewer than four impacts of finite numbers.
    """
    if not Path(path).is_file():
        raise ValueError(f"data = {path}: must be a file with the measured impacts of the ellipse")
    try:
        command = [sys.executable, "-P", "-c", READER, path]
        done = subprocess.run(command, capture_output=True, check=True, timeout=LONGEST_READING)
        states = np.load(io.BytesIO(done.stdout), allow_pickle=False)
    except (subprocess.SubprocessError, OSError, ValueError):
        raise ValueError(
            f"data = {path}: must be a MATLAB file with an array bounce_array of states and flags"
        ) from None
    if len(states) < 4 or not np.all(np.isfinite(states)):
        raise ValueError(f"data = {path}: must hold at least four impacts of finite numbers")
    sine, cosine = np.sin(states[:, 2]), np.cos(states[:, 2])
    long, short = np.square(HALF_AXES)
    height = np.sqrt(long * sine**2 + short * cosine**2)
    ahead = (long - short) * sine * cosine / height
    zero = 0.0 * height
    rows = [[zero, zero + 1.0, -ahead], [zero + 1.0, zero, -height]]
    return Ellipse(states[:, 3:6], states[:, 9:12], np.moveaxis(np.array(rows), -1, 0))


def fitted(law: Law, train: Ellipse) -> tuple[float, float]:
    """Return the friction mu and restitution e* that fit a contact law to the impacts ``train``.

    Both minimise the mean relative error of the velocities after the impacts. The search starts at
    the best point of a coarse grid.
    """
    from scipy.optimize import minimize

    def misfit(at: Array) -> float:
        """Return the mean relative error of the velocities with friction and restitution ``at``."""
        return train.misfit(train.predicted(law, *bounded(at)))

    def bounded(at: Array) -> tuple[float, float]:
        """Return friction and restitution, moved into their ranges."""
        return float(abs(at[0])), float(np.clip(at[1], 0.0, 1.0))

    starts = [np.array([mu, e]) for mu in (0.05, 0.15, 0.25, 0.4) for e in (0.3, 0.5, 0.7)]
    options = {"xatol": 1e-4, "fatol": 1e-7}
    start = min(starts, key=misfit)
    return bounded(minimize(misfit, start, method="Nelder-Mead", options=options).x)


def measured_impacts(measured: Measured) -> Report:
    """Predict the rebound of the spheres and of the elliptical body, and report the errors.

    The elliptical body is left out if its data file is not given.
    """
    squared = measured.tangential_compliance
    errors = spheres(squared)
    rigid = spheres(0.0)
    quantities = [
        Quantity(f"{prefix}{name}", unit, value)
        for prefix, found in (("", errors), ("rigid_", rigid))
        for (name, unit), value in zip(SPHERE_ERRORS.items(), found.values(), strict=True)
    ]
    form = "the velocity ratio by {:.3f}, the spin by {:.0f} rad/s and the rebound angle by {:.2f}°"
    answer = (
        f"For measured spheres on glass the law with a tangential compliance eta^2 = {squared:.4g} misses {form.format(*errors.values())};"
        f" without it, it misses {form.format(*rigid.values())}."
    )
    remarks = list[str]()
    if measured.data is not None:
        values = ellipse_errors(read_ellipse(measured.data), squared)
        quantities += [Quantity(name, "1", value) for name, value in values.items()]
        remarks.append(
            "The arms are those of the ellipse at its angle, which runs clockwise; the tangential Jacobian's last entry then has"
            " the other sign than in the file."
        )
        answer += (
            f" Ellipse: the energetic law leaves {values['energetic_error']:.3f} of the outgoing velocity, with compliance"
            f" {values['compliant_error']:.3f}, the best point impulse {values['best_impulse_error']:.3f}."
        )
    return Report(
        quantities=tuple(quantities), remarks=tuple(remarks), subject=squared, answer=answer
    )


def ellipse_errors(ellipse: Ellipse, compliance: float) -> dict[str, float]:
    """Fit each contact law to every second impact, and return its mean error on the other impacts.

    The result also has the number of impacts, the mean error with the impulses that fit best, and
    the friction and restitution of the fitted energetic law. ``compliance`` is the ratio eta^2 of
    tangential to normal compliance of the contact.
    """
    train, test = (Ellipse(*(each[first::2] for each in ellipse)) for first in (0, 1))
    laws: dict[str, Law] = {
        "energetic": energetic_impact,
        "poisson": poisson_impact,
        "newton": newton_impact,
        "compliant": partial(energetic_impact, tangential_compliance=compliance),
    }
    fits = {name: fitted(law, train) for name, law in laws.items()}
    values = {"impacts": float(len(ellipse.before))}
    for name, law in laws.items():
        values[f"{name}_error"] = test.misfit(test.predicted(law, *fits[name]))
    values["best_impulse_error"] = test.misfit(test.best_impulse())
    values["friction"], values["restitution"] = fits["energetic"]
    return values
