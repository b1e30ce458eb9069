"""Make the pictures and the table that no scenario writes: ``python media/make.py media/strike.svg``."""

from __future__ import annotations

import math
import sys
import textwrap
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch
from PIL import Image

from bristle_sim.dissertation.audit import AuditRow, audit_rows, shown_number
from bristle_sim.dissertation.figures import NUMBERS, redrawn
from bristle_sim.dissertation.redrawn import Redrawn
from bristle_sim.parameters import Tool
from bristle_sim.readable import MILLIMETRES
from bristle_sim.render.dissertation_figures import (
    draw_panel,
    heading,
    write_points_key,
)
from bristle_sim.render.drawing import HUB_COLOUR, toward
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LIGHT,
    VERMILION,
    blank_figure,
    save_figure,
    styled,
)

HERE = Path(__file__).parent

HUB_ANGLE, LAG = math.radians(-20.0), math.radians(12.0)
"""Hub angle of the root and lag of the wire in the drawing, rad; the lag is four times that of the operating point, so that it can
be seen."""


@styled()
def strike_drawing() -> Figure:
    """Draw hub, wire and workpart at the instant of a strike, with the names and positive directions of all quantities."""
    tool = Tool()
    radius, length = tool.hub.radius * MILLIMETRES, tool.bristle.length * MILLIMETRES
    reach, root = radius + length, radius * toward(HUB_ANGLE)
    tip = root + length * toward(HUB_ANGLE - LAG)
    x, y = tip.tolist()
    figure = blank_figure(16.0, 9.5)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set(xlim=(-72.0, 40.0), ylim=(y - 12.0, y - 12.0 + 112.0 * 9.5 / 16.0))
    axes.axhspan(y - 20.0, y, facecolor=LIGHT, edgecolor=GREY, linewidth=0.8)
    axes.add_patch(Circle((0.0, 0.0), radius, facecolor=HUB_COLOUR, edgecolor=GREY))
    for end in (np.array([0.0, y]), root + 1.02 * length * toward(HUB_ANGLE)):
        axes.plot([0.0, end[0]], [0.0, end[1]], color=GREY, linewidth=0.8, dashes=(5, 3))
    axes.plot(*np.transpose([root, tip]), color=BLUE, linewidth=3.0, solid_capstyle="butt")
    axes.plot(*root, "o", color=GREEN, markersize=5)
    hub, wire = math.degrees(HUB_ANGLE) - 90.0, math.degrees(HUB_ANGLE - LAG) - 90.0
    for centre, size, first, last, look in (
        ((0.0, 0.0), 1.1 * radius, hub, -90.0, {"color": BLACK}),
        (root, 32.0, wire, hub, {"color": BLACK}),
        ((0.0, 0.0), 2.0 * reach, -118.0, -58.0, {"color": GREY, "linestyle": ":"}),
    ):
        arc: dict[str, Any] = {"theta1": first, "theta2": last, **look}
        axes.add_patch(Arc((centre[0], centre[1]), size, size, **arc))
    ends, style = (
        0.74 * radius * toward(np.radians([50.0, 95.0])),
        "-|>,head_length=5,head_width=2.5",
    )
    axes.add_patch(
        FancyArrowPatch(*ends, arrowstyle=style, connectionstyle="arc3,rad=0.25", color=BLACK)
    )
    for start, step, color, style in (
        ((-66.0, -18.0), (9.0, 0.0), BLACK, "-|>"),  # x and y
        ((-66.0, -18.0), (0.0, 9.0), BLACK, "-|>"),
        ((x - 15.0, y + 8.0), (14.4, -7.6), BLUE, "-|>"),  # velocities of the tip
        ((x + 0.6, y + 0.4), (9.0, 5.0), BLUE, "-|>"),
        ((x, y), (0.0, 12.0), VERMILION, "-|>"),  # impulses on the tip
        ((x, y), (-8.0, 0.0), VERMILION, "-|>"),
        ((3.0, y), (0.0, -math.sqrt(reach**2 - 9.0) - y), BLACK, "<|-|>"),  # penetration
    ):
        arrow = {"arrowstyle": style, "color": color, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (start[0] + step[0], start[1] + step[1]), start, arrowprops=arrow)
    for left, up, words, color, side in (
        (1.2, -0.62 * radius, "hub angle, negative\nbefore the root is lowest", BLACK, "left"),
        (root[0] - 6.5, root[1] - 6.0, "retraction: positive\nwhere the wire lags", BLACK, "right"),
        (root[0] - 2.0, root[1] + 1.5, "root, in the belt", GREEN, "right"),
        (0.8, root[1] - 7.0, "angle 0: from the hub's\ncentre to the workpart", GREY, "left"),
        (1.5, -0.12 * radius, "hub speed, rates:\npositive this way", BLACK, "left"),
        (-56.5, -18.0, "x, tangential: as the tip travels", BLACK, "left"),
        (-67.0, -7.2, "y, normal: out of the workpart", BLACK, "left"),
        (x - 15.5, y + 7.0, "velocity of the tip before:\nnormal part < 0", BLUE, "right"),
        (x + 10.0, y + 5.0, "after: normal part > 0", BLUE, "left"),
        (x - 0.8, y + 11.8, "normal impulse > 0", VERMILION, "right"),
        (
            x - 1.0,
            y - 4.0,
            "tangential impulse on the tip:\n< 0 where friction opposes x",
            VERMILION,
            "right",
        ),
        (3.0, -reach - 2.0, "penetration below the hub", BLACK, "left"),
        (25.0, -reach + 12.5, "circle of\nstraight tips", GREY, "left"),
    ):
        axes.text(left, up, words, color=color, fontsize=7.5, ha=side, va="center")
    return figure


CHAPTERS = {2: "The tool, cueing and impact", 3: "Force history", 4: "Crater"}


def audit_page(rows: Sequence[AuditRow]) -> str:
    """Return all rows: first those that differ, each with its reason, then everything by chapter."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE), keep_trailing_newline=True
    )
    environment.filters["number"] = shown_number
    environment.filters["plain"] = lambda text: text.replace("|", "\\|").replace("*", "\\*")
    by_chapter = {number: [row for row in rows if chapter_of(row) == number] for number in CHAPTERS}
    count = Counter(row.status for row in rows)
    page = environment.get_template("audit.md.jinja")
    return page.render(rows=rows, count=count, chapters=CHAPTERS, by_chapter=by_chapter)


def chapter_of(row: AuditRow) -> int:
    """Return the chapter that a place is in, by the first number in it; those of chapters 1 and 5 belong to chapter 2."""
    digits = next(word for word in row.where.split() if word[0].isdigit())
    return int(digits[0]) if digits[0] in "234" else 2


@styled()
def contact_sheet(figures: Sequence[Redrawn]) -> Figure:
    """Draw all figures side by side on one sheet, with one panel in each cell of 8.25 cm by 7.1 cm."""
    cells = [(figure, panel) for figure in figures for panel in figure.panels or (None,)]
    rows = -(-len(cells) // 4)
    sheet = blank_figure(33.0, 1.0 + 7.1 * rows)
    places = sheet.subplots(rows, 4).ravel()
    for axes in places[len(cells) :]:
        axes.remove()
    for axes, (figure, panel) in zip(places, cells, strict=False):
        draw_panel(axes, panel, figure.table)
        axes.set_title("\n".join(textwrap.wrap(heading(figure), 50)), fontsize=8.0)
    write_points_key(sheet, [panel for figure in figures for panel in figure.panels])
    return sheet


def write_sheet(target: Path) -> None:
    """Draw all figures of the dissertation on one sheet, 1300 pixels wide; 256 colours look the same and take a fifth of the bytes."""
    sheet = contact_sheet([redrawn(number) for number in NUMBERS])
    sheet.set_dpi(100.0)
    canvas: Any = FigureCanvasAgg(sheet)
    with styled():
        canvas.draw()
    picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    colours = picture.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    colours.save(target, format="png", optimize=True)


MAKERS: dict[str, Callable[[Path], object]] = {
    "strike.svg": lambda target: save_figure(strike_drawing(), target),
    "audit.md": lambda target: target.write_text(audit_page(audit_rows()), encoding="utf-8"),
    "contact_sheet.png": write_sheet,
}

if __name__ == "__main__":
    for target in map(Path, sys.argv[1:]):
        MAKERS[target.name](target)
