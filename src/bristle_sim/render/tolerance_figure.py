"""Draw distributions of the strike under spread inputs, and the Sobol indices of the inputs that matter most."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from bristle_sim.render.colours import BLACK, BLUE, SKY, VERMILION
from bristle_sim.render.style import QUANTITIES, add_panel, axes_at, blank_figure, note, styled
from bristle_sim.studies.tolerances import Study

MOST = 6  # inputs shown for each output
ROW = 4.1  # height of an output's panels with their titles, cm


@styled()
def tolerance_figure(study: Study) -> Figure:
    """Draw a histogram of each output with its mean and 95 % interval, beside the indices of its most important inputs."""
    height = ROW * len(study.outputs) + 1.2
    figure = blank_figure(16.0, height)
    for number, output in enumerate(study.outputs):
        bottom = height - ROW * (number + 1) + 0.9
        title, unit, factor = QUANTITIES.get(output, (output.replace("_", " "), "", 1.0))
        axes, values = add_panel(figure, (1.3, bottom, 5.4, 2.1), title), factor * study.values[number]
        axes.hist(values, bins="auto", color=SKY)
        axes.axvspan(*np.percentile(values, (2.5, 97.5)), color=BLUE, alpha=0.12, linewidth=0.0)
        axes.axvline(float(values.mean()), color=BLACK, linewidth=0.9)
        axes.set_yticks([])
        axes.set_xlabel(unit, labelpad=1.0)
        words = f"{values.mean():.4g} ± {values.std(ddof=1):.2g} {unit}"
        note(axes, words, (1.0, 1.0), (0.0, 3.0), xycoords="axes fraction", ha="right")
        axes, chosen = axes_at(figure, 10.3, bottom, 5.3, 2.4), np.argsort(-study.total[number])[:MOST]
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
    words = "first-order index, 95 % intervals as lines"
    handles = [
        Patch(facecolor=SKY, label="passes"),
        Patch(facecolor=BLUE, alpha=0.12, label="95 % of them"),
        Patch(facecolor=VERMILION, alpha=0.45, label="total Sobol index"),
        Line2D([], [], color=BLUE, marker="o", markersize=3.2, label=words),
    ]
    figure.legend(handles=handles, loc="lower center", ncols=4, columnspacing=1.4)
    return figure
