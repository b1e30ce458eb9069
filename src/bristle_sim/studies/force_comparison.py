"""The force curve that chapter 3 of Zhang 2020 assumes, compared with the force of a simulated
contact of the bristle.

The curve (3.19) is that of a ball on a plate, transferred to the bristle. The simulated contact is
a spring, by default with the compressive impulse and the compression time of the curve. A curve of
the form (3.3), fitted to a measured record, may replace (3.19). The residuals of the fit, less the
noise, show whether the record has that form. The noise is estimated from second differences.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, Values, rows
from bristle_sim.dissertation.printed import printed_number
from bristle_sim.force_file import read_force_csv
from bristle_sim.parameters import Bristle, ForceHistory, Hub, Measurement, Surface
from bristle_sim.readable import amount
from bristle_sim.settings import Settings
from bristle_sim.studies.timed_contact import TimedContact, contact_fields, timed_contact
from bristle_sim.theory.force_fit import ForceFit, fit_force_history
from bristle_sim.theory.force_history import BRISTLE, ForceCurve

QUANTITIES = {
    "peak_force": ("peak force", "N"),
    "compression_time": ("compression time", "s"),
    "compressive_impulse": ("impulse of compression p_c", "N s"),
}

PRINTED = {
    "peak_force": "eq. 3.21: largest force",
    "compression_time": "eq. 3.20: compression time",
    "compressive_impulse": "eq. 3.9: compressive impulse of the bristle",
}
"""Where the dissertation prints the value of each quantity."""

# Largest root mean square difference, divided by the peak force, at which a record counts as having
# the form of eq. 3.3. A half sine differs by 0.027, sin^1.5 (Hertz) by 0.003, a rectangle by 0.22.
FORM = 0.05
# Largest excess of the mean square residual over the variance of the noise that is attributed to
# chance, in standard deviations of this excess
CERTAIN = 5.0


@dataclass(frozen=True, slots=True)
class MeasuredForce:
    """Measured points of a contact, and the curve fitted to them.

    Attributes:
        time: times of the points since the start of the fitted contact (s), shape (n,). They extend
            beyond the contact by half of its duration on both sides.
        force: forces above the baseline (N), shape (n,).
        fit: the fitted curve with its standard errors.
        reading: sentence that names the columns and units in which the file was read.
    """

    time: Array
    force: Array
    fit: ForceFit
    reading: str


@dataclass(frozen=True, slots=True)
class ForceComparison:
    """Results of the comparison, from which its figures are drawn.

    Attributes:
        curve: force curve of eq. 3.19 of the dissertation, or the curve fitted to measured points.
        contact: the simulated contact; None if no contact of the bristle has the requested values.
        measured: the measured points; None if there is no measurement.
        no_contact: reason why there is no contact.
    """

    curve: ForceCurve
    contact: TimedContact | None
    measured: MeasuredForce | None
    no_contact: str = ""


def force_comparison(
    hub: Hub,
    bristle: Bristle,
    surface: Surface,
    history: ForceHistory,
    measurement: Measurement,
    settings: Settings,
) -> Report:
    """Compare the force of a simulated contact with the dissertation's curve (chapter 3).

    ``history`` holds the settings of the simulated contact. If ``measurement`` names a file, a
    curve fitted to the measured points replaces the dissertation's curve.

    Raises:
        ValueError: if the measured points are not the force of a contact.
    """
    measured = None if measurement.force_csv is None else _measured_force(measurement)
    contact = None
    no_contact = ""
    curve = BRISTLE if measured is None else measured.fit.curve
    peak = curve.peak_time()
    theory = {
        "peak_force": curve.peak_force(),
        "compression_time": peak,
        "compressive_impulse": float(curve.impulse(peak)),
    }
    gamma = math.radians(history.impact_angle_deg)
    timed = {"compression_time": history.compression_time or peak}
    if history.speed_ratio is None:
        timed["impulse"] = theory["compressive_impulse"]
    else:
        timed["rate"] = history.speed_ratio * hub.speed
    try:
        contact = timed_contact(hub, bristle, surface, gamma, settings, **timed)
    except ValueError as error:
        no_contact = str(error)
    # The contact is adjusted to the curve's time or impulse unless the user gives other values. The
    # adjusted values agree by construction, to ten times the tolerance of the adjustment. Nothing
    # is compared if no contact of this bristle can have the values of a measured record.
    within = dict[str, float]()
    if contact is not None or measured is None:
        allowed = 10.0 * max(1e-6, settings.accuracy)
        if history.compression_time is None:
            within["compression_time"] = allowed
        if history.speed_ratio is None:
            within["compressive_impulse"] = allowed
    simulated: Values = {}
    fields: dict[str, Any] = {"outcome": "no contact" if measured is None else None}
    shown = f"nothing; {no_contact}"
    if contact is not None:
        simulated = {name: getattr(contact, name) for name in QUANTITIES}
        fields = contact_fields(contact, end=float(contact.time[-1]))
        speed = f"{contact.tip_speed:.2f} m/s with mu = {surface.friction:g}"
        shown = f"resultant force of a bristle whose tip strikes at {speed}"
    if measured is None:
        printed = {name: printed_number(place) for name, place in PRINTED.items()}
        main = rows(QUANTITIES, simulated, theory, {}, printed, within)
        checks = []
        source = ["theory: the curve as printed in (3.19)"]
        name = "chapter 3's curve"
        extra = None
    else:
        main = rows(QUANTITIES, simulated, theory, tolerances=within)
        checks = [_misfit(measured)]
        source = _measured_in_words(measured)
        name = "the curve fitted to the measurement"
        extra = _as_dict(measured.fit)
    return Report(
        **fields,
        quantities=(*main, *checks),
        remarks=(*source, f"simulated: {shown}"),
        extra={"measured_fit": extra},
        subject=ForceComparison(curve, contact, measured, no_contact),
        answer=_answer(name, main, no_contact),
    )


def _answer(curve: str, main: Sequence[Quantity], no_contact: str) -> str:
    peak, time, impulse = main
    own = f"{amount(peak.theory or 0.0, 'N')} of {curve}"
    if peak.simulated is None or time.simulated is None or impulse.simulated is None:
        return f"There is no simulated force: {no_contact}. The peak is the {own}."
    apart = peak.relative_difference or 0.0
    side = "below" if apart < 0.0 else "above"
    compared = "at the same" if time.ok and impulse.ok else "at an"
    return (
        f"The simulated force peaks at {amount(peak.simulated, 'N')}, {100.0 * abs(apart):.0f} % {side} the {own}, {compared}"
        f" impulse of {amount(impulse.simulated, 'N s')} and compression time of {amount(time.simulated, 's')}."
    )


def _as_dict(fit: ForceFit) -> dict[str, Any]:
    """Return a fit as a dictionary for the JSON output.

    It holds the fitted values and their standard errors by name, the start of the contact (s), the
    baseline (N) and the root mean square of the residuals (N).
    """
    return {
        "start": fit.start,
        "baseline": fit.baseline,
        "root_mean_square": fit.root_mean_square,
        "values": dict(zip(fit.names, fit.values, strict=True)),
        "standard_errors": dict(zip(fit.names, fit.standard_errors, strict=True)),
    }


def _measured_force(measurement: Measurement) -> MeasuredForce:
    """Read the file of a measurement, and fit a curve to its points.

    Raises:
        ValueError: if the file does not hold the force of a contact. The message is one line that
            names the parameter.
    """
    name = str(measurement.force_csv)
    columns = {
        name: getattr(measurement, name)
        for name in ("time_column", "force_column", "force_per_volt")
    }
    try:
        time, force, reading = read_force_csv(name, **columns)
    except ValueError as error:
        raise ValueError(f"force_csv = {error}") from None
    try:
        fit = fit_force_history(time, force)
    except ValueError as error:
        raise ValueError(f"force_csv = {name}: {error}") from None
    later = time - fit.start
    length = fit.curve.duration
    shown = (later >= -0.5 * length) & (later <= 1.5 * length)
    return MeasuredForce(later[shown], force[shown] - fit.baseline, fit, reading)


def _misfit(measured: MeasuredForce) -> Quantity:
    """Return the root mean square residual of a fit, divided by the peak force.

    The measurement noise, which is estimated from second differences of the force, is subtracted.
    """
    second = np.diff(measured.force, 2)  # variance: 6 times that of the noise at a point
    peak = measured.fit.curve.peak_force()
    noise = float(second @ second) / 6.0 / second.size / peak**2
    # ``noise`` is a variance. The mean of n squared residuals has the variance 2 noise^2/n, that of
    # n squared second differences, divided by 6, the variance 3.9 noise^2/n.
    chance = CERTAIN * math.sqrt(6.0 / measured.force.size) * noise
    misfit = math.sqrt(max(0.0, (measured.fit.root_mean_square / peak) ** 2 - noise))
    within = math.sqrt(FORM**2 + chance)
    return Quantity("fit_misfit", "1", misfit, reference=0.0, tolerance=within)


def _measured_in_words(measured: MeasuredForce) -> list[str]:
    fit = measured.fit
    level = (
        f"{fit.baseline:.4g} N" if "baseline" in fit.names else "0, no samples outside the contact"
    )
    pairs = zip(fit.names, fit.values.tolist(), fit.standard_errors.tolist(), strict=True)
    shown = ", ".join(f"{name} = {value:.5g} +- {error:.1g}" for name, value, error in pairs)
    found = f"contact found at {1e6 * fit.start:.6g} us on the file's clock, for {1e6 * fit.curve.duration:.4g} us"
    return [
        f"read from the file: {measured.reading}",
        f"{found}; baseline {level}",
        f"theory: the curve (3.3) fitted to it, {shown}; residuals {fit.root_mean_square:.2g} N",
    ]
