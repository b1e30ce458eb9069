"""Film of one impact in slow motion: the rods to scale, the tip enlarged, and curves over time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke

from bristle_sim.arrays import Array
from bristle_sim.readable import amount
from bristle_sim.render.colours import BLUE, GREEN, GREY, LIGHT, SKY, VERMILION
from bristle_sim.render.drawing import (
    GROUND,
    HUB_COLOUR,
    add_arrows,
    points_per_unit,
    show_points,
)
from bristle_sim.render.film import HEADER, Film, slow_motion
from bristle_sim.render.impact_figure import PHASE_COLOURS
from bristle_sim.render.story import Phase, phase_at
from bristle_sim.render.style import draw_zero, scale_for, signed, styled
from bristle_sim.studies.contact_laws import Impacts
from bristle_sim.studies.timed_contact import compression_end, pieces
from bristle_sim.trajectory import ContactRecord

COLOURS = {"normal": BLUE, "tangential": VERMILION}
MOTIONS = {"slip": "the tip slips", "reverse slip": "the tip slips back", "stick": "the tip sticks"}

# Free motion shown before and after the contact, as fractions of its duration
BEFORE = 0.10
AFTER = 0.18
# Length of the arrow of the largest force, as a fraction of the height of the enlarged drawing
LONGEST_FORCE = 0.28
# Depth of the tip at separation, as a fraction of the largest depth, from which on a text in the
# picture explains it
CRATER = 0.02
ROD = "#bcd9ec"  # colour of the enlarged end of the rod
ROD_WIDTH = 16.0  # width of the enlarged end of the rod, not to scale, points of 1/72 inch


@dataclass(frozen=True, slots=True)
class ContactMotion:
    """Motion and forces during a contact, with free motion before and after it.

    Values between two samples are interpolated linearly. Where a force jumps, two samples have the
    same time.

    Attributes:
        time: times of the samples from the first touch, s; negative before it.
        samples: quantities of the tip at these times, by name. ``normal_velocity`` and
            ``tangential_velocity`` are in m/s, ``normal_force`` and ``tangential_force`` in N. The
            displacement since the first touch, ``along`` the surface and ``away`` from it, is in m.
        phases: phases of the motion with their start times. The first is the arrival; then follow
            phases of the impact such as ``compression slip``; the last is the outcome.
        touch_end: end of the contact, s.
    """

    time: Array
    samples: dict[str, Array]
    phases: tuple[Phase, ...]
    touch_end: float

    def largest(self, kind: str) -> float:
        """Return the largest magnitude over time of a vector.

        ``kind`` is ``velocity`` (m/s) or ``force`` (N).
        """
        return float(np.hypot(*(self.samples[f"{part}_{kind}"] for part in COLOURS)).max())

    def at(self, time: float, *names: str) -> Array:
        """Return quantities at a time (s), one for each name in ``names``, a key of ``samples``."""
        return np.array([np.interp(time, self.time, self.samples[name]) for name in names])


def contact_motion(record: ContactRecord) -> ContactMotion:
    """Return motion and forces over time of a recorded contact.

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
    leaves = record.outcome == "rebound"
    time = np.array([-BEFORE * end, 0.0, *clock, end, (1.0 + AFTER) * end])
    kept = {"velocity": (1.0, leaves), "force": (0.0, not leaves)}
    samples = {}
    for part, path in (("tangential", "along"), ("normal", "away")):
        for kind, (before, after) in kept.items():
            values = np.pad(getattr(history, f"{part}_{kind}"), 2, "edge")
            values[:2] *= before
            values[-2:] *= after
            samples[f"{part}_{kind}"] = values
        speed = samples[f"{part}_velocity"]
        way = np.append(0.0, np.cumsum(0.5 * np.diff(time) * (speed[1:] + speed[:-1])))
        samples[path] = way - way[1]
    # The shortest pieces, beyond the number of phases, are rounding at the end of other pieces.
    longest = sorted(pieces(clock), key=lambda piece: clock[piece[0]] - clock[piece[1] - 1])
    begins = sorted(float(clock[first]) for first, _ in longest[: len(record.phases)])
    phases = [Phase(*each) for each in zip(begins, record.phases, strict=False)]
    stays = record.outcome in ("stiction", "jam")
    outcome = Phase(end, record.outcome + ": the tip stays" * stays)
    return ContactMotion(time, samples, (Phase(time[0], "the tip arrives"), *phases, outcome), end)


class TipDrawing:
    """Enlarged drawing of the tip with its path and the forces on it.

    Surface and path are to scale; the rod's end and the force arrows are not. ``moving`` holds the
    artists that move.
    """

    def __init__(self, axes: Axes, motion: ContactMotion, last_rod: Array) -> None:
        self._motion = motion
        path = np.stack([motion.samples["along"], motion.samples["away"]], axis=-1)
        scale = scale_for(float(np.ptp(path, axis=0).max()), "m")
        self._factor = scale.factor
        self._path = path * scale.factor
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
        left = -float(motion.at(motion.touch_end, "away")[0])
        if left > -CRATER * path[:, 1].min():
            why = f"The contact unloads more\nstiffly than it loads:\nthe tip leaves a crater\nof {amount(left, 'm')} depth."
            axes.text(0.03, 0.03, why, transform=axes.transAxes, fontsize=7.0)

    def move(self, time: float) -> None:
        """Move the drawing to a time from the first touch, s.

        The path up to this time is drawn.
        """
        motion = self._motion
        tip = self._factor * motion.at(time, "along", "away")
        past = self._path[: np.searchsorted(motion.time, time, side="right")]
        self.trail.set_data(*np.vstack([past, tip]).T)
        self.rod.set_data(*(tip + self._rod).T)
        up, aside = self._newton * motion.at(time, "normal_force", "tangential_force")
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
                "contact: instantaneous with these values, so that there is no motion to film"
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
        self._draw_panel(0.5, "velocity of the tip", "m/s").legend(loc="upper right")
        axes = self._draw_panel(0.1, "force on the tip", "N")
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
        velocity = self.speed.factor * self.motion.at(
            time, "normal_velocity", "tangential_velocity"
        )
        texts = (
            f"{word} {signed(value, 2, 7)} {self.speed.unit}"
            for word, value in zip(("away", "along"), velocity.tolist(), strict=True)
        )
        half, _, sliding = (phase := phase_at(self.motion.phases, time).caption).partition(" ")
        return f"{half}: {MOTIONS[sliding]}" if sliding in MOTIONS else phase, *texts

    def _draw_panel(self, bottom: float, title: str, unit: str) -> Axes:
        """Add a panel with the normal and tangential components of a vector over time.

        Args:
            bottom: lower edge of the panel, as a fraction of the picture.
            title: title of the panel; its first word is ``velocity`` or ``force``.
            unit: SI unit of the vector.
        """
        motion = self.motion
        kind = title.partition(" ")[0]
        scale = scale_for(motion.largest(kind), unit)
        clock = self.clock.factor
        axes = self.add_timeline((0.685, bottom, 0.305, 0.33))
        draw_zero(axes)
        for part, color in COLOURS.items():
            values = motion.samples[f"{part}_{kind}"] * scale.factor
            axes.plot(motion.time * clock, values, color=color, linewidth=1.8, label=part)
        ends = [*(phase.start for phase in motion.phases[1:]), motion.time[-1]]
        for phase, end in zip(motion.phases, ends, strict=True):
            color = PHASE_COLOURS.get(phase.caption, "white")
            axes.axvspan(phase.start * clock, end * clock, color=color, linewidth=0.0, zorder=0)
        axes.margins(y=0.1)
        axes.set_ylabel(f"{title} ({scale.unit})")
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
