"""Figure of the crater: every estimate of its depth beside the measured depth."""

from __future__ import annotations

from matplotlib.figure import Figure

from bristle_sim.render.colours import BLACK, BLUE, GREEN, GREY, VERMILION
from bristle_sim.render.style import MICROMETRES, blank_figure, styled
from bristle_sim.studies.crater_study import MEASURED, CraterStudy


@styled()
def crater_figure(study: CraterStudy) -> Figure:
    """Draw all estimates of the crater depth (um) as bars, beside the measured depth."""
    rows = _estimates(study)
    names, depths, colors = zip(*rows, strict=True)
    shown = [MICROMETRES * depth for depth in depths]
    offs = [100.0 * (depth / MEASURED - 1.0) for depth in depths]
    off, nearest = min(zip(offs, names, strict=True), key=lambda each: abs(each[0]))
    figure = blank_figure(16.0, 6.6)
    axes = figure.subplots()
    measured = MICROMETRES * MEASURED
    figure.suptitle(
        f"nearest to the measured depth: {' '.join(nearest.split())},"
        f" {abs(off):.0f} % {'deeper' if off > 0.0 else 'shallower'}"
    )
    axes.set_xlabel(
        f"crater depth (µm); line: measured, {measured:.0f} µm, shaded: within 10 % of it"
    )
    axes.axvspan(0.9 * measured, 1.1 * measured, color=GREY, alpha=0.18, linewidth=0.0)
    axes.axvline(measured, color=BLACK, linewidth=1.2)
    labels = [
        f"{name}: {depth:.0f} µm, {off:+.0f} %".replace("-", "\N{MINUS SIGN}")
        for name, depth, off in zip(names, shown, offs, strict=True)
    ]
    axes.barh(labels, shown, color=colors, alpha=0.55, height=0.6)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    return figure


def _estimates(study: CraterStudy) -> list[tuple[str, float, str]]:
    """Return name, value (m) and colour of every estimate of the crater depth.

    The estimate by the sum of work and energy is omitted, since it is of the order of millimetres.
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
        (words, study.depths[name], color)
        for name, (words, color) in looks.items()
        if name in study.depths
    ]
