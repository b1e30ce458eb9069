"""Panels of families: closed forms as lines, simulated impacts as points on them, the case at hand as a star."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from bristle_sim.render.style import BLACK, BLUE, GREY, ORANGE, SERIES, VERMILION
from bristle_sim.studies.curves import Curve
from bristle_sim.studies.law_convergence import EngineEnergy

__all__ = ["draw_energy", "draw_family", "explain_marks", "note", "panel_title", "plain_decades", "say", "star"]

Scaled = Callable[[Any], Any]

CREATED = "#fbe3d6"
MANY = 6
"""Curves whose names need closer spacing to fit in the row above a panel."""

_MARKS: dict[str, dict[str, Any]] = {
    "closed form": {"color": BLACK},
    "energetic": {"marker": "o", "markersize": 3.6, "markerfacecolor": "white"},
    "compliant": {"marker": "x", "markersize": 3.8},
    "at hand": {"marker": "*", "markersize": 9.0, "markerfacecolor": ORANGE, "markeredgewidth": 0.6, "color": BLACK},
}
_MEANINGS = {
    "closed form": "closed form",
    "energetic": "scene, energetic law",
    "compliant": "scene, contact resolved in time",
    "at hand": "the impact at hand",
}


def panel_title(axes: Axes, letter: str, words: str, subtitle: str = "") -> None:
    """A title at the panel's left edge, led by its letter, above a row for a subtitle or a family's names."""
    axes.set_title(f"$\\bf{{{letter}}}$  {words}", loc="left", fontsize=8.5, pad=17.0)
    axes.annotate(subtitle, (0.0, 1.0), (0.0, 4.5), "axes fraction", "offset points", fontsize=7.0, color=GREY)


def draw_family(
    axes: Axes, curves: Sequence[Curve], parameter: str, *, across: Scaled = lambda x: x, up: Scaled = lambda y: y
) -> None:
    """Draw curves with their points, named in a row above the panel that begins with the ``parameter``.

    ``across`` and ``up`` turn SI values into shown ones.
    """
    lines = [Line2D([], [], linestyle="none")]
    for curve, color in zip(curves, SERIES, strict=False):
        lines += axes.plot(across(curve.x), up(curve.theory), color=color, gid=f"theory {curve.name}")
        for law, (x, y) in curve.points.items():
            axes.plot(across(x), up(y), **_mark(law, color), gid=f"{law} {curve.name}", zorder=3)
    _keep_apart(axes)
    axes.legend(
        lines,
        [parameter, *(curve.name for curve in curves)],
        loc="lower left",
        bbox_to_anchor=(-0.08, 0.985),
        ncols=len(lines),
        handlelength=1.0 if len(curves) < MANY else 0.7,
        handletextpad=0.4,
        columnspacing=0.9 if len(curves) < MANY else 0.5,
    )


def _keep_apart(axes: Axes) -> None:
    """Show values that differ by rounding alone as equal."""
    bottom, top = axes.dataLim.intervaly
    size = max(abs(bottom), abs(top))
    if top - bottom < max(1e-3 * size, 1e-12):
        margin = max(0.1 * size, 1e-3)
        axes.set_ylim(bottom - margin, top + margin)


def star(axes: Axes, x: float, y: float) -> None:
    """The case at hand."""
    axes.plot([x], [y], **_mark("at hand", BLACK), zorder=4, gid="at hand")


def explain_marks(figure: Figure, *marks: str) -> None:
    """A row at the foot of a figure that says what lines and points are."""
    handles = [Line2D([], [], **(_mark(each, BLACK) if each != "closed form" else _MARKS[each])) for each in marks]
    names = [_MEANINGS[each] for each in marks]
    figure.legend(handles, names, loc="lower center", ncols=len(marks), columnspacing=1.6, borderaxespad=0.2)


def draw_energy(axes: Axes, energy: EngineEnergy) -> None:
    """Kinetic energy after over before, over the iterations of the engine's solver; beyond 1 energy is created."""
    top = 1.15 * max(1.3, float(energy.engine.max()))
    axes.axhspan(1.0, top, color=CREATED, linewidth=0.0, zorder=0)
    axes.axhline(energy.energetic, color=BLUE, gid="energetic")
    axes.semilogx(energy.iterations, energy.engine, "o-", color=VERMILION, markersize=3.2, gid="engine")
    axes.axvline(10.0, color=GREY, linewidth=0.7, dashes=(2, 2), zorder=1)
    axes.set_ylim(0.0, top)
    right = float(energy.iterations[-1])
    note(axes, "energy created", (right, 1.0), (0.0, 3.0), ha="right", va="bottom", color=BLACK)
    note(axes, "energetic law", (right, energy.energetic), (0.0, -3.0), ha="right", va="top", color=BLUE)
    note(axes, "engine's own contact", (10.0, 0.9 * top), (4.0, 0.0), va="center", color=VERMILION)
    note(axes, "engine's default", (10.0, 0.03 * top), (4.0, 0.0))
    plain_decades(axes)
    axes.set_xlabel("iterations of the engine's solver")
    axes.set_ylabel("kinetic energy, after / before")


def plain_decades(axes: Axes) -> None:
    """Write 1, 10, 100 instead of powers of ten along a logarithmic x axis."""
    axes.xaxis.set_major_formatter(
        FuncFormatter(lambda value, _: f"{value:g}" if 1e-3 < value < 1e5 else f"{value:.0e}")
    )


def note(axes: Axes, words: str, place: tuple[float, float], offset: tuple[float, float], **look: Any) -> None:
    """Small words beside a place, ``offset`` in points."""
    axes.annotate(words, place, offset, **{"textcoords": "offset points", "fontsize": 7.0, "color": GREY, **look})


def say(axes: Axes, words: str) -> None:
    """Write words in the middle of a panel that has nothing to show, without scales."""
    axes.set(xticks=[], yticks=[])
    axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center", color=GREY)


def _mark(kind: str, color: str) -> dict[str, Any]:
    return {"linestyle": "none", "markeredgewidth": 0.8, "color": color} | _MARKS[kind]
