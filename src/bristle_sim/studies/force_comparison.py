"""Compare chapter 3 with a simulated contact: the assumed force curve and the force that braking the bristle takes.

The curve (3.19) is a ball's on a plate, its shape carried over to the bristle. It is compared with the bristle's own contact
in the scene, on a spring, with the same compressive impulse and compression time. A curve fitted to measured points may take
its place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from bristle_sim.comparison import Quantity, Report, rows
from bristle_sim.parameters import Bristle, Hub, Surface
from bristle_sim.parameters.experiments import ForceHistory, Measurement
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_course import TimedContact
from bristle_sim.studies.force_fits import (
    MeasuredForce,
    fit_as_dict,
    measured_force,
    measured_in_words,
    measured_rows,
)
from bristle_sim.studies.timed_contact import reported, timed_contact, work_row
from bristle_sim.theory.force_history import BRISTLE, PRINTED_BRISTLE_IMPULSE, ForceCurve

PRINTED = {"peak_force": 57.0, "compression_time": 5e-5, "compressive_impulse": PRINTED_BRISTLE_IMPULSE}
"""Zhang 2020, eqs. 3.21, 3.20 and 3.9."""


@dataclass(frozen=True, slots=True)
class ForceComparison:
    """Results of the comparison, from which its figures are drawn.

    The curve is (3.19), or the one fitted to measured points. There is no contact where the bristle has none of that kind, as
    ``no_contact`` says.
    """

    curve: ForceCurve
    contact: TimedContact | None
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
    subject = ForceComparison(curve, contact, measured, no_contact)
    tolerance = 10.0 * max(1e-6, settings.accuracy)  # timed_contact's own, and what a coarse contact adds to it
    found = Report(
        outcome="no contact",
        quantities=(
            *_main_rows(subject, history, tolerance),
            *(() if contact is None else (work_row(contact),)),
            *(() if measured is None else measured_rows(measured)),
        ),
        remarks=_remarks(subject),
        extra={"measured_fit": None if measured is None else fit_as_dict(measured.fit)},
        subject=subject,
    )
    return found if contact is None else reported(found, contact, end=float(contact.time[-1]))


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


def _remarks(subject: ForceComparison) -> tuple[str, ...]:
    contact, measured = subject.contact, subject.measured
    source = ("theory: the curve as printed in (3.19)",) if measured is None else measured_in_words(measured)
    simulated = f"simulated: nothing; {subject.no_contact}"
    if contact is not None:
        speed = f"{contact.tip_speed:.2f} m/s with mu = {contact.surface.friction:g}"
        simulated = f"simulated: resultant force of a bristle whose tip strikes at {speed}"
    return "", *source, simulated
