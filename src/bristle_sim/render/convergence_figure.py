"""How a contact resolved in time converges to the energetic law, over the engine steps that it takes."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.render.style import BLACK, GREY, SERIES, axes_at, blank_figure, styled
from bristle_sim.render.sweep_panels import note, plain_decades
from bristle_sim.studies.law_convergence import ACCURACIES, Convergence

__all__ = ["compliant_convergence_figure"]


@styled()
def compliant_convergence_figure(cases: Sequence[Convergence]) -> Figure:
    """Draw the error over engine steps per contact of Stronge's double pendulum, for several ratios of masses.

    Plain steps converge with order one; extrapolated steps reach the accuracy that is requested.
    """
    figure = blank_figure(16.0, 9.0)
    axes = axes_at(figure, 1.7, 1.2, 9.6, 7.0)
    for case, color in zip(cases, SERIES, strict=False):
        _draw_case(axes, case, color)
    _draw_order_one(axes, cases)
    plain_decades(axes)
    axes.set_xlabel("engine steps in the contact")
    axes.set_ylabel("error of the rates after impact, relative")
    axes.set_title(
        "A contact resolved in time converges to the energetic law, whatever the masses", loc="left", pad=8.0
    )
    _explain(axes, cases)
    return figure


def _draw_case(axes: Axes, case: Convergence, color: str) -> None:
    name = f"{case.mass_ratio:g}"
    axes.loglog(case.plain_steps, case.plain_error, "o-", color=color, markersize=3.2, gid=f"plain {name}")
    axes.loglog(
        case.extrapolated_steps,
        case.extrapolated_error,
        "D--",
        color=color,
        markersize=3.4,
        markerfacecolor="white",
        linewidth=0.7,
        gid=f"extrapolated {name}",
    )


def _draw_order_one(axes: Axes, cases: Sequence[Convergence]) -> None:
    """A line of slope -1 below the plain steps' errors."""
    steps = cases[0].plain_steps
    least = min(float(case.plain_error[0] * case.plain_steps[0]) for case in cases)
    axes.loglog(steps, 0.5 * least / steps, color=BLACK, linewidth=0.8, linestyle=":", gid="order one")
    middle = steps.size // 2
    note(axes, "order 1", (steps[middle], 0.5 * least / steps[middle]), (-4.0, -3.0), ha="right", va="top", color=BLACK)


def _explain(axes: Axes, cases: Sequence[Convergence]) -> None:
    """Two legends beside the panel: how it was stepped, and the ratio of masses."""
    plain = Line2D([], [], color=GREY, marker="o", markersize=3.2)
    extrapolated = Line2D([], [], color=GREY, marker="D", markersize=3.4, markerfacecolor="white", linestyle="--")
    names = ["plain engine steps", f"extrapolated to accuracies\nof {max(ACCURACIES):g} to {min(ACCURACIES):g}"]
    stepping = axes.legend([plain, extrapolated], names, bbox_to_anchor=(1.03, 1.0), loc="upper left")
    axes.add_artist(stepping)
    lines = [Line2D([], [], color=color) for _, color in zip(cases, SERIES, strict=False)]
    names = [f"{case.mass_ratio:g}" for case in cases]
    axes.legend(lines, names, title="$m_1/m_2$", title_fontsize=7.5, bbox_to_anchor=(1.03, 0.75), loc="upper left")
