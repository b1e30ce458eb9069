"""Figure of the crater: every estimate of its depth beside the measured depth."""

from __future__ import annotations

from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, VERMILION
from bristle_sim.render.style import add_panel, blank_figure, styled
from bristle_sim.studies.crater_study import MEASURED, CraterStudy

MICRO = 1e6  # micrometres in a metre


@styled()
def crater_figure(study: CraterStudy) -> Figure:
    """Draw every estimate of the crater depth, um, beside the measured depth."""
    rows = _estimates(study)
    names, depths, colors = zip(*rows, strict=True)
    measured = MICRO * MEASURED
    offs = [100.0 * (depth / measured - 1.0) for depth in depths]
    nearest = min(range(len(rows)), key=lambda row: abs(offs[row]))
    words = f"{abs(offs[nearest]):.0f} % {'deeper' if offs[nearest] > 0.0 else 'shallower'}"
    finding = f"Nearest to the measured depth: {' '.join(names[nearest].split())}, {words}"
    figure = blank_figure(16.0, 7.6)
    figure.text(1.5 / 16.0, 1.0 - 0.6 / 7.6, finding, fontsize=9.0)
    label = f"crater depth (µm); line: measured, {measured:.0f} µm"
    words = "shaded: within 10 % of the measured depth"
    title = "crater depth by every estimate"
    axes = add_panel(figure, (4.6, 1.2, 8.8, 4.4), title, words, xlabel=label)
    axes.axvspan(0.9 * measured, 1.1 * measured, color=GREY, alpha=0.18, linewidth=0.0)
    axes.axvline(measured, color=BLACK, linewidth=1.2)
    places = range(len(rows))
    axes.barh(places, depths, color=colors, alpha=0.55, height=0.6)
    axes.set_yticks(places, names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    found = [f"{depth:.0f} µm, {off:+.0f} %" for depth, off in zip(depths, offs, strict=True)]
    right = axes.secondary_yaxis("right")
    right.set_yticks(places, [each.replace("-", "\N{MINUS SIGN}") for each in found])
    return figure


def _estimates(study: CraterStudy) -> list[tuple[str, float, str]]:
    """Return name, depth (um) and colour of every estimate of the crater depth.

    The sum of work and energy, which gives millimetres, is left out.
    """
    looks = {
        "merchant_crater_depth": (f"Merchant, {study.crater.plies:g} plies", BLUE),
        "merchant_crater_depth_limit": ("Merchant, limit", BLUE),
        "ratio_of_sums": ("ratio of sums (4.66), 5 plies", GREEN),
        "contact_force_depth": ("simulated force", VERMILION),
        "contact_energy_depth": ("simulated energy", VERMILION),
        "contact_energy_depth_inclined": ("simulated energy,\nshear to the surface", VERMILION),
    }
    return [
        (words, MICRO * study.depths[name], color)
        for name, (words, color) in looks.items()
        if name in study.depths
    ]
