"""Single impacts on a page each: the impulse plane of the impact at hand, and the families that it belongs to."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.impulse_plane import draw_impulse_plane
from bristle_sim.render.prefixes import scale_for
from bristle_sim.render.style import axes_at, blank_figure, styled
from bristle_sim.render.sweep_panels import (
    draw_energy,
    draw_panel,
    explain_marks,
    handles,
    name_curves,
    note,
    panel_title,
    plain_decades,
    say,
)
from bristle_sim.studies.curves import Panel
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.impulse_course import energetic_course, recorded_course
from bristle_sim.studies.law_convergence import EngineEnergy

__all__ = ["double_pendulum_figure", "oblique_figure", "single_pendulum_figure"]

WIDTH, HEIGHT = 16.0, 15.2
"""Printed size, cm; the width is that of a page's text."""

PANEL = (6.2, 4.9)
"""Width and height of a panel, cm."""

LEFT, RIGHT, LOWER, UPPER = 1.5, 9.5, 1.9, 9.0
"""Where panels begin, cm."""

HAND = "the impact at hand"
AT_REST = "at rest before the impact: no ratio"


@styled()
def oblique_figure(impacts: Impacts, panels: Mapping[str, Panel]) -> Figure:
    """Draw a radial bristle's strike: impulse plane, rebound ratio (fig. 2.24), final impulse (figs. 2.22, 2.23)."""
    figure, (plane, rebound, by_angle, by_restitution) = _four_panels()
    _draw_plane(plane, impacts)
    _draw_rebound_over_angle(rebound, impacts, panels.get("rebound over angle"))
    _draw_impulse(by_angle, panels["impulse by angle"], "c", "impact angle")
    _draw_impulse(by_restitution, panels["impulse by restitution"], "d", "restitution")
    explain_marks(figure, "energetic", "compliant", HAND)
    return figure


@styled()
def single_pendulum_figure(impacts: Impacts, panels: Mapping[str, Panel]) -> Figure:
    """Draw Stronge's single pendulum: impulse plane, and rebound ratio over angle (fig. 2.26) and friction."""
    figure = blank_figure(WIDTH, HEIGHT)
    _draw_plane(axes_at(figure, LEFT, UPPER, RIGHT + PANEL[0] - LEFT, PANEL[1]), impacts)
    _draw_rebound_over_angle(axes_at(figure, LEFT, LOWER, *PANEL), impacts, panels.get("rebound over angle"))
    _draw_rebound_over_friction(axes_at(figure, RIGHT, LOWER, *PANEL), panels.get("rebound over friction"))
    explain_marks(figure, "energetic", "compliant", HAND)
    return figure


@styled()
def double_pendulum_figure(impacts: Impacts, panels: Mapping[str, Panel], energy: EngineEnergy | None) -> Figure:
    """Draw Stronge's double pendulum: impulse plane, rates (figs. 2.28, 2.29), impulse (fig. 2.30), the engine's energy.

    ``energy`` is None for a pendulum at rest before the impact.
    """
    figure, (plane, rates, impulse, energies) = _four_panels()
    _draw_plane(plane, impacts)
    _draw_rates(rates, panels["rates over mass ratio"])
    _draw_heavy_rod(impulse, panels["heavy rod"])
    _draw_energies(energies, impacts, energy)
    explain_marks(figure, "energetic", "compliant", HAND)
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
    """Angles and coefficients of the impact at hand."""
    surface = impacts.surface
    angles = ", ".join(f"{math.degrees(-angle):.4g}°" for angle in impacts.chain.angles)
    later = "" if surface.restitution_friction is None else f" (restitution {surface.restitution_friction:.4g})"
    return f"{angles} to the normal, μ = {surface.friction:.4g}{later}, e* = {surface.restitution:.4g}"


def _draw_family(axes: Axes, panel: Panel, own: str = HAND) -> Panel:
    """Draw a family in units that can be read, its curves named above it; returns what was drawn."""
    shown = _readable(panel)
    draw_panel(axes, shown, own)
    name_curves(axes, shown)
    return shown


def _readable(panel: Panel) -> Panel:
    """The panel with its impulses in a unit of a fitting prefix."""
    if not panel.y.unit.endswith("N·s"):
        return panel
    scale = scale_for(panel.top or max(float(np.abs(curve.theory).max()) for curve in panel.curves), "N·s")
    return dataclasses.replace(panel, y=dataclasses.replace(panel.y, unit=scale.unit, factor=scale.factor))


def _draw_rebound_over_angle(axes: Axes, impacts: Impacts, panel: Panel | None) -> None:
    panel_title(axes, "b", "rebound ratio over the impact angle")
    if panel is None:
        say(axes, AT_REST)
        return
    _draw_family(axes, panel)
    axes.set_xlim(0.0, 90.0)
    rod = impacts.chain
    rest = -rod.hub_radius * rod.hub_speed / (rod.lengths[0] * rod.rates[0])
    if any(np.isclose(curve.theory, rest, atol=1e-9).any() for curve in panel.curves):
        bottom, top = axes.get_ylim()
        axes.set_ylim(bottom, top + 0.07 * (top - bottom))
        note(axes, "flat: stiction, the tip comes to rest", (90.0, rest), (-2.0, 3.0), ha="right", va="bottom")


def _draw_rebound_over_friction(axes: Axes, panel: Panel | None) -> None:
    panel_title(axes, "c", "rebound ratio over friction")
    if panel is None:
        say(axes, AT_REST)
        return
    _draw_family(axes, panel)
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.12 * (top - bottom))
    _explain_stiction(axes, panel)


def _draw_impulse(axes: Axes, panel: Panel, letter: str, family: str) -> None:
    panel_title(axes, letter, f"final impulse, by {family}")
    _draw_family(axes, panel)
    _explain_stiction(axes, panel)


def _explain_stiction(axes: Axes, panel: Panel) -> None:
    """Say what dashed upright lines are, where there are any."""
    label = next((level.label for level in panel.levels if level.upright), None)
    if label is not None:
        look = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}
        note(
            axes,
            f"dashed: {label}",
            (1.0, 1.0),
            (-2.0, -3.0),
            xycoords="axes fraction",
            ha="right",
            va="top",
            bbox=look,
        )


def _draw_rates(axes: Axes, panel: Panel) -> None:
    """Rates of both rods over the ratio of their masses; the heavy rod's tends to what it was."""
    panel_title(axes, "b", "final rates over the ratio of masses")
    _draw_family(axes, panel)
    plain_decades(axes)
    for level in panel.levels:
        place = (float(panel.curves[0].x[-1]), level.value)
        if level.value > axes.get_ylim()[0]:
            note(axes, level.label, place, (0.0, -3.0), ha="right", va="top")
        else:
            note(axes, level.label, place, (0.0, 3.0), ha="right", va="bottom")


def _draw_heavy_rod(axes: Axes, panel: Panel) -> None:
    """The bristle as a double pendulum, up to where p_f leaves for stiction."""
    panel_title(axes, "c", "the bristle as a double pendulum (fig. 2.30)")
    _draw_family(axes, panel, "operating point")
    key = [*handles(panel, key=False), handles(panel, key=True)[-1]]
    axes.legend(loc="upper left", fontsize=6.5, labelspacing=0.25, handles=key)


def _draw_energies(axes: Axes, impacts: Impacts, energy: EngineEnergy | None) -> None:
    panel_title(axes, "d", "the engine's own contact: its energy", _coefficients(impacts))
    if energy is None:
        say(axes, "at rest: no energy to compare")
    else:
        draw_energy(axes, energy)
