"""Compare chapter 3's assumed force curve with the force of a simulated contact that brakes the bristle.

The curve (3.19) is a ball's on a plate, its shape carried over to the bristle. It is compared with the bristle's own contact
in the scene, on a spring, with the same compressive impulse and compression time.

A curve fitted to a measured record may take its place (3.2-3.4). The fit assumes a form of the force with few parameters,
(3.3). Two checks independent of the form show whether the record has it: the impulse as a sum over the points, and residuals
beyond the noise, which is estimated from second differences.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, amount, rows
from bristle_sim.dissertation.printed import printed_number
from bristle_sim.force_file import read_force_csv
from bristle_sim.parameters import Bristle, ForceHistory, Hub, Measurement, Surface
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.timed_contact import contact_fields, timed_contact, work_row
from bristle_sim.theory.force_fit import ForceFit, fit_force_history
from bristle_sim.theory.force_history import BRISTLE, ForceCurve

SUMMED_BEYOND = 0.1
"""Part of the contact's duration before its start and after its end over which the points' impulse is summed."""

FORM = 0.05
"""Chosen: part of the peak force by which a contact's form may differ from (3.3), root mean square. A half sine differs by
0.027, sin^1.5 (Hertz) by 0.003, a rectangle by 0.22."""

FORM_IMPULSE = 0.02
"""Chosen likewise, of the impulse: a half sine's fit has 0.9 % more, that of sin^1.5 the same."""

NEAR_PEAK = 0.05
"""Part of the duration before and after the peak over which its force is averaged; a clipped record is lower there."""

CERTAIN = 5.0
"""Standard deviations of noise that a difference may have."""


@dataclass(frozen=True, slots=True)
class MeasuredForce:
    """Points of a contact and the curve fitted to them, whose start is on the file's clock; arrays of shape (n,).

    Times in s since that start reach from half a duration before it to half a duration after the contact's end; forces in N are
    those above the baseline. An inverted file has them with the opposite sign;
    ``reading`` tells from which columns and in which units they were read.
    """

    time: Array
    force: Array
    fit: ForceFit
    inverted: bool = False
    reading: str = ""

    @property
    def noise(self) -> float:
        """Return the standard deviation of a point, N, from second differences, whose variance is 6 times a point's."""
        second = np.diff(self.force, 2)
        return math.sqrt(float(second @ second) / 6.0 / second.size)


@dataclass(frozen=True, slots=True)
class ForceComparison:
    """Results of the comparison, from which its figures are drawn.

    The curve is (3.19), or the one fitted to measured points. The contact is None if the bristle can have none of that kind;
    ``no_contact`` is the reason.
    """

    curve: ForceCurve
    contact: TimedContact | None
    measured: MeasuredForce | None
    no_contact: str = ""


def force_comparison(
    hub: Hub, bristle: Bristle, surface: Surface, history: ForceHistory, measurement: Measurement, settings: Settings
) -> Report:
    """Compare the simulated contact with the curve of chapter 3, or with one fitted to measured points.

    Raises ValueError for points that are no force history.
    """
    measured, contact, no_contact = _measured_force(measurement), None, ""
    curve = BRISTLE if measured is None else measured.fit.curve
    peak, gamma = curve.peak_time(), math.radians(history.impact_angle_deg)
    timed: dict[str, float] = {"compression_time": history.compression_time or peak}
    if history.speed_ratio is None:
        timed["impulse"] = float(curve.impulse(peak))
    else:
        timed["rate"] = history.speed_ratio * hub.speed
    try:
        contact = timed_contact(hub, bristle, surface, gamma, settings, **timed)
    except ValueError as error:
        no_contact = str(error)
    subject = ForceComparison(curve, contact, measured, no_contact)
    main = _main_rows(subject, history, 10.0 * max(1e-6, settings.accuracy))  # ten times timed_contact's own tolerance
    if contact is not None:
        fields, works = contact_fields(contact, end=float(contact.time[-1])), [work_row(contact)]
        speed = f"{contact.tip_speed:.2f} m/s with mu = {contact.surface.friction:g}"
        simulated = f"resultant force of a bristle whose tip strikes at {speed}"
    else:  # a measurement is fitted whether this bristle could make such a contact or not
        fields, works = {"outcome": None} if measured else contact_fields(None), []
        simulated = f"nothing; {no_contact}"
    source = ("theory: the curve as printed in (3.19)",) if measured is None else _measured_in_words(measured)
    return Report(
        **fields,
        quantities=(*main, *works, *(_measured_rows(measured) if measured else ())),
        remarks=(*source, f"simulated: {simulated}"),
        extra={"measured_fit": None if measured is None else _as_dict(measured.fit)},
        subject=subject,
        answer=_answer(subject, main),
    )


def _answer(subject: ForceComparison, main: Sequence[Quantity]) -> str:
    peak, time, impulse = main
    curve = "chapter 3's curve" if subject.measured is None else "the curve fitted to the measurement"
    own = f"{curve} {amount(peak.theory or 0.0, 'N')}"
    if peak.simulated is None or time.simulated is None or impulse.simulated is None:
        return f"There is no simulated force: {subject.no_contact}. By {own} is the peak."
    compared = "at the same" if time.ok and impulse.ok else "at an"
    return (
        f"The simulated force peaks at {amount(peak.simulated, 'N')}, {own} ({peak.relative_difference or 0.0:+.0%}), {compared}"
        f" impulse of {amount(impulse.simulated, 'N s')} and compression time of {amount(time.simulated, 's')}."
    )


def _main_rows(subject: ForceComparison, history: ForceHistory, tolerance: float) -> tuple[Quantity, ...]:
    """Compare force, time and impulse; the last two agree by construction where they are taken from the curve."""
    curve, contact = subject.curve, subject.contact
    peak = curve.peak_time()
    units = {
        "peak_force": ("peak force", "N"),
        "compression_time": ("compression time", "s"),
        "compressive_impulse": ("impulse of compression p_c", "N s"),
    }
    simulated = {} if contact is None else {name: float(getattr(contact, name)) for name in units}
    theory = dict(zip(units, (curve.peak_force(), peak, float(curve.impulse(peak))), strict=True))
    same = {"compression_time": history.compression_time is None, "compressive_impulse": history.speed_ratio is None}
    if contact is None and subject.measured is not None:
        same = {}  # there is nothing to compare a measurement with that this tool's bristle could not make
    places = ("eq. 3.21: largest force", "eq. 3.20: compression time", "eq. 3.9: compressive impulse of the bristle")
    printed = dict(zip(units, map(printed_number, places), strict=True)) if curve is BRISTLE else {}
    return rows(units, simulated, theory, {}, printed, lambda name: tolerance if same.get(name) else None)


def _as_dict(fit: ForceFit) -> dict[str, Any]:
    """Return the values and standard errors by name, start in s, baseline and the residuals' root mean square in N."""
    values, errors = (dict(zip(fit.names, each.tolist(), strict=True)) for each in (fit.values, fit.standard_errors))
    numbers = {name: getattr(fit, name) for name in ("start", "baseline", "root_mean_square")}
    return numbers | {"values": values, "standard_errors": errors}


def _measured_force(measurement: Measurement) -> MeasuredForce | None:
    """Read and fit the file; None where there is none.

    Raises ValueError for a file that is no force history, in one line with the key.
    """
    if measurement.force_csv is None:
        return None
    columns = {name: getattr(measurement, name) for name in ("time_column", "force_column", "force_per_volt")}
    try:
        time, force, reading = read_force_csv(measurement.force_csv, **columns)
    except ValueError as error:
        raise ValueError(f"force_csv = {error}") from None
    try:
        found = _fitted(time, force)
        if not _measured_rows(found)[-1].ok:
            found = _pulled(time, force) or found
    except ValueError as error:
        # A contact only pushes: where nothing is found but in the opposite sense, the sensor's sign is meant.
        pulled = _pulled(time, force)
        if pulled is None:
            raise ValueError(f"force_csv = {measurement.force_csv}: {error}") from None
        found = pulled
    return dataclasses.replace(found, reading=reading)


def _pulled(time: Array, force: Array) -> MeasuredForce | None:
    """Return the contact in a record with the opposite sign; None where there is none of the curve's form."""
    try:
        found = dataclasses.replace(_fitted(time, -force), inverted=True)
    except ValueError:
        return None
    return found if all(each.ok for each in _measured_rows(found)) else None


def _fitted(time: Array, force: Array) -> MeasuredForce:
    fit = fit_force_history(time, force)
    later, length = time - fit.start, fit.curve.duration
    shown = (later >= -0.5 * length) & (later <= 1.5 * length)
    return MeasuredForce(later[shown], force[shown] - fit.baseline, fit)


def _measured_rows(measured: MeasuredForce) -> tuple[Quantity, ...]:
    """Compare the fit's impulse and its force near the peak with those of the points, and its misfit with the noise."""
    curve, noise, peak = measured.fit.curve, measured.noise, measured.fit.curve.peak_force()
    length = curve.duration
    inside = (measured.time >= -SUMMED_BEYOND * length) & (measured.time <= (1.0 + SUMMED_BEYOND) * length)
    time, force = measured.time[inside], measured.force[inside]
    fitted = float(curve.impulse(min(float(time[-1]), length), max(float(time[0]), 0.0)))
    summed = float(np.trapezoid(force, time))
    # Points h apart have errors of noise sqrt(h T) in their sum, which the fit's amplitude shares.
    spread = CERTAIN * noise * math.sqrt(2.0 * length * float(np.mean(np.diff(time)))) / abs(summed)
    # Over n points, squared residuals have a variance of 2 noise^4/n, squared second differences of 3.9 noise^4/n.
    chance = CERTAIN * math.sqrt(6.0 / force.size) * (noise / peak) ** 2
    misfit = math.sqrt(max(0.0, measured.fit.root_mean_square**2 - noise**2)) / peak
    rows = [Quantity("fitted_impulse", "N s", fitted, reference=summed, tolerance=FORM_IMPULSE + spread)]
    top = np.abs(time - curve.peak_time()) <= NEAR_PEAK * length
    if top.any():
        slack = FORM + CERTAIN * noise / math.sqrt(int(top.sum())) / peak
        near, points = float(np.asarray(curve(time[top])).mean()), float(force[top].mean())
        rows.append(Quantity("fitted_force_near_peak", "N", near, reference=points, tolerance=slack))
    within = math.sqrt(FORM**2 + chance)
    return (*rows, Quantity("fit_misfit", "1", misfit, reference=0.0, tolerance=within))


def _measured_in_words(measured: MeasuredForce) -> tuple[str, ...]:
    fit = measured.fit
    level = f"{fit.baseline:.4g} N" if "baseline" in fit.names else "0, no samples outside the contact"
    sign = ("the file's force is negative in the contact: taken with the opposite sign",) if measured.inverted else ()
    pairs = zip(fit.names, fit.values.tolist(), fit.standard_errors.tolist(), strict=True)
    shown = ", ".join(f"{name} = {value:.5g} +- {error:.1g}" for name, value, error in pairs)
    return (
        f"read from the file: {measured.reading}",
        *sign,
        f"contact found at {1e6 * fit.start:.6g} us on the file's clock, for {1e6 * fit.curve.duration:.4g} us;"
        f" baseline {level}",
        f"theory: the curve (3.3) fitted to it, {shown}; residuals {fit.root_mean_square:.2g} N",
    )
