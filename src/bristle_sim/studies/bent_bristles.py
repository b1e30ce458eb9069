"""Three tools that differ in the bristle's knee: bent backwards, straight, and bent forwards. Which
tips slide on the workpart, and which retract at once?

In the high-speed film (Zhang 2020, figs. 1.3 and 1.4, 2600 rpm) the forward bent tip retracts as
soon as it strikes, while the other two slide first. The farther ahead a knee puts the tip, the
sooner friction reverses the slip in the strike. The wire is a chain of links. The contact is a
spring, of the stiffness that would keep a rigid bristle in contact for the requested duration.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from bristle_sim.arrays import Array
from bristle_sim.comparison import Quantity, Report, rows
from bristle_sim.parameters import Tool
from bristle_sim.readable import amount
from bristle_sim.scene.simulate import simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.timed_contact import compression_end
from bristle_sim.studies.whole_pass import require_result, stop_fields
from bristle_sim.trajectory import ContactHistory, ContactRecord, Trajectory

SHAPES = {"reverse": -1.0, "straight": 0.0, "forward": 1.0}
NAMES = {"reverse": "reverse bent", "straight": "straight", "forward": "forward bent"}

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
# A tip counts as at rest if its slip speed is no more than this fraction of its fastest slip.
REST = 1e-4


@dataclass(frozen=True, slots=True)
class Slide:
    """Slide of a tip along the workpart in its first strike.

    Attributes:
        forward: largest distance of the tip ahead of its first touch, m.
        total: displacement from the first touch to the release, m; negative if the tip has moved
            back.
        duration: duration of the contact, s.
        compression_time: time from the first touch to the deepest penetration, s.
        ending: how the first slip ends: it ``turns`` into slip in the other direction, or it
            ``stops`` and the tip sticks; None if it lasts until the release.
        ending_phase: phase in which the first slip ends, ``compression`` or ``restitution``; None
            if it lasts.
        ending_time: time from the first touch to the end of the first slip, s; infinite if it
            lasts.
    """

    forward: float
    total: float
    duration: float
    compression_time: float
    ending: Literal["turns", "stops"] | None
    ending_phase: str | None
    ending_time: float

    def __str__(self) -> str:
        """Return a phrase with the distance of the slide, and how and when it ends."""
        ending = "slip neither turns nor stops"
        if self.ending is not None:
            ending = f"slip {self.ending} in {self.ending_phase}, {1e6 * self.ending_time:.1f} us after the touch"
        compression = f"compression ends at {1e6 * self.compression_time:.1f} us"
        return f"{1e3 * self.forward:.2f} mm forward, {ending} ({compression})"


@dataclass(frozen=True, slots=True)
class BentBristles:
    """The three tools, their passes and the slides of their tips.

    The keys are the shapes ``reverse``, ``straight`` and ``forward``. A slide is None if the tip
    does not strike.
    """

    tools: dict[str, Tool]
    trajectories: dict[str, Trajectory]
    slides: dict[str, Slide | None]


def slide_path(history: ContactHistory) -> Array:
    """Return the tip's displacement along the workpart since the first touch (m), shape (n,).

    The tangential velocity is integrated over the n samples by the trapezoidal rule.
    """
    speed = history.tangential_velocity
    steps = 0.5 * np.diff(history.time) * (speed[1:] + speed[:-1])
    return np.concatenate([[0.0], np.cumsum(steps)])


def slide_of(contact: ContactRecord) -> Slide:
    """Return the slide of a tip during its contact with the workpart.

    Raises:
        ValueError: if the contact has no history over time, which only the compliant law records.
    """
    history = contact.history
    if history is None:
        raise ValueError(
            f"contact = {contact.law}: must be compliant; another law has no path of the tip"
        )
    path = slide_path(history)
    since = history.time - history.time[0]
    ends = [
        phase
        for phase in contact.phases
        if not phase.endswith(" slip") or phase.endswith(" reverse slip")
    ]
    speed = history.tangential_velocity
    # In stick the speed is the integrator's error; in reversal it passes through 0.
    over = speed <= REST * np.abs(speed).max()
    return Slide(
        forward=float(path.max()),
        total=float(path[-1]),
        duration=contact.duration,
        compression_time=compression_end(history),
        ending=None if not ends else "stops" if ends[0].endswith(" stick") else "turns",
        ending_phase=ends[0].split()[0] if ends else None,
        ending_time=float(since[np.argmax(over)]) if ends and over.any() else math.inf,
    )


def bent_bristles(tool: Tool, settings: Settings) -> Report:
    """Simulate three passes, with the tool's knee bent backwards, straight, and bent forwards, and
    compare the slides of the tips.

    Raises:
        ValueError: if the contact law is not ``compliant``, or a pass exceeds its step budget
            before the strike.
    """
    if tool.contact.law != "compliant":
        raise ValueError(
            f"contact = {tool.contact.law}: must be compliant; another law has no path of the tip"
        )
    knee = abs(tool.bristle.knee_angle_deg)
    tools = {shape: tool.replace(knee_angle_deg=sign * knee) for shape, sign in SHAPES.items()}
    runs = {shape: simulate(each, settings) for shape, each in tools.items()}
    slides = dict[str, Slide | None]()
    quantities = list[Quantity]()
    events = list[tuple[str, float]]()
    for shape, run in runs.items():
        contact = run.first_contact("workpart")
        slides[shape] = None
        if contact is None:
            require_result(run, settings)
        else:
            events.append((f"{shape} strike", contact.time))
            slides[shape] = slide_of(contact)
        quantities += _rows(shape, contact, slides[shape])
    return Report(
        quantities=tuple(quantities),
        events=tuple(sorted(events, key=lambda event: event[1])),
        wall_s=sum(run.cost.wall_s for run in runs.values()),
        steps=sum(run.cost.steps for run in runs.values()),
        remarks=(
            *(f"{shape}: {slide or 'never strikes'}" for shape, slide in slides.items()),
            against_film(slides),
        ),
        extra={"stopped": {shape: stop_fields(run) for shape, run in runs.items()}},
        not_reached=max(run.accuracy_not_reached for run in runs.values()),
        subject=BentBristles(tools, runs, slides),
        answer=answer(slides),
    )


def answer(slides: Mapping[str, Slide | None]) -> str:
    """Return the study's answer in words: which tips slide, which retract at once, and whose slip
    ends first.
    """
    struck = {shape: slide for shape, slide in slides.items() if slide is not None}
    if not struck:
        return "No tip slides, because none strikes the workpart."
    least = RETRACTS * max(slide.forward for slide in struck.values())
    sliding = {shape: slide for shape, slide in struck.items() if slide.forward > least}
    parts = [
        f"the {NAMES[shape]} tip slides {1e3 * slide.forward:.2f} mm"
        for shape, slide in sliding.items()
    ]
    parts += [
        f"the {NAMES[shape]} tip retracts at once" for shape in struck if shape not in sliding
    ]
    parts += [f"the {NAMES[shape]} one never strikes" for shape in slides if shape not in struck]
    first, soonest = min(struck.items(), key=lambda each: each[1].ending_time)
    ending = ""
    if soonest.ending is not None:
        after = amount(soonest.ending_time, "s")
        ending = (
            f" The slip of the {NAMES[first]} tip {soonest.ending} first, {after} after the touch."
        )
    words = ", ".join(parts)
    return f"{words[0].upper()}{words[1:]}; in the high-speed film only the forward bent one retracts at once.{ending}"


def _rows(shape: str, contact: ContactRecord | None, slide: Slide | None) -> tuple[Quantity, ...]:
    labels = {
        f"{shape}_{name}": (f"{NAMES[shape]}: {label}", unit)
        for name, (label, unit) in MEASURES.items()
    }
    if contact is None or slide is None:
        return rows(labels, {})
    along = (contact.velocity_before[1], contact.velocity_after[1])
    values = (slide.forward, slide.total, slide.duration, *along, contact.velocity_after[0])
    return rows(labels, dict(zip(labels, values, strict=True)))


def against_film(slides: dict[str, Slide | None]) -> str:
    """Return a sentence that compares the slide of the forward bent tip with the other two slides,
    and with the film.
    """
    found = [slide.forward for slide in slides.values() if slide is not None]
    if len(found) < len(SHAPES):
        return "not every shape strikes: nothing to compare with the film"
    others = 0.5 * (found[0] + found[1])
    if others <= 0.0:
        return "neither the reverse bent nor the straight tip slides forward, unlike in the film"
    return f"forward bent slides {found[2] / others:.0%} as far as the mean of the other two; in the high-speed film not at all"
