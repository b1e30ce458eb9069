"""Figures of a scenario's quantities over one key or two, of distributions under spread inputs, and
of trade-offs.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from bristle_sim.arrays import Array
from bristle_sim.comparison import readable_unit
from bristle_sim.parameters import key_unit
from bristle_sim.render import style
from bristle_sim.render.colours import BLACK, BLUE, GREY, SKY, VERMILION
from bristle_sim.studies.design import Design
from bristle_sim.studies.tolerances import Study
from bristle_sim.studies.whole_pass import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr

# Number of panels in a row, and width and height of a panel with its margins, cm.
COLUMNS = 3
WIDTH = 6.0
HEIGHT = 5.2
TITLE_LETTERS = 32  # largest number of letters in a line of a panel's title


@style.styled()
def sweep_figure(found: xr.Dataset, keys: Sequence[str]) -> Figure:
    """Draw a panel for each quantity: a line over one key, or a map over two.

    Lines have gaps and maps white cells where there is no value.

    Raises:
        ValueError: if no point has a result.
    """
    quantities = [str(name) for name in found.data_vars if name != "failure"]
    names = [name for name in quantities if np.isfinite(found[name].values).any()]
    if not names:
        raise ValueError(f"--plot: must have results to draw; {found['failure'].values.ravel()[0]}")
    rows = math.ceil(len(names) / COLUMNS)
    figure = style.blank_figure(COLUMNS * WIDTH + 0.6, rows * HEIGHT + 0.4)
    (x, x_label), *others = (_shown(found, key) for key in keys)
    for number, name in enumerate(names):
        column = number % COLUMNS
        row = rows - 1 - number // COLUMNS
        axes = style.axes_at(
            figure, 1.4 + WIDTH * column, 1.3 + HEIGHT * row, WIDTH - 2.4, HEIGHT - 2.4
        )
        values, label = _shown(found, name)
        axes.set_title("\n".join(textwrap.wrap(label, TITLE_LETTERS)), loc="left", fontsize=7.5)
        axes.set_xlabel(x_label, fontsize=7.0, labelpad=2.0)
        for y, y_label in others:
            axes.set_ylabel(y_label, fontsize=7.0, labelpad=2.0)
            style.draw_colours(axes, x, y, values.T if found[name].dims[0] == keys[0] else values)
        if not others:
            axes.plot(x, values, ".-", color=BLUE, markersize=4.0)
            low, high = float(x.min()), float(x.max())  # includes points without a result
            room = 0.05 * (high - low) or 0.5
            axes.set_xlim(low - room, high + room)
    return figure


def _shown(found: xr.Dataset, name: str) -> tuple[Array, str]:
    """Return the values of a quantity in a readable unit, and their label with that unit."""
    about = found[name].attrs
    label = str(about.get("long_name", name.removesuffix("_deg").replace("_", " ")))
    return _readable(found[name].values, label, str(about.get("units", "1")))[:2]


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
    """Draw a histogram of each output with mean and 95 % interval, and the indices of its most
    important inputs.
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


KEY_HEIGHT = 3.0  # height of the panel of a key, cm


@style.styled()
def trade_off_figure(found: Design) -> Figure:
    """Draw the best compromises of two conflicting wants, with the wanted and the nearest point,
    and the keys along them.
    """
    across, *rows = [*found.conflict, *found.varied]
    height = 0.7 + KEY_HEIGHT * (len(rows) + 1)
    figure = style.blank_figure(16.0, height)
    x, x_label, x_size = _readable(found.trade_off[across], *QUANTITIES[across])
    points: dict[str, dict[str, float | None]] = {
        "wanted": {each.name: each.wanted for each in found.wants},
        "nearest": {**{each.name: each.reached for each in found.wants}, **found.varied},
    }
    for number, name in enumerate(rows):
        label, unit = QUANTITIES[name] if name in QUANTITIES else (name, key_unit(name))
        y, y_label, y_size = _readable(found.trade_off[name], label, unit)
        tall = KEY_HEIGHT * (2 if number == 0 else 1) - 1.0
        axes = style.axes_at(figure, 2.2, 1.2 + KEY_HEIGHT * (len(rows) - 1 - number), 13.2, tall)
        axes.plot(x, y, color=BLUE, label="best compromises")
        for (words, point), mark in zip(points.items(), "*o", strict=True):
            place = (point.get(across), point.get(name))
            if place[0] is not None and place[1] is not None:
                axes.plot(place[0] / x_size, place[1] / y_size, mark, color=VERMILION, label=words)
        axes.set_ylabel(textwrap.fill(y_label, 22))
        if number == 0:
            axes.legend(fontsize=7.0)
    axes.set_xlabel(x_label)
    return figure


def _readable(values: Array, label: str, unit: str) -> tuple[Array, str, float]:
    """Return values in a readable unit, their label with that unit, and the size of the unit."""
    shown, size = readable_unit(unit, values.ravel().tolist())
    shown = {"1": "", "deg": "°"}.get(shown, shown)
    return values / size, label + (f" ({shown})" if shown else ""), size
