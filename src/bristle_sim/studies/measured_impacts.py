"""Measured impacts predicted by the impact laws: spheres that strike glass obliquely, and a planar ellipse on a floor.

Spheres: aluminium oxide, 5 mm, on soda-lime glass at 3.9 m/s (Kharaz, Gorham and Salman 2001, Powder Technology 120,
281-291); the points were read off the published figures. Nothing is fitted: K = diag(1, 7/2)/m, e = 0.98, mu = 0.092.
Ellipse: the planar impact data set of Fazeli, Donlon, Drumwright and Rodriguez (2017), in a file that the user gives.
Friction and restitution are fitted on every second impact, and each law predicts the others.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, Table
from bristle_sim.parameters import Measured
from bristle_sim.theory.impact import Impact, energetic_impact, newton_impact, poisson_impact

SPEED, RADIUS, FRICTION, RESTITUTION = 3.9, 0.0025, 0.092, 0.98  # m/s, m (Kharaz et al. 2001)

VELOCITY_RATIO = np.array([
    (1.84, 0.79344), (3.703, 0.74533), (9.496, 0.67257), (20.012, 0.59691), (30.127, 0.68756), (39.382, 0.77148),
    (49.694, 0.84761), (60.02, 0.90142),
])  # fmt: skip
"""Angle of incidence from the normal, deg, and tangential velocity of the centre after over before (Kharaz et al. 2001)."""

SPIN = np.array([
    (6.143, 136.18), (10.991, 265.69), (21.251, 577.65), (31.157, 612.88), (39.143, 595.49), (50.348, 453.21), (60.328, 382.09),
])  # fmt: skip
"""Angle of incidence, deg, and spin after the impact, rad/s (Kharaz et al. 2001)."""

REBOUND_ANGLE = np.array([
    (0.016, 0.074), (2.15, 1.733), (4.096, 2.962), (9.826, 6.518), (20.567, 12.208), (30.29, 21.67), (39.535, 32.613),
    (49.747, 45.125), (60.208, 57.474),
])  # fmt: skip
"""Angle of incidence and angle at which the centre leaves, from the normal, deg (Kharaz et al. 2001)."""

MEASURED_SPHERES = {"restitution": VELOCITY_RATIO, "spin": SPIN, "rebound_angle": REBOUND_ANGLE}

MASS, HALF_AXES, GYRATION = 0.0364, (0.035, 0.025), 0.0192  # kg, m, m: the data set's own description

RESAMPLES = 200
"""Resamples of the fitted half for the confidence of the fit: its limits are then good to some 5 % of their width."""

GRID = 31  # Values of mu and of e* at which resampled halves are fitted, about the fit

Law = Callable[..., Impact]


@dataclass(frozen=True, slots=True)
class Spheres:
    """A law's prediction for the spheres: root mean square error of each measured quantity, and the curves."""

    compliance: float
    errors: dict[str, float]


@dataclass(frozen=True, slots=True)
class Ellipse:
    """The impacts of the file: states (..., 3) before and after, contact Jacobian (..., 2, 3) and K (..., 2, 2) of each.

    Velocities are (v_x, v_y, angular velocity), the latter clockwise as in the file.
    """

    before: Array
    after: Array
    jacobian: Array
    inverse_mass: Array

    def part(self, chosen: slice) -> Ellipse:
        """Return some of the impacts."""
        return Ellipse(self.before[chosen], self.after[chosen], self.jacobian[chosen], self.inverse_mass[chosen])

    def predicted(self, law: Law, friction: float, restitution: float, **compliance: float) -> Impact:
        """Return the impacts by a law, from the velocity of the point of contact before."""
        approach = np.einsum("kij,kj->ki", self.jacobian, self.before)
        return law(self.inverse_mass, approach, friction, restitution, **compliance)

    def misfit(self, hit: Impact | Array) -> Array:
        """Return |v predicted - v measured|/|v measured| of each impact, or impulse, in the norm of the kinetic energy."""
        impulse = (
            hit if isinstance(hit, np.ndarray) else np.stack([hit.impulse_normal, hit.impulse_tangential], axis=-1)
        )
        missed = self.before + np.einsum("kij,ki->kj", self.jacobian, impulse) / INERTIA - self.after
        return np.asarray(np.sqrt((missed**2 @ INERTIA) / (self.after**2 @ INERTIA)))

    def best_impulse(self) -> Array:
        """Return the impulse at the point that comes nearest to the measured state, in the same norm."""
        change = np.einsum("kij,kj->ki", self.jacobian, self.after - self.before)
        return np.linalg.solve(self.inverse_mass, change[..., None])[..., 0]


INERTIA = np.array([MASS, MASS, MASS * GYRATION**2])


def sphere_rebound(angle_deg: Array, compliance: float) -> dict[str, Array]:
    """Return the velocity ratio, the spin in rad/s and the rebound angle in deg of spheres that strike at angles in deg."""
    angle = np.radians(angle_deg)
    velocity = SPEED * np.stack([-np.cos(angle), np.sin(angle)], axis=-1)
    hit = energetic_impact(np.diag([1.0, 3.5]), velocity, FRICTION, RESTITUTION, tangential_compliance=compliance)
    along = velocity[..., 1] + hit.impulse_tangential
    return {
        "restitution": along / velocity[..., 1],
        "spin": -2.5 * hit.impulse_tangential / RADIUS,
        "rebound_angle": np.degrees(np.arctan2(along, hit.velocity_normal)),
    }


def spheres(compliance: float) -> Spheres:
    """Return the root mean square errors of the prediction of the spheres."""
    errors = {}
    for name, points in MEASURED_SPHERES.items():
        found = sphere_rebound(points[:, 0], compliance)[name]
        errors[name] = float(np.sqrt(np.mean((found - points[:, 1]) ** 2)))
    return Spheres(compliance, errors)


def elastic_compliance(poisson_ratio: float) -> float:
    """Return eta^2 = (2 - nu)/(2 (1 - nu)) of two bodies of one material (Stronge 2018, ch. 5)."""
    return (2.0 - poisson_ratio) / (2.0 * (1.0 - poisson_ratio))


def read_ellipse(path: str) -> Ellipse:
    """Read the impacts of the file whose flags are all 0, with the arms that the ellipse and its angle give.

    The angle runs clockwise: a body turned by it has its point of contact at x = (a^2 - b^2) sin cos/h from the centre, a height
    h = sqrt(a^2 sin^2 + b^2 cos^2) below it, and there v_n = v_y - x w and v_t = v_x - h w.

    Raises ValueError if there is no such file, or it holds no such impacts.
    """
    from scipy.io import loadmat

    if not Path(path).is_file():
        raise ValueError(f"data = {path}: must be a file with the measured impacts of the ellipse")
    try:
        bounces = np.atleast_1d(loadmat(path, squeeze_me=True, struct_as_record=False)["bounce_array"])
        chosen = [each for each in bounces if not np.any(each.flags)]
        states = np.array([each.states for each in chosen], dtype=float).reshape(-1, 12)
    except Exception:  # scipy raises what the file's bytes lead to
        raise ValueError(
            f"data = {path}: must be a MATLAB file with an array bounce_array of states and flags"
        ) from None
    if len(states) < 4 or not np.all(np.isfinite(states)):
        raise ValueError(f"data = {path}: must hold at least four impacts of finite numbers")
    sine, cosine = np.sin(states[:, 2]), np.cos(states[:, 2])
    long, short = (each**2 for each in HALF_AXES)
    height = np.sqrt(long * sine**2 + short * cosine**2)
    ahead = (long - short) * sine * cosine / height
    one, none = np.ones_like(ahead), np.zeros_like(ahead)
    jacobian = np.stack([np.stack([none, one, -ahead], -1), np.stack([one, none, -height], -1)], axis=-2)
    inverse_mass = np.einsum("kij,klj->kil", jacobian, jacobian / INERTIA)
    return Ellipse(states[:, 3:6], states[:, 9:12], jacobian, inverse_mass)


@dataclass(frozen=True, slots=True)
class Fit:
    """A law fitted on one half of the impacts: mu, e*, and the mean misfit of its predictions of the other half."""

    law: Law
    compliance: dict[str, float]
    friction: float
    restitution: float
    error: float


def fitted(law: Law, train: Ellipse, test: Ellipse, **compliance: float) -> Fit:
    """Fit mu and e* to the least mean misfit of one half, from the best point of a coarse grid, and predict the other half."""
    from scipy.optimize import minimize

    def mean(at: Array) -> float:
        friction, restitution = float(abs(at[0])), float(np.clip(at[1], 0.0, 1.0))
        return float(train.misfit(train.predicted(law, friction, restitution, **compliance)).mean())

    starts = [np.array([mu, e]) for mu in (0.05, 0.15, 0.25, 0.4) for e in (0.3, 0.5, 0.7)]
    best = minimize(mean, min(starts, key=mean), method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-7}).x
    friction, restitution = float(abs(best[0])), float(np.clip(best[1], 0.0, 1.0))
    error = test.misfit(test.predicted(law, friction, restitution, **compliance)).mean()
    return Fit(law, compliance, friction, restitution, float(error))


def confidence(train: Ellipse, fit: Fit) -> Array:
    """Return the limits of 95 % of mu and e*, shape (2, 2), from fits to resampled halves, on a grid about the fit."""
    about = (fit.friction * np.linspace(0.7, 1.3, GRID), fit.restitution * np.linspace(0.8, 1.2, GRID))
    pairs = np.array([each.ravel() for each in np.meshgrid(*about, indexing="ij")])
    hits = (train.predicted(fit.law, mu, min(e, 1.0), **fit.compliance) for mu, e in pairs.T)
    table, rng = np.stack([train.misfit(hit) for hit in hits]), np.random.default_rng(0)
    count = table.shape[1]
    best = [np.argmin(table[:, rng.integers(0, count, count)].mean(axis=1)) for _ in range(RESAMPLES)]
    return np.asarray(np.quantile(pairs[:, best], (0.025, 0.975), axis=1).T)


def measured_impacts(measured: Measured) -> Report:
    """Predict the spheres, and the ellipse where there is a file with its impacts."""
    squared, units = measured.tangential_compliance, {"restitution": "1", "spin": "rad/s", "rebound_angle": "deg"}
    compliant, rigid = spheres(squared), spheres(0.0)
    quantities = [
        Quantity(f"{prefix}{name}_error{'_deg' if unit == 'deg' else ''}", unit, each.errors[name])
        for prefix, each in (("", compliant), ("rigid_", rigid))
        for name, unit in units.items()
    ]
    rows = []
    for nu in (0.23, 0.3):
        errors = spheres(elastic_compliance(nu)).errors
        shown = f"{errors['restitution']:.4f}", f"{errors['spin']:.1f}", f"{errors['rebound_angle']:.3f}"
        rows.append((f"nu = {nu:g}", f"{elastic_compliance(nu):.3f}", *shown))
    head = ("spheres, elastic constants", "eta^2", "velocity ratio", "spin, rad/s", "rebound, deg")
    tables = (Table("Root mean square errors", head, tuple(rows)),)
    answer = (
        f"Spheres on glass: with eta^2 = {squared:.4g} the law misses the measured velocity ratio by "
        f"{compliant.errors['restitution']:.3f}, spin by {compliant.errors['spin']:.0f} rad/s and rebound angle by "
        f"{compliant.errors['rebound_angle']:.2f}°; a rigid surface by {rigid.errors['restitution']:.3f}, "
        f"{rigid.errors['spin']:.0f} rad/s and {rigid.errors['rebound_angle']:.2f}°."
    )
    found = Report(None, tuple(quantities), tables=tables, subject=(compliant, rigid, None), answer=answer)
    return found if measured.data is None else _with_ellipse(found, read_ellipse(measured.data), squared)


def _with_ellipse(spheres: Report, ellipse: Ellipse, compliance: float) -> Report:
    """Add the laws fitted on every second impact of the ellipse, and their predictions of the others."""
    train, test = ellipse.part(slice(0, None, 2)), ellipse.part(slice(1, None, 2))
    laws: dict[str, Law] = {"energetic": energetic_impact, "poisson": poisson_impact, "newton": newton_impact}
    fits = {name: fitted(law, train, test) for name, law in laws.items()}
    fits["compliant"] = fitted(energetic_impact, train, test, tangential_compliance=compliance)
    own, limits = fits["energetic"], confidence(train, fits["energetic"])
    values = {"impacts": float(len(ellipse.before)), **{f"{name}_error": fit.error for name, fit in fits.items()}}
    values |= {"best_impulse_error": float(test.misfit(test.best_impulse()).mean())}
    values |= {"friction": own.friction, "restitution": own.restitution}
    hit = test.predicted(own.law, own.friction, own.restitution)
    remarks = (
        f"Friction {limits[0, 0]:.3f} to {limits[0, 1]:.3f} and restitution {limits[1, 0]:.3f} to {limits[1, 1]:.3f} in"
        f" 95 of 100 of {RESAMPLES} resampled halves.",
        "The arms are those of the ellipse at its angle, which runs clockwise; the tangential Jacobian's last entry then has"
        " the other sign than in the file.",
    )
    answer = (
        f" Ellipse: the energetic law leaves {own.error:.3f} of the outgoing velocity, with compliance"
        f" {fits['compliant'].error:.3f}, the best point impulse {values['best_impulse_error']:.3f}."
    )
    return dataclasses.replace(
        spheres,
        quantities=(*spheres.quantities, *(Quantity(name, "1", value) for name, value in values.items())),
        remarks=remarks,
        tables=(*spheres.tables, _motions(hit), _over_lever(test, hit)),
        subject=(*spheres.subject[:2], (test, fits)),
        answer=spheres.answer + answer,
    )


def _motions(hit: Impact) -> Table:
    last = np.where(hit.phase_impulse[:, 3] > 0.0, hit.phase_slip[:, 3], hit.phase_slip[:, 2])
    reverse = float(np.mean((last != 0.0) & (last == -hit.phase_slip[:, 0])))
    stuck = float(np.mean(last == 0.0))
    cells = (("slip", 1.0 - reverse - stuck), ("stick", stuck), ("reverse slip", reverse))
    return Table("The ellipse's impacts end in", ("motion", "fraction"), tuple((k, f"{v:.3f}") for k, v in cells))


def _over_lever(test: Ellipse, hit: Impact) -> Table:
    """Return the mean misfit in quarters of the lever between the centre and the normal through the point of contact."""
    lever, misfit = -test.jacobian[:, 0, 2], test.misfit(hit)
    edges = np.quantile(lever, (0.0, 0.25, 0.5, 0.75, 1.0))
    quarter = np.clip(np.searchsorted(edges, lever, side="right") - 1, 0, 3)
    means = (f"{misfit[quarter == i].mean():.3f}" for i in range(4))
    rows = zip((f"{1e3 * low:.1f} to {1e3 * high:.1f}" for low, high in pairwise(edges)), means, strict=True)
    return Table("Error over the lever", ("lever, mm", "mean error"), tuple(rows))
