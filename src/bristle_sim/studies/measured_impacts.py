"""Measured impacts compared with the impact laws: spheres that strike glass obliquely, and a planar
ellipse on a floor.

Spheres: aluminium oxide, 5 mm, on soda-lime glass at 3.9 m/s (Kharaz, Gorham and Salman 2001,
Powder Technology 120, 281-291). The points were read off the published figures. Nothing is fitted:
K = diag(1, 7/2)/m, e = 0.98, mu = 0.092.

Ellipse: the planar impact data set of Fazeli, Donlon, Drumwright and Rodriguez (2017), in a file
that the user gives. Friction and restitution are fitted to every second impact, and each law
predicts the other impacts.
"""

from __future__ import annotations

import dataclasses
import io
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, Table
from bristle_sim.parameters import Measured
from bristle_sim.theory.impact import Impact, energetic_impact, newton_impact, poisson_impact

# Speed (m/s), radius (m), friction and restitution of the spheres (Kharaz et al. 2001)
SPEED = 3.9
RADIUS = 0.0025
FRICTION = 0.092
RESTITUTION = 0.98

# Measured values over the angle of incidence from the normal, deg (Kharaz et al. 2001): ratio of
# the tangential velocity
# of the centre after to before, spin after (rad/s), and rebound angle of the centre from the normal
# (deg).
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
# Mass (kg), half axes (m) and radius of gyration (m) of the ellipse, by the description of the data
# set
MASS = 0.0364
HALF_AXES = (0.035, 0.025)
GYRATION = 0.0192
# Number of resamples of the fitted half: the confidence limits then have errors of some 5 % of
# their width.
RESAMPLES = 200
GRID = 31  # number of values of mu and of e* about the fit, at which resampled halves are fitted

Law = Callable[..., Impact]


@dataclass(frozen=True, slots=True)
class Ellipse:
    """The impacts of the file.

    Attributes:
        before: velocities before, (v_x, v_y, angular velocity), shape (..., 3); the angular
            velocity is clockwise, as in the file.
        after: velocities after, as ``before``.
        jacobian: contact Jacobian of each impact, shape (..., 2, 3).
        inverse_mass: K of each impact, shape (..., 2, 2).
    """

    before: Array
    after: Array
    jacobian: Array
    inverse_mass: Array

    def part(self, chosen: slice) -> Ellipse:
        """Return the chosen impacts."""
        return Ellipse(
            self.before[chosen],
            self.after[chosen],
            self.jacobian[chosen],
            self.inverse_mass[chosen],
        )

    def predicted(
        self, law: Law, friction: float, restitution: float, **compliance: float
    ) -> Impact:
        """Return the impacts by a law from the contact velocities before."""
        approach = np.einsum("kij,kj->ki", self.jacobian, self.before)
        return law(self.inverse_mass, approach, friction, restitution, **compliance)

    def misfit(self, hit: Impact | Array) -> Array:
        """Return |v predicted - v measured|/|v measured| in the norm of the kinetic energy.

        ``hit`` holds the impacts, or their impulses.
        """
        impulse = (
            hit
            if isinstance(hit, np.ndarray)
            else np.stack([hit.impulse_normal, hit.impulse_tangential], axis=-1)
        )
        missed = (
            self.before + np.einsum("kij,ki->kj", self.jacobian, impulse) / INERTIA - self.after
        )
        return np.asarray(np.sqrt((missed**2 @ INERTIA) / (self.after**2 @ INERTIA)))

    def best_impulse(self) -> Array:
        """Return the impulse at the contact that comes nearest to the measured state, in the norm
        of the kinetic energy.
        """
        change = np.einsum("kij,kj->ki", self.jacobian, self.after - self.before)
        return np.linalg.solve(self.inverse_mass, change[..., None])[..., 0]


INERTIA = np.array([MASS, MASS, MASS * GYRATION**2])


def sphere_rebound(angle_deg: Array, compliance: float) -> dict[str, Array]:
    """Return velocity ratio, spin (rad/s) and rebound angle (deg) of spheres over the angle of
    incidence (deg).
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
    """Return the root mean square error of the law for each measured quantity of the spheres."""
    missed = {
        name: sphere_rebound(at[:, 0], compliance)[name] - at[:, 1]
        for name, at in MEASURED_SPHERES.items()
    }
    return {name: float(np.sqrt(np.mean(each**2))) for name, each in missed.items()}


def elastic_compliance(poisson_ratio: float) -> float:
    """Return eta^2 = (2 - nu)/(2 (1 - nu)) of two bodies of one material (Stronge 2018, ch. 5)."""
    return (2.0 - poisson_ratio) / (2.0 * (1.0 - poisson_ratio))


# longest time to read a file, s; usual is 1 s, on a busy machine less than 10 s
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
"""Program that writes the states of the impacts of a MATLAB file.

It runs in a process of its own, since SciPy's reader may crash on a damaged file."""


def read_ellipse(path: str) -> Ellipse:
    """Read the impacts of the file whose flags are all 0, with their contact Jacobians.

    The angle of the ellipse runs clockwise. A body turned by it has its contact at x = (a^2 - b^2)
    sin cos/h from the centre, a height h = sqrt(a^2 sin^2 + b^2 cos^2) below it. There v_n = v_y -
    x w and v_t = v_x - h w.

    Raises:
        ValueError: if the file does not exist or has no such impacts.
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
    long, short = (each**2 for each in HALF_AXES)
    height = np.sqrt(long * sine**2 + short * cosine**2)
    ahead = (long - short) * sine * cosine / height
    jacobian = np.zeros((len(states), 2, 3))
    jacobian[:, 0, 1] = jacobian[:, 1, 0] = 1.0
    jacobian[:, 0, 2], jacobian[:, 1, 2] = -ahead, -height
    inverse_mass = np.einsum("kij,klj->kil", jacobian, jacobian / INERTIA)
    return Ellipse(states[:, 3:6], states[:, 9:12], jacobian, inverse_mass)


def fitted(law: Law, train: Ellipse, **compliance: float) -> tuple[float, float]:
    """Return the mu and e* of least mean misfit; the search starts at the best point of a coarse
    grid.
    """
    from scipy.optimize import minimize

    def mean(at: Array) -> float:
        return float(train.misfit(train.predicted(law, *bounded(at), **compliance)).mean())

    def bounded(at: Array) -> tuple[float, float]:
        return float(abs(at[0])), float(np.clip(at[1], 0.0, 1.0))

    starts = [np.array([mu, e]) for mu in (0.05, 0.15, 0.25, 0.4) for e in (0.3, 0.5, 0.7)]
    options = {"xatol": 1e-4, "fatol": 1e-7}
    return bounded(minimize(mean, min(starts, key=mean), method="Nelder-Mead", options=options).x)


def confidence(train: Ellipse, friction: float, restitution: float) -> Array:
    """Return the limits of 95 % of mu and e*, shape (2, 2), by fits to resampled halves on a grid
    about the fit.
    """
    about = (friction * np.linspace(0.7, 1.3, GRID), restitution * np.linspace(0.8, 1.2, GRID))
    pairs = np.array([each.ravel() for each in np.meshgrid(*about, indexing="ij")])
    hits = (train.predicted(energetic_impact, mu, min(e, 1.0)) for mu, e in pairs.T)
    table = np.stack([train.misfit(hit) for hit in hits])
    rng = np.random.default_rng(0)
    count = table.shape[1]
    best = [
        np.argmin(table[:, rng.integers(0, count, count)].mean(axis=1)) for _ in range(RESAMPLES)
    ]
    return np.asarray(np.quantile(pairs[:, best], (0.025, 0.975), axis=1).T)


def measured_impacts(measured: Measured) -> Report:
    """Predict the impacts of the spheres and, if its file is given, of the ellipse."""
    squared = measured.tangential_compliance
    names = ("restitution_error", "spin_error", "rebound_angle_error_deg")
    errors = list(spheres(squared).values())
    rigid = list(spheres(0.0).values())
    units = ("1", "rad/s", "deg")
    tables = []
    quantities = [
        *map(Quantity, names, units, errors),
        *map(Quantity, (f"rigid_{name}" for name in names), units, rigid),
    ]
    for nu in (0.23, 0.3):
        ratio, spin, angle = spheres(elastic_compliance(nu)).values()
        tables.append(
            (
                f"nu = {nu:g}",
                f"{elastic_compliance(nu):.3f}",
                f"{ratio:.4f}",
                f"{spin:.1f}",
                f"{angle:.3f}",
            )
        )
    head = ("spheres, elastic constants", "eta^2", "velocity ratio", "spin, rad/s", "rebound, deg")
    form = "{:.3f}, spin by {:.0f} rad/s and rebound angle by {:.2f}°"
    answer = (
        f"Spheres on glass: with eta^2 = {squared:.4g} the law misses the measured velocity ratio by {form.format(*errors)};"
        f" with a rigid surface by {form.format(*rigid)}."
    )
    table = Table("Root mean square errors", head, tuple(tables))
    found = Report(None, tuple(quantities), tables=(table,), subject=squared, answer=answer)
    return (
        found
        if measured.data is None
        else _with_ellipse(found, read_ellipse(measured.data), squared)
    )


def _with_ellipse(spheres: Report, ellipse: Ellipse, compliance: float) -> Report:
    """Return the report with the laws fitted to every second impact of the ellipse, and their
    predictions of the others.
    """
    train = ellipse.part(slice(0, None, 2))
    test = ellipse.part(slice(1, None, 2))
    laws: dict[str, Law] = {
        "energetic": energetic_impact,
        "poisson": poisson_impact,
        "newton": newton_impact,
    }
    fits = {name: fitted(law, train) for name, law in laws.items()}
    elastic = {"tangential_compliance": compliance}
    hits = {name: test.predicted(law, *fits[name]) for name, law in laws.items()}
    hits["compliant"] = test.predicted(
        energetic_impact, *fitted(energetic_impact, train, **elastic), **elastic
    )
    friction, restitution = fits["energetic"]
    limits = confidence(train, friction, restitution)
    values = {"impacts": float(len(ellipse.before))}
    values |= {f"{name}_error": float(test.misfit(hit).mean()) for name, hit in hits.items()}
    values |= {"best_impulse_error": float(test.misfit(test.best_impulse()).mean())}
    values |= {"friction": friction, "restitution": restitution}
    remarks = (
        f"Friction {limits[0, 0]:.3f} to {limits[0, 1]:.3f} and restitution {limits[1, 0]:.3f} to {limits[1, 1]:.3f} in"
        f" 95 of 100 of {RESAMPLES} resampled halves.",
        "The arms are those of the ellipse at its angle, which runs clockwise; the tangential Jacobian's last entry then has"
        " the other sign than in the file.",
    )
    answer = (
        f" Ellipse: the energetic law leaves {values['energetic_error']:.3f} of the outgoing velocity, with compliance"
        f" {values['compliant_error']:.3f}, the best point impulse {values['best_impulse_error']:.3f}."
    )
    return dataclasses.replace(
        spheres,
        quantities=(
            *spheres.quantities,
            *(Quantity(name, "1", value) for name, value in values.items()),
        ),
        remarks=remarks,
        tables=(*spheres.tables, _motions(hits["energetic"]), _over_lever(test, hits["energetic"])),
        answer=spheres.answer + answer,
    )


def _motions(hit: Impact) -> Table:
    last = np.where(hit.phase_impulse[:, 3] > 0.0, hit.phase_slip[:, 3], hit.phase_slip[:, 2])
    reverse = float(np.mean((last != 0.0) & (last == -hit.phase_slip[:, 0])))
    stuck = float(np.mean(last == 0.0))
    cells = (("slip", 1.0 - reverse - stuck), ("stick", stuck), ("reverse slip", reverse))
    return Table(
        "The ellipse's impacts end in",
        ("motion", "fraction"),
        tuple((k, f"{v:.3f}") for k, v in cells),
    )


def _over_lever(test: Ellipse, hit: Impact) -> Table:
    """Return the mean misfit in quarters of the lever between the centre and the normal through the
    contact.
    """
    lever = -test.jacobian[:, 0, 2]
    misfit = test.misfit(hit)
    edges = np.quantile(lever, (0.0, 0.25, 0.5, 0.75, 1.0))
    quarter = np.clip(np.searchsorted(edges, lever, side="right") - 1, 0, 3)
    spans = (f"{1e3 * low:.1f} to {1e3 * high:.1f}" for low, high in pairwise(edges))
    cells = tuple((span, f"{misfit[quarter == i].mean():.3f}") for i, span in enumerate(spans))
    return Table("Error over the lever", ("lever, mm", "mean error"), cells)
