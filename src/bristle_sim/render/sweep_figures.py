"""Figures of quantities over one or two parameters, of distributions under scatter, of trade-offs, and
maps of a strike over the bar's position.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import CenteredNorm, to_rgb
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.parameters import KEYS
from bristle_sim.passes.result import QUANTITIES as QUANTITIES_OF_PASSES
from bristle_sim.passes.result import Ensemble
from bristle_sim.readable import MILLIMETRES
from bristle_sim.render.style import (
    BLACK,
    BLUE,
    GREY,
    OUTCOMES,
    SKY,
    STRIKE_LOOKS,
    VERMILION,
    blank_figure,
    styled,
    write_key,
)
from bristle_sim.studies.cue_map import CueMap
from bristle_sim.studies.design import Design
from bristle_sim.studies.scenario_sweep import Series, Swept
from bristle_sim.studies.tolerances import Study
from bristle_sim.studies.whole_pass import QUANTITIES

# Largest number of panels in a row, and the width and height of a panel, cm.
COLUMNS = 3
WIDTH = 6.2
HEIGHT = 4.4
TITLE_LETTERS = 32  # largest number of letters in a line of a panel's title

PERCENTILES = (1.0, 99.0)
"""Percentiles of the values at which a map's colour scale begins and ends.

A single extreme value would otherwise take most of the scale."""

MANY = 60  # smallest number of points of a curve that is drawn without marks at its points


@styled()
def sweep_figure(found: Swept, names: Sequence[str]) -> Figure:
    """Draw the outcome and each quantity of a sweep in a panel over the one or two parameters.

    Where a quantity has no value, a curve has a gap, and a map has a white cell.

    Args:
        found: result of the sweep.
        names: names of the quantities to draw; if empty, all are drawn.

    Raises:
        ValueError: if no quantity has a value.
    """
    shown = [found.quantities[name] for name in names or found.quantities]
    shown = [each for each in shown if each.finite.size]
    if not shown:
        raise ValueError(f"--plot: must have results to draw; {found.failure.ravel()[0]}")
    panels = [*([] if found.outcome is None else [None]), *shown]
    rows = math.ceil(len(panels) / COLUMNS)
    figure = blank_figure(COLUMNS * WIDTH, rows * HEIGHT + 1.0)
    places = figure.subplots(rows, COLUMNS, sharex=True, squeeze=False).ravel()
    axis_labels = [axis.heading for axis in found.axes.values()]
    x, *others = (axis.values / axis.display[1] for axis in found.axes.values())
    for axes, quantity in zip(places, panels, strict=False):
        title = "outcome, coloured as above" if quantity is None else quantity.heading
        axes.set_title("\n".join(textwrap.wrap(title, TITLE_LETTERS)), fontsize=7.5)
        axes.tick_params(labelbottom=True)
        if quantity is None:
            _draw_outcomes(axes, found.outcome, x, *others)
            continue
        values = quantity.values / quantity.display[1]
        if not others:
            axes.plot(x, values, ".-" if len(x) < MANY else "-", color=BLUE, markersize=4.0)
            continue
        low, high = np.nanpercentile(values, PERCENTILES)
        cells = axes.pcolormesh(x, *others, values.T, vmin=low, vmax=high, rasterized=True)
        figure.colorbar(cells, ax=axes, extend="both")
    for axes in places[len(panels) :]:
        axes.remove()
    figure.supxlabel(axis_labels[0], fontsize=8.0)
    figure.supylabel("".join(axis_labels[1:]), fontsize=8.0)
    return figure


def _draw_outcomes(axes: Axes, outcome: Any, x: Array, y: Array | None = None) -> None:
    """Draw the outcomes as a map over two parameters, or as a coloured strip over one.

    ``outcome`` holds the outcomes in words; ``x`` and ``y`` hold the values of the parameters. A
    legend at the top of the figure names the outcomes that occur.
    """
    if y is None:
        y = np.arange(2.0)
        outcome = np.stack([outcome, outcome], axis=1)
        axes.set_yticks([])
    colours = np.array([to_rgb(OUTCOMES[word]) for word in outcome.T.ravel()])
    axes.pcolormesh(x, y, colours.reshape(*outcome.T.shape, 3), rasterized=True)
    figure = axes.get_figure(root=True)
    assert figure is not None
    mark = {"marker": "s", "linestyle": "none", "markeredgecolor": GREY}
    present = set(outcome.ravel())
    looks = {word: {**mark, "color": color} for word, color in OUTCOMES.items() if word in present}
    write_key(figure, looks, loc="outside upper center")


def ensemble_figure(many: Ensemble, keys: Sequence[str]) -> Figure:
    """Draw the outcome and quantities of many passes over one or two of their parameters.

    ``keys`` are the keys of these parameters.
    """
    axes = {key: Series(key, KEYS[key].unit, many.keys[key].ravel(), is_key=True) for key in keys}
    quantities = {
        name: Series(name.replace("_", " "), unit, getattr(many, name))
        for name, unit in QUANTITIES_OF_PASSES.items()
    }
    found = Swept(axes, quantities, many.reason, many.outcome)
    return sweep_figure(found, list(quantities))


MOST = 6  # largest number of inputs shown for each output
BAR = 0.36  # width of a bar, as a fraction of the distance between inputs; each input has two bars


@styled()
def tolerance_figure(study: Study) -> Figure:
    """Draw the scatter of each output, and the inputs that cause it.

    A histogram of the output shows its mean and the interval that contains 95 % of the passes. Bars
    show the Sobol indices of the most influential inputs: the fractions of the output's variance
    that an input causes alone (first-order) and with all its interactions (total).
    """
    figure = blank_figure(16.0, 3.8 * len(study.outputs) + 1.2)
    places = figure.subplots(len(study.outputs), 2, squeeze=False)
    for number, (left, right) in enumerate(places):
        name = study.outputs[number]
        title, unit, factor = STRIKE_LOOKS.get(name, (name.replace("_", " "), "", 1.0))
        values = factor * study.values[number]
        left.hist(values, bins="auto", color=SKY, label="passes")
        middle = np.percentile(values, (2.5, 97.5))
        left.axvspan(*middle, color=BLUE, alpha=0.12, linewidth=0.0, label="95 % of the passes")
        left.axvline(float(values.mean()), color=BLACK, linewidth=0.9, label="mean")
        left.set(yticks=[], xlabel=unit, title=title)
        chosen = np.argsort(-study.total[number])[:MOST]
        rows = np.arange(chosen.size)
        for words, indices, intervals, color, shift in (
            ("total", study.total, study.total_interval, VERMILION, -0.5 * BAR),
            ("first-order", study.first_order, study.first_order_interval, BLUE, 0.5 * BAR),
        ):
            look = {"color": color, "alpha": 0.45, "label": f"{words} index, 95 % interval"}
            right.barh(rows + shift, indices[number, chosen], BAR, **look)
            right.hlines(rows + shift, *intervals[number, chosen].T, color=color, linewidth=0.9)
        right.set_yticks(rows, [study.inputs[each].replace("_", " ") for each in chosen])
        right.invert_yaxis()
        right.set_xlabel("Sobol index")
    named = zip(*(each.get_legend_handles_labels() for each in places[0]), strict=True)
    figure.legend(*map(sum, named, ([], [])), ncols=3, loc="outside upper center")
    return figure


@styled()
def trade_off_figure(found: Design) -> Figure:
    """Draw the best compromises between two quantities whose target values or limits conflict.

    Marks show the target values or limits and the nearest values that can be reached. Further
    panels show the parameters of the compromises.
    """
    curves = {name: Series(*QUANTITIES[name], found.trade_off[name]) for name in found.conflict}
    for key in found.varied:
        curves[key] = Series(key, KEYS[key].unit, found.trade_off[key], is_key=True)
    wanted = {each.name: each.wanted for each in found.wants}
    reached = {each.name: each.reached for each in found.wants} | found.varied
    across, *rows = curves
    figure = blank_figure(16.0, 4.0 * len(rows))
    panels = figure.subplots(len(rows), sharex=True, squeeze=False).ravel()
    for axes, name in zip(panels, rows, strict=True):
        pair = [curves[across], curves[name]]
        axes.plot(
            *(each.values / each.display[1] for each in pair), color=BLUE, label="best compromises"
        )
        for words, point, mark in (("wanted", wanted, "*"), ("nearest", reached, "o")):
            place = np.array([point.get(across), point.get(name)], float)  # NaN where unknown
            place /= [each.display[1] for each in pair]
            axes.plot(*place, mark, color=VERMILION, label=words)
        axes.set_ylabel(textwrap.fill(curves[name].heading, 22))
    panels[0].legend(fontsize=7.0)
    panels[-1].set_xlabel(curves[across].heading)
    return figure


MAPS = ("lag_deg_at_contact", "tip_speed_at_contact", "normal_compressive_work", "crater_depth")


@styled()
def map_figure(found: CueMap, x: Array, y: Array, maps: Mapping[str, Array]) -> Figure:
    """Draw maps of four quantities of the strike over the bar's position.

    The quantities are lag, tip speed, normal work of compression and crater depth. A white cell is
    a position of the bar at which the bristle does not strike after it has left the bar.

    Args:
        found: the study, with the bar positions to mark.
        x, y: coordinates of the bar on the maps, m.
        maps: values of the quantities by name, as returned by
            :func:`bristle_sim.studies.cue_map.position_map`.
    """
    assert found.tool.bar is not None
    distance = math.hypot(*found.tool.bar.centre) * MILLIMETRES
    arc = np.linspace(0.0, math.pi, 721)
    places = (x * MILLIMETRES, y * MILLIMETRES)
    lags = maps["lag_deg_at_contact"]
    looks = [("s", "white"), ("^", BLUE), ("o", VERMILION), ("+", BLACK)]
    if found.formula is None:
        del looks[1]
    figure = blank_figure(16.0, 15.3)
    for axes, name in zip(figure.subplots(2, 2, sharex=True, sharey=True).flat, MAPS, strict=True):
        title, unit, factor = STRIKE_LOOKS[name]
        values = factor * maps[name]
        known = values[np.isfinite(values)]
        low, high = np.percentile(known, PERCENTILES) if known.size else (0.0, 1.0)
        look: dict[str, Any] = {"vmin": low, "vmax": high}
        if name == "lag_deg_at_contact":
            half = max(abs(low), abs(high)) or 1.0
            look = {"norm": CenteredNorm(halfrange=half), "cmap": "RdBu"}
        cells = axes.pcolormesh(*places, values, shading="nearest", rasterized=True, **look)
        figure.colorbar(cells, ax=axes, extend="both")
        axes.set_title(f"{title} ({unit})")
        if np.nanmin(lags) < 0.0 < np.nanmax(lags):
            axes.contour(*places, lags, levels=[0.0], colors=BLACK, linewidths=0.9)
        axes.set(xlim=axes.get_xlim(), ylim=axes.get_ylim(), aspect="equal")
        axes.set(xlabel="S_H, along the workpart (mm)", ylabel="S_V, normal to the workpart (mm)")
        axes.label_outer()
        axes.grid(visible=False)
        axes.plot([], [], color=BLACK, linewidth=0.9, label="lag zero")
        label = "bar at its given distance from the hub"
        axes.plot(distance * np.sin(arc), distance * np.cos(arc), "--", color=GREY, label=label)
        for (label, direction), (marker, colour) in zip(found.marks.items(), looks, strict=True):
            place = (distance * math.sin(direction), distance * math.cos(direction))
            words = f"{label}, {math.degrees(direction):.2f}°"
            axes.plot(*place, marker, color=colour, markeredgecolor=BLACK, label=words)
    axes.plot([], [], "s", color="white", markeredgecolor=GREY, label="no cued strike")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure
