"""Three bristles in one tool: knee bent backwards, straight, knee bent forwards. Who slides, who retracts at once?

High-speed film of the three (Zhang 2020, figs. 1.3 and 1.4, 2600 rpm) shows the forward bent tip retract as soon as it
strikes, while the reverse bent and the straight one slide first. Here each passes bar and workpart in the same tool, its
strike resolved in time. The further ahead a knee puts the tip, the sooner the strike's friction turns its slip around: a
knee bent far enough forward turns it while the contact still compresses, the other two only on the way out, and the
forward knee leaves backwards fastest. In distance slid the three rigid bristles differ little; the film's difference in
kind is larger than rigid bristles on one impact explain.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from bristle_sim.comparison import Quantity, Report
from bristle_sim.parameters import Tool
from bristle_sim.scene.tool import refuse_endless, simulate
from bristle_sim.settings import Settings
from bristle_sim.studies.whole_pass import require_result, stopped
from bristle_sim.trajectory import ContactRecord, Trajectory

__all__ = ["BentBristles", "Slide", "bent_bristles", "slide_of"]

SHAPES = {"reverse": -1.0, "straight": 0.0, "forward": 1.0}


@dataclass(frozen=True, slots=True)
class Slide:
    """What a tip does on the workpart in its first strike.

    Attributes:
        forward: distance it slides forward before it turns, m.
        total: displacement along the workpart while in touch, m; negative: retracted.
        duration: time in touch, s.
        turns_in_compression: whether slip reverses before compression ends.
    """

    forward: float
    total: float
    duration: float
    turns_in_compression: bool

    @property
    def verdict(self) -> str:
        """Where in the contact the slip turns."""
        return "slip turns in compression" if self.turns_in_compression else "slip turns in restitution"


@dataclass(frozen=True, slots=True)
class BentBristles:
    """The passes by shape, for pictures."""

    tools: dict[str, Tool]
    trajectories: dict[str, Trajectory]
    slides: dict[str, Slide | None]


def slide_of(contact: ContactRecord) -> Slide:
    """Sliding of a strike resolved in time, by the trapezoidal rule over its tangential velocity.

    Raises:
        ValueError: for a contact without a history.
    """
    history = contact.history
    if history is None:
        raise ValueError(f"contact = {contact.law}: compliant is allowed; another law has no path of the tip")
    velocity, time = history.tangential_velocity, history.time
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)
    path = np.concatenate(([0.0], np.cumsum(steps)))
    return Slide(
        forward=float(path.max()),
        total=float(path[-1]),
        duration=contact.duration,
        turns_in_compression="compression reverse slip" in contact.phases,
    )


def bent_bristles(tool: Tool, settings: Settings) -> Report:
    """Simulate a pass with the tool's knee bent backwards, straightened, and bent forwards.

    Raises:
        ValueError: if the tool's contact is not resolved in time, or a pass does not end within the settings' steps.
    """
    if tool.contact.law != "compliant":
        raise ValueError(f"contact = {tool.contact.law}: must be compliant; another law has no path of the tip")
    refuse_endless(tool, settings)
    knee = abs(tool.bristle.knee_angle_deg)
    tools, runs, slides = {}, {}, {}
    rows: list[Quantity] = []
    for shape, sign in SHAPES.items():
        bristle = dataclasses.replace(tool.bristle, knee_angle_deg=sign * knee)
        tools[shape] = dataclasses.replace(tool, bristle=bristle)
        runs[shape] = simulate(tools[shape], settings)
        contact = runs[shape].first_contact("workpart")
        if contact is None:
            require_result(runs[shape], settings)
        slides[shape] = None if contact is None else slide_of(contact)
        rows += _rows(shape, contact, slides[shape])
    strikes = [(f"{shape} strike", time) for shape, run in runs.items() for time in _strike(run)]
    struck = all(slide is not None for slide in slides.values())
    return Report(
        outcome="rebound" if struck else "no contact",
        quantities=tuple(rows),
        events=tuple(sorted(strikes, key=lambda event: event[1])),
        wall_s=sum(run.cost.wall_s for run in runs.values()),
        steps=sum(run.cost.steps for run in runs.values()),
        remarks=(
            "film (Zhang 2020, fig. 1.4): reverse slides first, straight slides first, forward retracts at once",
            "simulated: " + "; ".join(f"{shape}: {_verdict(slide)}" for shape, slide in slides.items()),
            *_given_up(runs),
            "the order agrees with the film, the size does not: rigid bristles all slide about as far before they turn",
        ),
        extra={"stopped": {shape: stopped(run) for shape, run in runs.items()}},
        subject=BentBristles(tools, runs, slides),
    )


def _rows(shape: str, contact: ContactRecord | None, slide: Slide | None) -> list[Quantity]:
    if contact is None or slide is None:
        return [Quantity(f"{shape}_forward_slide", "m", None)]
    return [
        Quantity(f"{shape}_forward_slide", "m", slide.forward),
        Quantity(f"{shape}_slide_in_touch", "m", slide.total),
        Quantity(f"{shape}_time_in_touch", "s", slide.duration),
        Quantity(f"{shape}_tip_speed_along_before", "m/s", contact.velocity_before[1]),
        Quantity(f"{shape}_tip_speed_along_after", "m/s", contact.velocity_after[1]),
        Quantity(f"{shape}_tip_speed_away_after", "m/s", contact.velocity_after[0]),
    ]


def _given_up(runs: dict[str, Trajectory]) -> list[str]:
    """Say which runs ended early, after their strikes, and why."""
    early = ((shape, run) for shape, run in runs.items() if run.stop_reason.gives_up)
    return [
        f"{shape}: given up at {1e3 * run.time[-1]:.4f} ms: {run.stop_reason}; {run.stop_advice}"
        for shape, run in early
    ]


def _strike(run: Trajectory) -> list[float]:
    time = run.event_time("strike")
    return [] if time is None else [time]


def _verdict(slide: Slide | None) -> str:
    return "never strikes" if slide is None else f"{slide.verdict}, {1e3 * slide.forward:.2f} mm forward"
