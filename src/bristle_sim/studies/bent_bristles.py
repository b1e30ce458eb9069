"""Three tools that differ in the bristle's knee: bent backwards, straight, and bent forwards. Which
tips slide on the workpart, and which retract at once?

In the high-speed film (Zhang 2020, figs. 1.3 and 1.4, 2600 rpm) the forward bent tip retracts as
soon as it strikes, while the other two slide first. The farther ahead a knee puts the tip, the
sooner friction reverses the slip during the strike. The wire is a chain of links. The contact is a
spring. Its stiffness is such that a contact of a rigid bristle would last as long as requested.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.whole_pass import require_result, stop_fields
from bristle_sim.trajectory import ContactHistory, ContactRecord, Trajectory

SHAPES = {
    "reverse": ("reverse bent", -1.0),
    "straight": ("straight", 0.0),
    "forward": ("forward bent", 1.0),
}
"""Name of each shape in words, and sign of its knee's angle."""

MEASURES = {
    "forward_slide": ("slide forward", "m"),
    "slide_in_touch": ("slide in the whole contact", "m"),
    "time_in_touch": ("time in touch", "s"),
    "tip_speed_along_before": ("tip speed along, before", "m/s"),
    "tip_speed_along_after": ("tip speed along, after", "m/s"),
    "tip_speed_away_after": ("tip speed away, after", "m/s"),
}
"""Measures of a strike: label and unit of each."""

# A tip counts as retracting at once if it slides forward by no more than this fraction of the
# largest forward slide of the three tips.
RETRACTS = 0.05

COMPLIANT = "must be compliant; another law has no path of the tip"
"""Requirement on the contact law, in words."""

Slides = Mapping[str, float | None]
"""Forward slide of the tip in its first strike (m) by the shape; None if the tip does not strike."""


@dataclass(frozen=True, slots=True)
class BentBristles:
    """The simulated passes of three bristle shapes, by the name of the shape.

    Attributes:
        trajectories: motion of each bristle.
        slides: forward slide of each tip in its first strike (m); None if the tip does not strike.
    """

    trajectories: dict[str, Trajectory]
    slides: Slides


def slide_path(history: ContactHistory) -> Array:
    """Return the tip's displacement along the workpart since the first touch (m), shape (n,).

    The array has one entry for each of the n samples of ``history``. The displacement is the time
    integral of the tangential velocity, by the trapezoidal rule.
    """
    speed = history.tangential_velocity
    steps = 0.5 * np.diff(history.time) * (speed[1:] + speed[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)])


def slide_measures(contact: ContactRecord) -> dict[str, float]:
    """Return the tip's slide along the workpart in a contact, and its speeds before and after the
    contact.

    ``MEASURES`` lists the names and units. ``slide_in_touch`` is the displacement from the first
    touch to the release. It is negative if the tip ends behind the point of first touch.

    Raises:
        ValueError: if the contact has no time history. Only the compliant law records one.
    """
    if contact.history is None:
        raise ValueError(f"contact = {contact.law}: {COMPLIANT}")
    path = slide_path(contact.history)
    return {
        "forward_slide": float(path.max()),
        "slide_in_touch": float(path[-1]),
        "time_in_touch": contact.duration,
        "tip_speed_along_before": contact.velocity_before[1],
        "tip_speed_along_after": contact.velocity_after[1],
        "tip_speed_away_after": contact.velocity_after[0],
    }


def bent_bristles(tool: Tool, settings: Settings) -> Report:
    """Simulate three bristles, bent backwards, straight and bent forwards, and compare their
    slides.

    The angle of the tool's knee gives the magnitude of both bends.

    Raises:
        ValueError: if the contact law is not ``compliant``, or a pass exceeds its step budget
            before the strike.
    """
    if tool.contact.law != "compliant":
        raise ValueError(f"contact = {tool.contact.law}: {COMPLIANT}")
    knee = abs(tool.bristle.knee_angle_deg)
    runs = {
        shape: simulate(tool.replace(knee_angle_deg=sign * knee), settings)
        for shape, (_, sign) in SHAPES.items()
    }
    slides = dict[str, float | None]()
    quantities = list[Quantity]()
    events = list[tuple[str, float]]()
    remarks = list[str]()
    for shape, run in runs.items():
        contact = run.first_contact("workpart")
        values = dict[str, float]()
        course = "never strikes"
        if contact is None or contact.history is None:
            require_result(run, settings)
        else:
            events.append((f"{shape} strike", contact.time))
            values = slide_measures(contact)
            since = contact.history.time - contact.history.time[0]
            farthest = 1e6 * since[slide_path(contact.history).argmax()]
            course = (
                f"{', '.join(contact.phases)}; farthest forward {farthest:.1f} us after the touch"
            )
        slides[shape] = values.get("forward_slide")
        remarks.append(f"{shape}: {course}")
        for name, (label, unit) in MEASURES.items():
            words = f"{SHAPES[shape][0]}: {label}"
            quantities.append(Quantity(f"{shape}_{name}", unit, values.get(name), label=words))
    return Report(
        quantities=tuple(quantities),
        events=tuple(sorted(events, key=lambda event: event[1])),
        wall_s=sum(run.cost.wall_s for run in runs.values()),
        steps=sum(run.cost.steps for run in runs.values()),
        remarks=(*remarks, against_film(slides)),
        extra={"stopped": {shape: stop_fields(run) for shape, run in runs.items()}},
        not_reached=max(run.accuracy_not_reached for run in runs.values()),
        subject=BentBristles(runs, slides),
        answer=answer(slides),
    )


def answer(slides: Slides) -> str:
    """Return in words how far each tip slides, and which tips retract without sliding forward."""
    farthest = max((slide for slide in slides.values() if slide is not None), default=None)
    if farthest is None:
        return "No tip slides, because none strikes the workpart."
    parts = []
    for shape, slide in slides.items():
        motion = "retracts at once"
        if slide is None:
            motion = "never strikes"
        elif slide > RETRACTS * farthest:
            motion = f"slides {1e3 * slide:.2f} mm"
        parts.append(f"the {SHAPES[shape][0]} tip {motion}")
    words = ", ".join(parts).capitalize()
    return f"{words}; in the high-speed film only the forward bent one retracts at once."


def against_film(slides: Slides) -> str:
    """Return a sentence that compares the slides with the dissertation's high-speed film.

    It states the slide of the forward bent tip relative to the mean of the other two slides.
    """
    found = [slide for slide in slides.values() if slide is not None]
    if len(found) < len(SHAPES):
        return "not every shape strikes: nothing to compare with the film"
    others = 0.5 * (found[0] + found[1])
    if others <= 0.0:
        return "neither the reverse bent nor the straight tip slides forward, unlike in the film"
    return f"forward bent slides {100.0 * found[2] / others:.0f} % as far as the mean of the other two; in the high-speed film not at all"
