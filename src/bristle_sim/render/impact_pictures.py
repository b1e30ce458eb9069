"""Figure and film of a single impact.

The figure shows the tip's velocity over the normal impulse: by the energetic law, and in a contact
simulated over time. The film shows the rods to scale, the tip enlarged, and curves over time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke

from bristle_sim.arrays import Array
from bristle_sim.readable import amount
from bristle_sim.render.drawing import (
    GROUND,
    HUB_COLOUR,
    add_arrows,
    points_per_unit,
    show_points,
)
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.story import Phase, phase_at
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LIGHT,
    SKY,
    VERMILION,
    Look,
    blank_figure,
    draw_zero,
    say,
    scale_for,
    signed,
    styled,
)
from bristle_sim.studies.contact_laws import Impacts, energetic_course, recorded_course
from bristle_sim.studies.timed_contact import compression_end
from bristle_sim.trajectory import ContactRecord
from bristle_sim.trajectory.interpolation import smooth_pieces

COLOURS = {"normal": BLUE, "tangential": VERMILION}
"""Colours of the components of a vector at the tip, in the order in which arrays hold them."""

PHASE_COLOURS = {
    "compression slip": "#e6eef6", "compression reverse slip": "#d3e2f0", "compression stick": "#dadde6",
    "restitution slip": "#eff5e8", "restitution reverse slip": "#e0ecd2", "restitution stick": "#e7e7df",
}  # fmt: skip
# Width of the narrowest phase whose name is shown, as a fraction of the panel
NARROWEST_NAMED = 0.09


@styled()
def impact_figure(impacts: Impacts) -> Figure:
    """Draw the tip's velocity components over the normal impulse during an impact.

    Lines show the energetic law, whose phases are shaded. Crosses show a contact simulated over
    time, if there is one.
    """
    surface = impacts.surface
    angles = ", ".join(f"{math.degrees(-angle):.4g}°" for angle in impacts.chain.angles)
    words = f"{angles} to the normal, μ = {surface.friction:.4g}, e* = {surface.restitution:.4g}"
    if surface.restitution_friction is not None:
        words += f", μ₂ = {surface.restitution_friction:.4g}"
    law = "energetic law"
    recorded = None
    resolved = impacts.strikes.get("compliant")
    if resolved is not None and resolved.contact.history is not None:
        recorded = recorded_course(resolved.contact.history)
        elastic = impacts.contact.tangential_compliance
        law = "lines: rigid along the surface" if elastic else "lines: energetic law"
        law += f"; crosses: resolved in time{', elastic' if elastic else ''}"
    course = energetic_course(impacts.chain, surface)
    courses = [course] if recorded is None else [course, recorded]
    end = max(float(each.impulse[-1]) for each in courses)
    impulse = scale_for(end, "N·s")
    speed = scale_for(
        float(np.abs([course.normal_velocity, course.tangential_velocity]).max()), "m/s"
    )
    figure = blank_figure(16.0, 7.4)
    axes = figure.subplots()
    axes.set_title(f"velocity of the tip against the normal impulse, {words}\n{law}")
    axes.set_xlabel(f"normal impulse ({impulse.unit})")
    axes.set_ylabel(f"velocity of the tip ({speed.unit})")
    if course.impulse.size < 2:
        say(axes, "the tip does not approach: no contact")
        return figure
    draw_zero(axes)
    edges = course.impulse * impulse.factor
    for name, color in COLOURS.items():
        which = f"{name}_velocity"
        axes.plot(edges, getattr(course, which) * speed.factor, color=color, gid=which, label=name)
        if recorded is not None:
            points = (recorded.impulse * impulse.factor, getattr(recorded, which) * speed.factor)
            gid = f"{which}, resolved in time"
            axes.plot(*points, "x", color=BLACK, markersize=3.6, zorder=3, gid=gid)
    axes.legend(loc="lower right")
    axes.set_xlim(0.0, 1.03 * end * impulse.factor)
    axes.margins(y=0.25)  # room for the names of the phases
    for name, (start, stop) in zip(course.phases, pairwise(edges), strict=False):
        axes.axvspan(start, stop, color=PHASE_COLOURS[name], linewidth=0.0, zorder=0)
        if stop - start >= NARROWEST_NAMED * axes.get_xlim()[1]:
            middle = 0.5 * (start + stop)
            words = name.replace(" ", "\n")
            look: Look = {"transform": axes.get_xaxis_transform(), "fontsize": 7.0}
            axes.text(middle, 0.97, words, ha="center", va="top", **look)
    return figure


MOTIONS = {"slip": "the tip slips", "reverse slip": "the tip slips back", "stick": "the tip sticks"}

# Free motion shown before and after the contact, as fractions of its duration
BEFORE = 0.10
AFTER = 0.18
# Length of the arrow of the largest force, as a fraction of the height of the enlarged drawing
LONGEST_FORCE = 0.28
# Smallest depth of the tip at separation that a text in the picture explains, as a fraction of the
# largest depth
CRATER = 0.02
ROD = "#bcd9ec"  # colour of the enlarged end of the rod
ROD_WIDTH = 16.0  # width of the enlarged end of the rod, not to scale, points of 1/72 inch


@dataclass(frozen=True, slots=True)
class ContactMotion:
    """Motion and forces during a contact, with free motion before and after it.

    Values between samples are interpolated linearly. At a jump two samples have the same time.

    Attributes:
        time: times of the samples from the first touch, s; negative before it.
        vectors: vectors of the tip at these times, by name, of shape (2, samples): components
            normal to the surface and along it. They are ``velocity`` (m/s), ``force`` (N) and
            ``path`` (m), the displacement since the first touch.
        phases: phases of the motion with their start times: first the arrival, then the phases of
            the impact, such as ``compression slip``, and last the outcome.
        touch_end: end of the contact, s.
    """

    time: Array
    vectors: dict[str, Array]
    phases: tuple[Phase, ...]
    touch_end: float

    def largest(self, name: str) -> float:
        """Return the largest magnitude over time of a vector, by its name."""
        return float(np.hypot(*self.vectors[name]).max())

    def at(self, time: float, name: str) -> Array:
        """Return the normal and tangential component of the vector ``name`` at a time, s."""
        return np.array([np.interp(time, self.time, part) for part in self.vectors[name]])


def contact_motion(record: ContactRecord) -> ContactMotion:
    """Return the motion and the forces during a recorded contact, over time.

    A tip that stays on the surface is at rest after the contact.

    Raises:
        ValueError: if the contact has no history, because its law is instantaneous or the tip did
            not approach.
    """
    history = record.history
    if history is None or history.time.size < 2:
        raise ValueError(
            f"contact with the {record.obstacle}: {record.outcome}; there is no motion in time to show"
        )
    clock = history.time - history.time[0]
    end = float(clock[-1])
    time = np.array([-BEFORE * end, 0.0, *clock, end, (1.0 + AFTER) * end])
    beside = ((0, 0), (2, 2))
    velocity = np.pad([history.normal_velocity, history.tangential_velocity], beside, "edge")
    force = np.pad([history.normal_force, history.tangential_force], beside)
    if record.outcome != "rebound":
        velocity[:, -2:] = 0.0
        force[:, -2:] = force[:, -3:-2]
    ways = 0.5 * np.diff(time) * (velocity[:, 1:] + velocity[:, :-1])
    path = np.pad(np.cumsum(ways, axis=1), ((0, 0), (1, 0)))
    vectors = {"velocity": velocity, "force": force, "path": path - path[:, 1:2]}
    # There may be more smooth pieces than phases. The shortest ones are then rounding error.
    longest = sorted(smooth_pieces(clock), key=lambda piece: clock[piece[0]] - clock[piece[1]])
    begins = sorted(float(clock[first]) for first, _ in longest[: len(record.phases)])
    phases = [Phase(*each) for each in zip(begins, record.phases, strict=False)]
    stays = record.outcome in ("stiction", "jam")
    outcome = Phase(end, record.outcome + ": the tip stays" * stays)
    return ContactMotion(time, vectors, (Phase(time[0], "the tip arrives"), *phases, outcome), end)


class TipDrawing:
    """Enlarged drawing of the tip with its path and the forces on it.

    Surface and path are to scale; the rod's end and the force arrows are not. ``moving`` holds the
    artists that move.
    """

    def __init__(self, axes: Axes, motion: ContactMotion, last_rod: Array) -> None:
        self._motion = motion
        path = motion.vectors["path"]
        scale = scale_for(float(np.ptp(path, axis=1).max()), "m")
        self._factor = scale.factor
        self._path = scale.factor * path[::-1].T
        show_points(axes, [self._path], 0.5)
        bottom, top = axes.get_ylim()
        height = top - bottom
        axes.grid(visible=False)
        axes.axhspan(2.0 * bottom, 0.0, facecolor=LIGHT, edgecolor=GREY, zorder=0)
        axes.set_xlabel(f"the tip's displacement along the surface ({scale.unit})")
        axes.set_ylabel(f"away from it ({scale.unit})")
        (self.trail,) = axes.plot([], [], color=SKY, linewidth=2.0)
        # The end of the rod is round and touches the tip's place from above.
        end = np.array([0.0, 0.5 * ROD_WIDTH / points_per_unit(axes)])
        self._rod = np.array([end, end - 2.0 * height / math.hypot(*last_rod) * last_rod])
        outline = [withStroke(linewidth=ROD_WIDTH + 2.0, foreground=BLUE)]
        (self.rod,) = axes.plot(
            [], [], color=ROD, linewidth=ROD_WIDTH, path_effects=outline, zorder=3
        )
        self.forces = add_arrows(axes, *COLOURS.values())
        self.moving = [self.trail, self.rod, self.forces]
        self._newton = LONGEST_FORCE * height / (motion.largest("force") or 1.0)
        left = -float(motion.at(motion.touch_end, "path")[0])
        if left > -CRATER * path[0].min():
            why = f"The contact unloads more\nstiffly than it loads:\nthe tip leaves a crater\nof {amount(left, 'm')} depth."
            axes.text(0.03, 0.03, why, transform=axes.transAxes, fontsize=7.0)

    def move(self, time: float) -> None:
        """Move the drawing to a time from the first touch, s.

        The path up to this time is drawn.
        """
        motion = self._motion
        tip = self._factor * motion.at(time, "path")[::-1]
        past = self._path[: np.searchsorted(motion.time, time, side="right")]
        self.trail.set_data(*np.vstack([past, tip]).T)
        self.rod.set_data(*(tip + self._rod).T)
        up, aside = self._newton * motion.at(time, "force")
        # The normal arrow ends at the tip, since the rod is above the tip.
        self.forces.set_offsets([tip - [0.0, up], tip])
        self.forces.set_UVC([0.0, aside], [up, 0.0])


class ImpactFilm(Film):
    """Film of an impact with a contact of finite duration, by the compliant contact law.

    The function :func:`bristle_sim.studies.timed_contact.with_visible_contact` computes impacts
    that can be filmed.

    Raises:
        ValueError: if the impact is instantaneous.
    """

    size = (960, 540)
    letter_size = 15.0

    @styled()
    def __init__(
        self, impacts: Impacts, *, width: int = 960, height: int = 540, duration: float = 10.0
    ) -> None:
        if "compliant" not in impacts.strikes:
            raise ValueError(
                "contact: instantaneous with these values, so there is no motion to film"
            )
        struck = impacts.strikes["compliant"]
        self.motion = motion = contact_motion(struck.contact)
        clock = scale_for(motion.touch_end, "s")
        warp = slow_motion(float(motion.time[0]), float(motion.time[-1]), duration)
        super().__init__(warp, width, height, tuple(COLOURS.values()), clock)
        self.speed = scale_for(motion.largest("velocity"), "m/s")
        line = struck.centre_line[0]
        top = 1.0 - HEADER
        rods = self.figure.add_axes((0.01, 0.02, 0.2, top - 0.03))
        draw_rods(rods, line, impacts.chain.hub_radius)
        close_up = self.figure.add_axes((0.285, 0.1, 0.31, top - 0.11))
        self.tip = TipDrawing(close_up, motion, line[-1] - line[-2])
        self._draw_panel(0.5, "velocity", "of the tip", "m/s").legend(loc="upper right")
        axes = self._draw_panel(0.1, "force", "on the tip", "N")
        axes.set_xlabel(f"time since the first touch ({clock.unit})")
        self.moving = [*self.tip.moving, *self.hands]
        history = struck.contact.history
        assert history is not None
        compressed, touched = (
            f"{each * clock.factor:.4g} {clock.unit}"
            for each in (compression_end(history), motion.touch_end)
        )
        surface = impacts.surface
        words = f"compression {compressed} ({impacts.timing})\ncontact {touched}, μ = {surface.friction:.4g}, e* = {surface.restitution:.4g}"
        self.figure.text(0.98, 0.985, words, ha="right", va="top", color=GREY)

    def move(self, time: float) -> tuple[str, ...]:
        """Move the tip to a time from the first touch, s."""
        self.tip.move(time)
        velocity = self.speed.factor * self.motion.at(time, "velocity")
        texts = (
            f"{word} {signed(value, 2, 7)} {self.speed.unit}"
            for word, value in zip(("away", "along"), velocity.tolist(), strict=True)
        )
        half, _, sliding = (phase := phase_at(self.motion.phases, time).caption).partition(" ")
        return f"{half}: {MOTIONS[sliding]}" if sliding in MOTIONS else phase, *texts

    def _draw_panel(self, bottom: float, name: str, where: str, unit: str) -> Axes:
        """Add a panel with the normal and tangential components of a vector over time.

        Args:
            bottom: lower edge of the panel, as a fraction of the picture.
            name: name of the vector, ``velocity`` or ``force``.
            where: second part of the panel's label, such as ``of the tip``.
            unit: SI unit of the vector.
        """
        motion = self.motion
        scale = scale_for(motion.largest(name), unit)
        clock = self.clock.factor
        axes = self.add_timeline((0.685, bottom, 0.305, 0.33))
        draw_zero(axes)
        for values, (part, color) in zip(motion.vectors[name], COLOURS.items(), strict=True):
            shown = values * scale.factor
            axes.plot(motion.time * clock, shown, color=color, linewidth=1.8, label=part)
        ends = [*(phase.start for phase in motion.phases[1:]), motion.time[-1]]
        for phase, end in zip(motion.phases, ends, strict=True):
            color = PHASE_COLOURS.get(phase.caption, "white")
            axes.axvspan(phase.start * clock, end * clock, color=color, linewidth=0.0, zorder=0)
        axes.margins(y=0.1)
        axes.set_ylabel(f"{name} {where} ({scale.unit})")
        return axes


def draw_rods(axes: Axes, centre_line: Array, hub_radius: float) -> None:
    """Draw the rods at the strike; dots mark the root and the hinges.

    Args:
        axes: axes of the drawing.
        centre_line: root, hinges and tip relative to the hub's centre, shape (corners, 2), m.
        hub_radius: radius of the hub, m. It is zero if the root is fixed.
    """
    show_points(axes, [centre_line], 0.35)
    axes.set_axis_off()
    axes.axhspan(axes.get_ylim()[0], centre_line[-1, 1], **GROUND)
    axes.add_patch(Circle((0.0, 0.0), hub_radius, facecolor=HUB_COLOUR, edgecolor=GREY))
    root = "hub  \n" if hub_radius else "fixed  \n"
    x, y = centre_line[0]
    axes.text(x, y, root, ha="right", va="bottom", color=GREY)
    axes.plot(*centre_line.T, color=BLUE, linewidth=4.0)
    axes.plot(*centre_line[:-1].T, "o", color=GREEN, markeredgecolor="white", zorder=4)
