"""Figures of quantities over one or two parameters, of distributions under scatter, of trade-offs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from bristle_sim.arrays import Array
from bristle_sim.conversion import display_unit
from bristle_sim.parameters import key_unit, tool_keys
from bristle_sim.passes.result import QUANTITIES as QUANTITIES_OF_PASSES
from bristle_sim.passes.result import Ensemble
from bristle_sim.readable import readable_unit
from bristle_sim.render import style
from bristle_sim.render.colours import BLACK, BLUE, GREY, OUTCOMES, SKY, VERMILION
from bristle_sim.studies.design import Design
from bristle_sim.studies.scenario_sweep import Swept
from bristle_sim.studies.tolerances import Study
from bristle_sim.studies.whole_pass import QUANTITIES

# Number of panels in a row, and the width and height, cm, of a panel with its margins.
COLUMNS = 3
WIDTH = 6.0
HEIGHT = 5.2
TITLE_LETTERS = 32  # largest number of letters in a line of a panel's title


OUTCOME = "outcome"

PERCENTILES = (1.0, 99.0)
"""Percentiles at which a colour scale is cut off, at an end where the values beyond would take more
than half of the scale."""


@style.styled()
def sweep_figure(found: Swept, names: Sequence[str]) -> Figure:
    """Draw the outcome and each quantity over one or two swept parameters, one panel each.

    Where a quantity has no value, a line has a gap and a map has white cells.

    Raises:
        ValueError: if no point has a result.
    """
    names = [name for name in names if name in found.known] or list(found.known)
    if not names:
        raise ValueError(f"--plot: must have results to draw; {found.failure.ravel()[0]}")
    panels = [*([] if found.outcome is None else [OUTCOME]), *names]
    rows = math.ceil(len(panels) / COLUMNS)
    figure = style.blank_figure(COLUMNS * WIDTH + 0.6, rows * HEIGHT + 1.0)
    (x, x_label, _), *others = (
        _readable(each, key, found.units[key]) for key, each in found.axes.items()
    )
    y, y_label, _ = others[0] if others else (None, "", 1.0)
    for number, name in enumerate(panels):
        left = 1.4 + WIDTH * (number % COLUMNS)
        bottom = 1.9 + HEIGHT * (rows - 1 - number // COLUMNS)
        axes = style.axes_at(figure, left, bottom, WIDTH - 2.4, HEIGHT - 2.4)
        axes.set_xlabel(x_label, fontsize=7.0, labelpad=2.0)
        axes.set_ylabel(y_label, fontsize=7.0, labelpad=2.0)
        if name == OUTCOME:
            title = "outcome, coloured as below"
            _draw_outcomes(axes, found, x, y)
        else:
            label = found.labels.get(name, name)
            title = _draw_values(axes, found.values[name], label, found.units[name], x, y)
        axes.set_title("\n".join(textwrap.wrap(title, TITLE_LETTERS)), loc="left", fontsize=7.5)
        axes.xaxis.set_major_locator(MaxNLocator(4))
        if y is None:
            room = 0.05 * float(x.max() - x.min()) or 0.5
            axes.set_xlim(float(x.min()) - room, float(x.max()) + room)  # also without a result
    return figure


MANY = 60  # least number of points of a line for which the points have no marks


def _draw_values(
    axes: Axes, values: Array, label: str, unit: str, x: Array, y: Array | None
) -> str:
    """Draw a quantity as a line over x, or as a map over x and y; return the title of its panel."""
    if y is None:
        shown, title, _ = _readable(values, label, unit)
        axes.plot(x, shown, ".-" if len(x) < MANY else "-", color=BLUE, markersize=4.0)
        return title
    low, high, extend = _colour_range(values)
    (vmin, vmax), title, size = _readable(np.array([low, high]), label, unit)
    style.draw_colours(axes, x, y, values.T / size, extend, vmin=vmin, vmax=vmax)
    return title


def _colour_range(values: Array) -> tuple[float, float, str]:
    """Return the lowest and highest value of a map's colour scale, and at which ends values exceed
    it.

    The third result is "neither", "min", "max" or "both", as matplotlib's colour bars take it.
    """
    known = values[np.isfinite(values)]
    low, high = float(known.min()), float(known.max())
    inner, outer = (float(each) for each in np.percentile(known, PERCENTILES))
    below = low < 2.0 * inner - outer < inner
    above = high > 2.0 * outer - inner > outer
    extend = ("neither", "max", "min", "both")[2 * below + above]
    return inner if below else low, outer if above else high, extend


def _draw_outcomes(axes: Axes, found: Swept, x: Array, y: Array | None) -> None:
    """Draw the outcomes as a map over two parameters, or as a strip over one.

    A legend of the outcomes that occur stands at the foot of the figure.
    """
    assert found.outcome is not None
    order = sorted(OUTCOMES)
    codes = np.searchsorted(order, found.outcome)
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
    present = set(found.outcome.ravel())
    looks = {word: {**mark, "color": color} for word, color in OUTCOMES.items() if word in present}
    style.write_key(figure, looks)


def ensemble_figure(many: Ensemble, keys: Sequence[str]) -> Figure:
    """Draw outcome and quantities of many passes over one or two of their parameters.

    ``keys`` names the parameters along the axes.
    """
    axes = {key: many.keys[key].ravel() for key in keys}
    values = {name: getattr(many, name) for name in QUANTITIES_OF_PASSES}
    units = {key: key_unit(key) for key in keys} | QUANTITIES_OF_PASSES
    labels = {name: name.replace("_", " ") for name in values}
    found = Swept(axes, values, units, labels, many.reason, many.outcome)
    return sweep_figure(found, list(values))


MOST = 6  # largest number of inputs shown for each output
ROW = 4.1  # height of an output's panels with their titles, cm
KEY = {
    "passes; mean ± standard deviation": {"color": SKY, "linewidth": 6.0},
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
        spread = float(values.std(ddof=1))
        digits = max(0, 1 - math.floor(math.log10(spread))) if spread > 0.0 else 3
        words = f"{style.signed(values.mean(), digits)} ± {spread:.{digits}f} {unit}"
        style.note(axes, words, (1.0, 1.0), (0.0, 3.0), xycoords="axes fraction", ha="right")
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
    across, *rows = [*found.conflict, *found.varied]
    height = 0.7 + KEY_HEIGHT * (len(rows) + 1)
    figure = style.blank_figure(16.0, height)
    x, x_label, x_size = _readable(found.trade_off[across], *QUANTITIES[across])
    wanted = {each.name: each.wanted for each in found.wants}
    reached = {each.name: each.reached for each in found.wants} | found.varied
    for number, name in enumerate(rows):
        label, unit = QUANTITIES[name] if name in QUANTITIES else (name, key_unit(name))
        y, y_label, y_size = _readable(found.trade_off[name], label, unit)
        tall = KEY_HEIGHT * (2 if number == 0 else 1) - 1.0
        axes = style.axes_at(figure, 2.2, 1.2 + KEY_HEIGHT * (len(rows) - 1 - number), 13.2, tall)
        axes.plot(x, y, color=BLUE, label="best compromises")
        for words, point, mark in (("wanted", wanted, "*"), ("nearest", reached, "o")):
            x_place, y_place = point.get(across), point.get(name)
            if x_place is not None and y_place is not None:
                axes.plot(x_place / x_size, y_place / y_size, mark, color=VERMILION, label=words)
        axes.set_ylabel(textwrap.fill(y_label, 22))
        if number == 0:
            axes.legend(fontsize=7.0)
    axes.set_xlabel(x_label)
    return figure


def _readable(values: Array, label: str, unit: str) -> tuple[Array, str, float]:
    """Return values in a readable unit, their label with this unit, and the conversion factor.

    The factor is the readable unit expressed in the original unit, by which the values are divided.
    """
    is_key = any(label in keys for keys in tool_keys().values())
    shown, size = (
        display_unit(label, unit) if is_key else readable_unit(unit, values.ravel().tolist())
    )
    shown = {"1": "", "deg": "°"}.get(shown, shown)
    return values / size, label + (f" ({shown})" if shown else ""), size
