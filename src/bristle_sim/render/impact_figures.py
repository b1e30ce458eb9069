"""Draw single impacts on a page each: the impulse plane of the impact at hand, and the families that it belongs to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.impulse_plane import draw_impulse_plane
from bristle_sim.render.panels import draw_energy, draw_panel, explain_marks, name_curves, note, panel_title, say
from bristle_sim.render.style import axes_at, blank_figure, scale_for, styled
from bristle_sim.studies.curves import Panel
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.impulse_course import energetic_course, recorded_course
from bristle_sim.studies.law_convergence import EngineEnergy

WIDTH, HEIGHT = 16.0, 15.2
"""Printed size, cm; the width is that of a page's text."""

PANEL = (6.2, 4.9)
"""Width and height of a panel, cm."""

LEFT, RIGHT, LOWER, UPPER = 1.5, 9.5, 1.9, 9.0
"""Where panels begin, cm."""

HAND, OPERATING_POINT = "the impact at hand", "operating point"
AT_REST = "at rest before the impact: no ratio"


@styled()
def oblique_figure(impacts: Impacts, panels: Mapping[str, Panel]) -> Figure:
    """Draw a radial bristle's strike: impulse plane, rebound ratio (fig. 2.24), final impulse (figs. 2.22, 2.23)."""
    figure, (plane, rebound, by_angle, by_restitution) = _four_panels()
    _draw_plane(plane, impacts)
    _draw_rebound(rebound, impacts, panels.get("rebound over angle"))
    _draw_family(by_angle, "c", "final impulse, by impact angle", panels["impulse by angle"])
    _draw_family(by_restitution, "d", "final impulse, by restitution", panels["impulse by restitution"])
    explain_marks(figure, "energetic", "compliant", HAND)
    return figure


@styled()
def single_pendulum_figure(impacts: Impacts, panels: Mapping[str, Panel]) -> Figure:
    """Draw Stronge's single pendulum: impulse plane, and rebound ratio over angle (fig. 2.26) and friction."""
    figure = blank_figure(WIDTH, HEIGHT)
    _draw_plane(axes_at(figure, LEFT, UPPER, RIGHT + PANEL[0] - LEFT, PANEL[1]), impacts)
    _draw_rebound(axes_at(figure, LEFT, LOWER, *PANEL), impacts, panels.get("rebound over angle"))
    over_friction = axes_at(figure, RIGHT, LOWER, *PANEL)
    _draw_family(over_friction, "c", "rebound ratio over friction", panels.get("rebound over friction"))
    explain_marks(figure, "energetic", "compliant", HAND)
    return figure


@styled()
def double_pendulum_figure(impacts: Impacts, panels: Mapping[str, Panel], energy: EngineEnergy | None) -> Figure:
    """Draw Stronge's double pendulum: impulse plane, rates (figs. 2.28, 2.29), impulse (fig. 2.30), the engine's energy.

    ``energy`` is None for a pendulum at rest before the impact.
    """
    figure, (plane, rates, impulse, energies) = _four_panels()
    _draw_plane(plane, impacts)
    _draw_family(rates, "b", "final rates over the ratio of masses", panels["rates over mass ratio"])
    rates.xaxis.set_major_formatter("{x:g}")
    _draw_family(impulse, "c", "the bristle as a double pendulum (fig. 2.30)", panels["heavy rod"], OPERATING_POINT)
    panel_title(energies, "d", "the engine's own contact: its energy", _coefficients(impacts))
    if energy is None:
        say(energies, "at rest: no energy to compare")
    else:
        draw_energy(energies, energy)
    explain_marks(figure, "energetic", "compliant", HAND, OPERATING_POINT)
    return figure


def _four_panels() -> tuple[Figure, tuple[Axes, ...]]:
    figure = blank_figure(WIDTH, HEIGHT)
    places = [(LEFT, UPPER), (RIGHT, UPPER), (LEFT, LOWER), (RIGHT, LOWER)]
    return figure, tuple(axes_at(figure, *place, *PANEL) for place in places)


def _draw_plane(axes: Axes, impacts: Impacts) -> None:
    resolved = impacts.strikes.get("compliant")
    history = None if resolved is None else resolved.contact.history
    recorded = None if history is None else recorded_course(history)
    draw_impulse_plane(axes, energetic_course(impacts.chain, impacts.surface), recorded)
    panel_title(axes, "a", "the impact at hand", _coefficients(impacts))


def _coefficients(impacts: Impacts) -> str:
    """Write angles and coefficients of the impact at hand."""
    surface = impacts.surface
    angles = ", ".join(f"{math.degrees(-angle):.4g}°" for angle in impacts.chain.angles)
    later = "" if surface.restitution_friction is None else f" (restitution {surface.restitution_friction:.4g})"
    return f"{angles} to the normal, μ = {surface.friction:.4g}{later}, e* = {surface.restitution:.4g}"


def _draw_family(axes: Axes, letter: str, title: str, panel: Panel | None, own: str = HAND) -> None:
    """Draw a family in units that can be read, its curves named above it and its levels in it; or say that it has none."""
    panel_title(axes, letter, title)
    if panel is None:
        say(axes, AT_REST)
        return
    draw_panel(axes, _readable(panel), own)
    name_curves(axes, panel)
    lowest, highest = axes.get_ylim()
    for level in panel.levels:
        if not level.upright:
            up = -3.0 if level.value > lowest else 3.0
            place = (float(panel.curves[0].x[-1]), level.value)
            note(axes, level.label, place, (0.0, up), ha="right", va="top" if up < 0.0 else "bottom")
    stiction = next((level.label for level in panel.levels if level.upright), None)
    if stiction is not None:
        axes.set_ylim(lowest, highest + 0.12 * (highest - lowest))
        look: dict[str, Any] = {"xycoords": "axes fraction", "ha": "right", "va": "top"}
        box = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}
        note(axes, f"dashed: {stiction}", (1.0, 1.0), (-2.0, -3.0), bbox=box, **look)


def _readable(panel: Panel) -> Panel:
    """Return the panel with its impulses in a unit of a readable prefix."""
    if not panel.y.unit.endswith("N·s"):
        return panel
    scale = scale_for(panel.top or max(float(np.abs(curve.theory).max()) for curve in panel.curves), "N·s")
    return dataclasses.replace(panel, y=dataclasses.replace(panel.y, unit=scale.unit, factor=scale.factor))


def _draw_rebound(axes: Axes, impacts: Impacts, panel: Panel | None) -> None:
    """Draw the rebound ratio over the impact angle, with a note where curves are flat."""
    _draw_family(axes, "b", "rebound ratio over the impact angle", panel)
    if panel is None:
        return
    axes.set_xlim(0.0, 90.0)
    rod = impacts.chain
    rest = -rod.hub_radius * rod.hub_speed / (rod.lengths[0] * rod.rates[0])
    if any(np.isclose(curve.theory, rest, atol=1e-9).any() for curve in panel.curves):
        bottom, top = axes.get_ylim()
        axes.set_ylim(bottom, top + 0.07 * (top - bottom))
        note(axes, "flat: stiction, the tip comes to rest", (90.0, rest), (-2.0, 3.0), ha="right", va="bottom")
