"""Single impacts on a page each: the impulse plane of the impact at hand, and the families that it belongs to."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bristle_sim.render.impulse_plane import draw_impulse_plane
from bristle_sim.render.prefixes import scale_for
from bristle_sim.render.style import GREY, SERIES, axes_at, blank_figure, styled
from bristle_sim.render.sweep_panels import (
    draw_energy,
    draw_family,
    explain_marks,
    note,
    panel_title,
    plain_decades,
    say,
    star,
)
from bristle_sim.studies.curves import Curve
from bristle_sim.studies.impact_sweeps import (
    ANGLES,
    HEAVY_ROD,
    HEAVY_ROD_SURFACE,
    Families,
    stiction_friction,
    with_own,
)
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

GAMMA = "$\\gamma$"


@styled()
def oblique_figure(impacts: Impacts, families: Families) -> Figure:
    """Draw a radial bristle's strike: impulse plane, rebound ratio (fig. 2.24), final impulse (figs. 2.22, 2.23)."""
    figure, (plane, rebound, by_angle, by_restitution) = _four_panels()
    _draw_plane(plane, impacts)
    _draw_rebound_over_angle(rebound, impacts, families["rebound over angle"])
    _draw_impulse_by_angle(by_angle, impacts, families["impulse by angle"])
    _draw_impulse_by_restitution(by_restitution, impacts, families["impulse by restitution"])
    explain_marks(figure, "closed form", "energetic", "compliant", "at hand")
    return figure


@styled()
def single_pendulum_figure(impacts: Impacts, families: Families) -> Figure:
    """Draw Stronge's single pendulum: impulse plane, and rebound ratio over angle (fig. 2.26) and friction."""
    figure = blank_figure(WIDTH, HEIGHT)
    _draw_plane(axes_at(figure, LEFT, UPPER, RIGHT + PANEL[0] - LEFT, PANEL[1]), impacts)
    _draw_rebound_over_angle(axes_at(figure, LEFT, LOWER, *PANEL), impacts, families["rebound over angle"])
    _draw_rebound_over_friction(axes_at(figure, RIGHT, LOWER, *PANEL), impacts, families["rebound over friction"])
    explain_marks(figure, "closed form", "energetic", "compliant", "at hand")
    return figure


@styled()
def double_pendulum_figure(impacts: Impacts, families: Families, energy: EngineEnergy | None) -> Figure:
    """Draw Stronge's double pendulum: impulse plane, rates (figs. 2.28, 2.29), impulse (fig. 2.30), the engine's energy.

    ``energy`` is None for a pendulum at rest before the impact.
    """
    figure, (plane, rates, impulse, energies) = _four_panels()
    _draw_plane(plane, impacts)
    _draw_rates(rates, impacts, families["rates over mass ratio"])
    _draw_heavy_rod(impulse, families["heavy rod"])
    _draw_energies(energies, impacts, energy)
    explain_marks(figure, "closed form", "energetic", "compliant", "at hand")
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


def _draw_rebound_over_angle(axes: Axes, impacts: Impacts, curves: Sequence[Curve]) -> None:
    panel_title(axes, "b", "rebound ratio over the impact angle")
    axes.set_xlabel(f"impact angle {GAMMA} (°)")
    if not _has_ratio(axes, curves):
        return
    draw_family(axes, curves, "μ =", across=np.degrees)
    star(axes, math.degrees(-impacts.chain.angles[0]), _own_ratio(impacts))
    axes.set_xlim(0.0, 90.0)
    rod = impacts.chain
    rest = -rod.hub_radius * rod.hub_speed / (rod.lengths[0] * rod.rates[0])
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.07 * (top - bottom))
    note(axes, "flat: stiction, the tip comes to rest", (90.0, rest), (-2.0, 3.0), ha="right", va="bottom")


def _draw_rebound_over_friction(axes: Axes, impacts: Impacts, curves: Sequence[Curve]) -> None:
    panel_title(axes, "c", "rebound ratio over friction")
    axes.set_xlabel("friction μ")
    if not _has_ratio(axes, curves):
        return
    draw_family(axes, curves, f"{GAMMA} =")
    star(axes, impacts.surface.friction, _own_ratio(impacts))
    _frame_frictions(axes, curves)
    if impacts.surface.restitution_friction is None:
        _, top = axes.get_ylim()
        axes.set_ylim(top=top + 0.1 * (top - axes.get_ylim()[0]))
        note(
            axes, STICTION.format("curves end at stiction"), (0.0, 1.0), (2.0, -3.0), xycoords="axes fraction", va="top"
        )


STICTION = "{}, μ = tan " + GAMMA


def _has_ratio(axes: Axes, curves: Sequence[Curve]) -> bool:
    """Label the axis of a rebound ratio; a rod at rest has none, and the panel says so."""
    axes.set_ylabel("rate after / rate before")
    if not curves:
        say(axes, "at rest before the impact: no ratio")
    return bool(curves)


def _own_ratio(impacts: Impacts) -> float:
    return impacts.strikes[impacts.law].contact.rates_after[0] / impacts.chain.rates[0]


def _draw_impulse_by_angle(axes: Axes, impacts: Impacts, curves: Sequence[Curve]) -> None:
    panel_title(axes, "c", "final impulse over friction, by impact angle")
    _draw_impulses(axes, impacts, curves, f"{GAMMA} =")
    angles = with_own(ANGLES, -impacts.chain.angles[0])
    drawn = [
        _draw_stiction(axes, stiction_friction(impacts.surface, angle), color)
        for angle, color in zip(angles, SERIES, strict=False)
    ]
    if any(drawn):
        words = STICTION.format("dotted: stiction")
        note(
            axes,
            words,
            (1.0, 1.0),
            (-2.0, -3.0),
            xycoords="axes fraction",
            ha="right",
            va="top",
            backgroundcolor="white",
        )


def _draw_impulse_by_restitution(axes: Axes, impacts: Impacts, curves: Sequence[Curve]) -> None:
    panel_title(axes, "d", "final impulse over friction, by restitution")
    _draw_impulses(axes, impacts, curves, "e* =")
    _draw_stiction(axes, stiction_friction(impacts.surface, -impacts.chain.angles[0]), GREY)


def _draw_impulses(axes: Axes, impacts: Impacts, curves: Sequence[Curve], parameter: str) -> None:
    """Final impulses up to where most curves have left for stiction."""
    shown = 1.8 * max(float(curve.theory[0]) for curve in curves)
    scale = scale_for(shown, "N·s")
    draw_family(axes, curves, parameter, up=lambda y: y * scale.factor)
    star(axes, impacts.surface.friction, impacts.strikes[impacts.law].contact.impulse[0] * scale.factor)
    axes.set_ylim(0.0, shown * scale.factor or 1.0)
    _frame_frictions(axes, curves)
    axes.set_ylabel(f"normal final impulse $p_f$ ({scale.unit})")


def _frame_frictions(axes: Axes, curves: Sequence[Curve]) -> None:
    """As far as the curves go, with room for points at no friction."""
    most = max(float(curve.x[-1]) for curve in curves)
    axes.set_xlim(-0.02 * most, 1.04 * most)
    axes.locator_params(axis="x", nbins=6)
    axes.set_xlabel("friction μ")


def _draw_stiction(axes: Axes, friction: float, color: str) -> bool:
    """Draw a dotted line where p_f has no bound, if it is in view; name it where it is the only one."""
    if friction >= axes.get_xlim()[1]:
        return False
    axes.axvline(friction, color=color, linewidth=0.8, linestyle=":", zorder=1, gid="stiction")
    if color == GREY:
        note(axes, STICTION.format("dotted: stiction"), (friction, 0.0), (-3.0, 3.0), ha="right", va="bottom")
    return True


def _draw_rates(axes: Axes, impacts: Impacts, curves: Sequence[Curve]) -> None:
    """Rates of both rods over the ratio of their masses; the heavy rod's tends to what it was."""
    axes.set_xscale("log")
    draw_family(axes, curves, "rate of")
    plain_decades(axes)
    before = -impacts.chain.rates[0]
    axes.axhline(before, color=SERIES[0], linewidth=0.8, linestyle=":", gid="rod 1 before")
    note(axes, "rod 1 before the impact", (curves[0].x[-1], before), (0.0, -3.0), ha="right", va="top", color=SERIES[0])
    ratio = impacts.chain.masses[0] / impacts.chain.masses[1]
    for rate in impacts.strikes[impacts.law].contact.rates_after:
        star(axes, ratio, -rate)
    panel_title(axes, "b", "final rates over the ratio of masses")
    axes.set_xlabel("mass ratio $m_1/m_2$")
    axes.set_ylabel("rate after the impact (rad/s)")


def _draw_heavy_rod(axes: Axes, curves: Sequence[Curve]) -> None:
    """The bristle as a double pendulum, up to where p_f leaves for stiction."""
    scale = scale_for(float(curves[-1].theory[0]), "N·s")
    draw_family(axes, curves, "$m_1/m_2$ =", up=lambda y: y * scale.factor)
    _draw_stiction(axes, float(stiction_friction(HEAVY_ROD_SURFACE, -HEAVY_ROD.angles[1])), GREY)
    axes.set_ylim(0.0, 2.0 * float(curves[-1].theory[0]) * scale.factor)
    _frame_frictions(axes, curves)
    panel_title(axes, "c", "the bristle as a double pendulum (fig. 2.30)")
    angle, restitution = math.degrees(-HEAVY_ROD.angles[0]), HEAVY_ROD_SURFACE.restitution
    note(axes, f"both rods at {angle:g}°, e* = {restitution:g}", (0.0, axes.get_ylim()[1]), (0.0, -3.0), va="top")
    axes.set_xlabel("friction μ")
    axes.set_ylabel(f"normal final impulse $p_f$ ({scale.unit})")


def _draw_energies(axes: Axes, impacts: Impacts, energy: EngineEnergy | None) -> None:
    panel_title(axes, "d", "the engine's own contact: its energy", _coefficients(impacts))
    if energy is None:
        say(axes, "at rest: no energy to compare")
    else:
        draw_energy(axes, energy)
