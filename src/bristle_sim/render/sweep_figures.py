"""Figures of quantities over one or two parameters, of distributions under scatter, of trade-offs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle_sim.arrays import Array
from bristle_sim.parameters import key_unit
from bristle_sim.passes.result import QUANTITIES as QUANTITIES_OF_PASSES
from bristle_sim.passes.result import Ensemble
from bristle_sim.render import style
from bristle_sim.render.colours import BLACK, BLUE, GREY, OUTCOMES, SKY, VERMILION
from bristle_sim.studies.design import Design
from bristle_sim.studies.scenario_sweep import Series, Swept
from bristle_sim.studies.tolerances import Study
from bristle_sim.studies.whole_pass import QUANTITIES

# Number of panels in a row, and the width and height, cm, of a panel with its margins.
COLUMNS = 3
WIDTH = 6.0
HEIGHT = 5.2
TITLE_LETTERS = 32  # largest number of letters in a line of a panel's title

PERCENTILES = (1.0, 99.0)
"""Percentiles at which a map's colour scale ends, so that a single extreme value does not take most
of it."""

MANY = 60  # least number of points of a line for which the points have no marks


@style.styled()
def sweep_figure(found: Swept, names: Sequence[str]) -> Figure:
    """Draw the outcome and each quantity over one or two swept parameters, one panel each.

    Where a quantity has no value, a line has a gap and a map has white cells.

    Raises:
        ValueError: if no point has a result.
    """
    known = {name: each for name, each in found.quantities.items() if each.known}
    if not known:
        raise ValueError(f"--plot: must have results to draw; {found.failure.ravel()[0]}")
    shown = [known[name] for name in names if name in known] or [*known.values()]
    panels = [*([] if found.outcome is None else [None]), *shown]
    rows = math.ceil(len(panels) / COLUMNS)
    figure = style.blank_figure(COLUMNS * WIDTH + 0.6, rows * HEIGHT + 1.0)
    scales = [axis.values / axis.display[1] for axis in found.axes.values()]
    x = scales[0]
    for number, quantity in enumerate(panels):
        left = 1.4 + WIDTH * (number % COLUMNS)
        bottom = 1.9 + HEIGHT * (rows - 1 - number // COLUMNS)
        axes = style.axes_at(figure, left, bottom, WIDTH - 2.4, HEIGHT - 2.4)
        for label, axis in zip(found.axes.values(), (axes.xaxis, axes.yaxis), strict=False):
            axis.set_label_text(_heading(label), fontsize=7.0)
            axis.labelpad = 2.0
        title = "outcome, coloured as below" if quantity is None else _heading(quantity)
        axes.set_title("\n".join(textwrap.wrap(title, TITLE_LETTERS)), loc="left", fontsize=7.5)
        axes.xaxis.set_major_locator(MaxNLocator(4))
        if quantity is None:
            _draw_outcomes(axes, found.outcome, *scales)
        elif len(scales) == 1:
            values = quantity.values / quantity.display[1]
            axes.plot(x, values, ".-" if len(x) < MANY else "-", color=BLUE, markersize=4.0)
        else:
            values = quantity.values.T / quantity.display[1]
            low, high = np.nanpercentile(values, PERCENTILES)
            style.draw_colours(axes, x, scales[1], values, "both", vmin=low, vmax=high)
        if len(scales) == 1:
            room = 0.05 * float(x.max() - x.min()) or 0.5
            axes.set_xlim(float(x.min()) - room, float(x.max()) + room)  # also without a result
    return figure


def _heading(series: Series) -> str:
    return series.heading.replace("(deg)", "(°)")


def _draw_outcomes(axes: Axes, outcome: Any, x: Array, y: Array | None = None) -> None:
    """Draw the outcomes as a map over two parameters, or as a strip over one.

    A legend of the outcomes that occur stands at the foot of the figure.
    """
    order = sorted(OUTCOMES)
    codes = np.searchsorted(order, outcome)
    if y is None:
        codes = np.stack([codes, codes], axis=1)
        axes.set_yticks([])
    axes.grid(visible=False)
    axes.pcolormesh(
        x,
        np.arange(2.0) if y is None else y,
        codes.T,
        shading="nearest",
        rasterized=True,
        cmap=ListedColormap([OUTCOMES[word] for word in order]),
        vmin=-0.5,
        vmax=len(order) - 0.5,
    )
    figure = axes.get_figure(root=True)
    assert figure is not None
    mark = {"marker": "s", "linestyle": "none", "markeredgecolor": GREY}
    present = set(outcome.ravel())
    looks = {word: {**mark, "color": color} for word, color in OUTCOMES.items() if word in present}
    style.write_key(figure, looks)


def ensemble_figure(many: Ensemble, keys: Sequence[str]) -> Figure:
    """Draw outcome and quantities of many passes over one or two of their parameters.

    ``keys`` names the parameters along the axes.
    """
    axes = {key: Series(key, key_unit(key), many.keys[key].ravel(), is_key=True) for key in keys}
    quantities = {
        name: Series(name.replace("_", " "), unit, getattr(many, name))
        for name, unit in QUANTITIES_OF_PASSES.items()
    }
    found = Swept(axes, quantities, many.reason, many.outcome)
    return sweep_figure(found, list(quantities))


MOST = 6  # largest number of inputs shown for each output
ROW = 4.1  # height of an output's panels with their titles, cm
KEY = {
    "passes, and their mean": {"color": SKY, "linewidth": 6.0},
    "95 % of them": {"color": BLUE, "alpha": 0.12, "linewidth": 6.0},
    "total Sobol index": {"color": VERMILION, "alpha": 0.45, "linewidth": 6.0},
    "first-order index": {"color": BLUE, "linestyle": "none", "marker": "o", "markersize": 3.2},
    "95 % interval": {"color": GREY, "linewidth": 0.9},
}


@style.styled()
def tolerance_figure(study: Study) -> Figure:
    """Draw a histogram of each output, and the sensitivity indices of its most important inputs.

    The histogram shows the mean and the 95 % interval.
    """
    height = ROW * len(study.outputs) + 1.4
    figure = style.blank_figure(16.0, height)
    for number, output in enumerate(study.outputs):
        bottom = height - ROW * (number + 1) + 0.9
        title, unit, factor = style.QUANTITIES.get(output, (output.replace("_", " "), "", 1.0))
        axes = style.add_panel(figure, (1.3, bottom, 5.4, 2.1), title)
        values = factor * study.values[number]
        axes.hist(values, bins="auto", color=SKY)
        axes.axvspan(*np.percentile(values, (2.5, 97.5)), color=BLUE, alpha=0.12, linewidth=0.0)
        axes.axvline(float(values.mean()), color=BLACK, linewidth=0.9)
        axes.set_yticks([])
        axes.set_xlabel(unit, labelpad=1.0)
        axes = style.axes_at(figure, 10.3, bottom, 5.3, 2.4)
        chosen = np.argsort(-study.total[number])[:MOST]
        places = np.arange(chosen.size)
        axes.barh(places, study.total[number, chosen], color=VERMILION, alpha=0.45, height=0.7)
        axes.plot(study.first_order[number, chosen], places - 0.17, "o", color=BLUE, markersize=3.2)
        sides = ((study.total_interval, VERMILION, 0.17), (study.first_order_interval, BLUE, -0.17))
        for intervals, color, shift in sides:
            axes.hlines(places + shift, *intervals[number, chosen].T, color=color, linewidth=0.9)
        axes.set_yticks(places, [study.inputs[each].replace("_", " ") for each in chosen])
        axes.invert_yaxis()
        axes.set_xlim(min(-0.02, float(study.first_order_interval[number, chosen].min())), None)
        axes.tick_params(axis="y", length=0.0)
        axes.set_xlabel("Sobol index", labelpad=1.0)
    style.write_key(figure, KEY, ncols=3)
    return figure


KEY_HEIGHT = 3.0  # height of the panel of a parameter, cm


@style.styled()
def trade_off_figure(found: Design) -> Figure:
    """Draw the best compromises between two wanted quantities that conflict.

    Marks show the wanted point and the nearest point that can be reached. Further panels show the
    varied parameters along the compromises.
    """
    curves = {name: Series(*QUANTITIES[name], found.trade_off[name]) for name in found.conflict}
    for key in found.varied:
        curves[key] = Series(key, key_unit(key), found.trade_off[key], is_key=True)
    wanted = {each.name: each.wanted for each in found.wants}
    reached = {each.name: each.reached for each in found.wants} | found.varied
    across, *rows = curves
    figure = style.blank_figure(16.0, 0.7 + KEY_HEIGHT * len(curves))
    for number, name in enumerate(rows):
        tall = KEY_HEIGHT * (2 if number == 0 else 1) - 1.0
        axes = style.axes_at(figure, 2.2, 1.2 + KEY_HEIGHT * (len(rows) - 1 - number), 13.2, tall)
        sizes = [curves[each].display[1] for each in (across, name)]
        lines = [curves[across].values / sizes[0], curves[name].values / sizes[1]]
        axes.plot(*lines, color=BLUE, label="best compromises")
        for words, point, mark in (("wanted", wanted, "*"), ("nearest", reached, "o")):
            place = np.array([point.get(across), point.get(name)], float)  # NaN where unknown
            axes.plot(*(place / sizes), mark, color=VERMILION, label=words)
        axes.set_ylabel(textwrap.fill(_heading(curves[name]), 22))
        if number == 0:
            axes.legend(fontsize=7.0)
    axes.set_xlabel(_heading(curves[across]))
    return figure
