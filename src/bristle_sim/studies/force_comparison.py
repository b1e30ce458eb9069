"""Compare chapter 3 with a simulated contact: the assumed force curve and the force that braking the bristle takes.

The curve (3.19) is a ball's on a plate, its shape carried over to the bristle. It is compared with the bristle's own contact
in the scene, on a spring, with the same compressive impulse and compression time. The fit of section 3.1 is tried on
points of the curve, exact and noisy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, rows
from bristle_sim.parameters import Bristle, Hub, Strike, Surface
from bristle_sim.parameters.experiments import ForceHistory, Measurement
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.force_fits import (
    FitTrial,
    MeasuredForce,
    fit_as_dict,
    fit_trials,
    measured_force,
    measured_in_words,
    measured_rows,
)
from bristle_sim.studies.timed_contact import reported, resultant_impulse, timed_contact, work_row
from bristle_sim.theory.force_history import (
    BALL,
    BRISTLE,
    PRINTED_BRISTLE_IMPULSE,
    TABLE_3_1,
    ForceCurve,
    segment_impulses,
)
from bristle_sim.theory.monofilament import tip_speed

SEGMENTS = 10
"""Equal parts of the compression (Zhang 2020, table 3.1)."""

OPERATING_SPEED = float(tip_speed(Bristle().length, Hub().radius, Hub().speed, Strike().speed_ratio))
"""Speed of the tip, m/s, at 845.6 rad/s as an absolute rate (Zhang 2020, eq. 4.3)."""

PRINTED = {"peak_force": 57.0, "compression_time": 5e-5, "compressive_impulse": PRINTED_BRISTLE_IMPULSE}
"""Zhang 2020, eqs. 3.21, 3.20 and 3.9."""


@dataclass(frozen=True, slots=True)
class ForceComparison:
    """Results of the comparison, from which its figures are drawn.

    The curve is (3.19), or the one fitted to measured points. There is no contact where the bristle has none of that kind, as
    ``no_contact`` says. Trials are those of the fit.
    """

    curve: ForceCurve
    contact: TimedContact | None
    trials: tuple[FitTrial, ...]
    measured: MeasuredForce | None
    no_contact: str = ""


def force_comparison(
    hub: Hub, bristle: Bristle, surface: Surface, history: ForceHistory, measurement: Measurement, settings: Settings
) -> Report:
    """Compare the simulated contact with the curve of chapter 3, or with one fitted to measured points.

    Raises:
        ValueError: for points that are no force history.
    """
    measured, contact, no_contact = measured_force(measurement), None, ""
    curve = BRISTLE if measured is None else measured.fit.curve
    trials = fit_trials(curve, int(history.points), history.noise)
    peak, gamma = curve.peak_time(), math.radians(history.impact_angle_deg)
    rate = None if history.speed_ratio is None else history.speed_ratio * hub.speed
    impulse = float(curve.impulse(peak)) if rate is None else None
    time = peak if history.compression_time is None else history.compression_time
    try:
        contact = timed_contact(
            hub, bristle, surface, gamma, settings, compression_time=time, rate=rate, impulse=impulse
        )
    except ValueError as error:
        no_contact = str(error)
    subject = ForceComparison(curve, contact, trials, measured, no_contact)
    tolerance = 10.0 * max(1e-6, settings.accuracy)  # timed_contact's own, and what a coarse contact adds to it
    found = Report(
        outcome="no contact",
        quantities=(
            *_main_rows(subject, history, tolerance),
            *(() if contact is None else (work_row(contact),)),
            *(() if measured is None else measured_rows(measured)),
            *(each.row(curve) for each in trials),
        ),
        remarks=_remarks(subject, gamma),
        extra={
            "table_3_1": _table_3_1(subject),
            "measured_fit": None if measured is None else fit_as_dict(measured.fit),
            "fits": [each.as_dict() for each in trials],
        },
        subject=subject,
    )
    return found if contact is None else reported(found, contact, end=float(contact.time[-1]))


def segment_table(contact: TimedContact) -> Array:
    """Return the impulse of the simulated contact in each of ten equal parts of its compression, N s."""
    edges = np.linspace(0.0, contact.compression_time, SEGMENTS + 1)
    return np.array([contact.resultant.integral(*pair) for pair in pairwise(edges.tolist())])


def _main_rows(subject: ForceComparison, history: ForceHistory, tolerance: float) -> tuple[Quantity, ...]:
    """Compare force, time and impulse; the last two agree by construction where they are taken from the curve."""
    curve, contact = subject.curve, subject.contact
    peak = curve.peak_time()
    units = {"peak_force": "N", "compression_time": "s", "compressive_impulse": "N s"}
    simulated = {} if contact is None else {name: float(getattr(contact, name)) for name in units}
    theory = dict(zip(units, (curve.peak_force(), peak, float(curve.impulse(peak))), strict=True))
    same = {"compression_time": history.compression_time is None, "compressive_impulse": history.speed_ratio is None}
    if contact is None and subject.measured is not None:
        same = {}  # there is nothing to compare a measurement with that this tool's bristle could not make
    printed = PRINTED if curve is BRISTLE else {}
    return rows(units, simulated, theory, {}, printed, lambda name: tolerance if same.get(name) else None)


def _table_3_1(subject: ForceComparison) -> list[dict[str, Any]]:
    """Return the ten segments by print, by the ball's curve as printed (3.15), by the curve, and simulated; N s."""
    curve, contact = subject.curve, subject.contact
    printed = curve is BRISTLE
    columns: dict[str, list[float]] = {
        "printed": [1e-4 * float(each) for each in TABLE_3_1] if printed else [],
        "scaled": segment_impulses(BALL, PRINTED_BRISTLE_IMPULSE).tolist() if printed else [],
        "curve": segment_impulses(curve, float(curve.impulse(curve.peak_time()))).tolist(),
        "simulated": [] if contact is None else segment_table(contact).tolist(),
    }
    return [
        {"segment": i + 1, **{name: column[i] if column else None for name, column in columns.items()}}
        for i in range(SEGMENTS)
    ]


def _remarks(subject: ForceComparison, impact_angle: float) -> tuple[str, ...]:
    curve, contact, measured = subject.curve, subject.contact, subject.measured
    source = ("theory: the curve as printed in (3.19)",) if measured is None else measured_in_words(measured)
    simulated: tuple[str, ...] = (f"simulated: nothing; {subject.no_contact}",)
    if contact is not None:
        simulated = _contact_lines(contact, curve, impact_angle)
    amplitudes, decays = (", ".join(f"{value:.6g}" for value in values) for values in (curve.amplitude, curve.decay))
    trials = f"least-squares fit (3.2-3.4) to points of the curve, c = {amplitudes}, lambda = {decays} /s:"
    name = "table 3.1" if curve is BRISTLE else "tenths"
    lines = [f"{name + ', 1e-4 N s':<22}{'printed':>10}{'by (3.15)':>10}{'curve':>10}{'simulated':>10}"]
    for segment, *row in (each.values() for each in _table_3_1(subject)):
        cells = "".join(f"{'-' if value is None else f'{1e4 * value:.4f}':>10}" for value in row)
        lines.append(f"{f'  segment {segment}':<22}{cells}")
    return ("", *source, *simulated, "", *lines, "", trials, *map(str, subject.trials))


def _contact_lines(contact: TimedContact, curve: ForceCurve, impact_angle: float) -> tuple[str, ...]:
    mu = contact.surface.friction
    rigid = resultant_impulse(contact.bristle.mass, contact.tip_speed, impact_angle, mu)
    ratio = contact.peak_force * contact.compression_time / contact.compressive_impulse
    peak = curve.peak_time()
    curve_ratio = curve.peak_force() * peak / float(curve.impulse(peak))
    speed = f"{contact.tip_speed:.2f} m/s (operating point {OPERATING_SPEED:.2f})"
    lasting = f"{1e6 * contact.compression_time:.4g} us"
    shape = "peak force times compression time over impulse:"
    return (
        f"simulated: resultant force of a bristle whose tip strikes at {speed} with mu = {mu:g};",
        f"  at that speed an impact of no duration has p_c = {1e3 * rigid:.4f}e-3 N s, here the hub turns on for {lasting}",
        f"{shape} {ratio:.4f} simulated, {curve_ratio:.4f} by the curve, pi/2 = {math.pi / 2:.4f} for a plain spring",
    )
