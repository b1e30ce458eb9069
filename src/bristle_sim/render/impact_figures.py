"""Single impacts on a page each: the impulse plane of the impact at hand, and the families that it belongs to."""

from __future__ import annotations

import math

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
from bristle_sim.studies.impact_sweeps import (
    HEAVY_ROD,
    HEAVY_ROD_SURFACE,
    Curve,
    final_rates_over_mass_ratio,
    heavy_rod_impulse_over_friction,
    impulse_over_friction,
    rebound_over_angle,
    rebound_over_friction,
    stiction_friction,
    with_own,
)
from bristle_sim.studies.impacts import Impacts
from bristle_sim.studies.impulse_course import energetic_course, recorded_course
from bristle_sim.studies.law_convergence import engine_energy

__all__ = ["double_pendulum_figure", "oblique_figure", "single_pendulum_figure"]

WIDTH, HEIGHT = 16.0, 15.2
"""Printed size, cm; the width is that of a page's text."""

PANEL = (6.2, 4.9)
"""Width and height of a panel, cm."""

LEFT, RIGHT, LOWER, UPPER = 1.5, 9.5, 1.9, 9.0
"""Where panels begin, cm."""

GAMMA = "$\\gamma$"

FRICTIONS = (0.0, 0.1, 0.3, 0.6, 1.0)
ANGLES = tuple(math.radians(angle) for angle in (15.0, 23.4, 35.0, 50.0, 70.0))
RESTITUTIONS = (0.0, 0.2, 0.42, 0.7, 1.0)


@styled()
def oblique_figure(impacts: Impacts) -> Figure:
    """A radial bristle's strike: impulse plane, rebound ratio (fig. 2.24), final impulse (figs. 2.22, 2.23)."""
    figure, (plane, rebound, by_angle, by_restitution) = _four_panels()
    _draw_plane(plane, impacts)
    _draw_rebound_over_angle(rebound, impacts)
    _draw_impulse_by_angle(by_angle, impacts)
    _draw_impulse_by_restitution(by_restitution, impacts)
    explain_marks(figure, "closed form", "energetic", "compliant", "at hand")
    return figure


@styled()
def single_pendulum_figure(impacts: Impacts) -> Figure:
    """Stronge's single pendulum: impulse plane, and rebound ratio over angle (fig. 2.26) and friction."""
    figure = blank_figure(WIDTH, HEIGHT)
    _draw_plane(axes_at(figure, LEFT, UPPER, RIGHT + PANEL[0] - LEFT, PANEL[1]), impacts)
    _draw_rebound_over_angle(axes_at(figure, LEFT, LOWER, *PANEL), impacts)
    _draw_rebound_over_friction(axes_at(figure, RIGHT, LOWER, *PANEL), impacts)
    explain_marks(figure, "closed form", "energetic", "compliant", "at hand")
    return figure


@styled()
def double_pendulum_figure(impacts: Impacts) -> Figure:
    """Stronge's double pendulum: impulse plane, rates (figs. 2.28, 2.29), impulse (fig. 2.30), the engine's energy."""
    figure, (plane, rates, impulse, energy) = _four_panels()
    _draw_plane(plane, impacts)
    _draw_rates(rates, impacts)
    _draw_heavy_rod(impulse)
    _draw_energies(energy, impacts)
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


def _draw_rebound_over_angle(axes: Axes, impacts: Impacts) -> None:
    panel_title(axes, "b", "rebound ratio over the impact angle")
    axes.set_xlabel(f"impact angle {GAMMA} (°)")
    if _has_ratio(axes, impacts):
        frictions = with_own(FRICTIONS, impacts.surface.friction)
        curves = rebound_over_angle(impacts.chain, impacts.surface, frictions)
        draw_family(axes, curves, "μ =", across=np.degrees)
        star(axes, math.degrees(-impacts.chain.angles[0]), _own_ratio(impacts))
        axes.set_xlim(0.0, 90.0)
        rest = -impacts.chain.hub_radius * impacts.chain.hub_speed / (impacts.chain.lengths[0] * impacts.chain.rates[0])
        note(axes, "stiction: the tip comes to rest", (90.0, rest), (-2.0, -3.0), ha="right", va="top")


def _draw_rebound_over_friction(axes: Axes, impacts: Impacts) -> None:
    panel_title(axes, "c", "rebound ratio over friction")
    if _has_ratio(axes, impacts):
        angles = with_own(ANGLES, -impacts.chain.angles[0])
        curves = rebound_over_friction(impacts.chain, impacts.surface, angles)
        draw_family(axes, curves, f"{GAMMA} =")
        star(axes, impacts.surface.friction, _own_ratio(impacts))
        _frame_frictions(axes, curves)


def _has_ratio(axes: Axes, impacts: Impacts) -> bool:
    """Label the axis of a rebound ratio; a rod at rest has none, and the panel says so."""
    axes.set_ylabel("rate after / rate before")
    moving = impacts.chain.rates[0] != 0.0
    if not moving:
        say(axes, "at rest before the impact: no ratio")
    return moving


def _own_ratio(impacts: Impacts) -> float:
    return impacts.strikes[impacts.law].contact.rates_after[0] / impacts.chain.rates[0]


def _draw_impulse_by_angle(axes: Axes, impacts: Impacts) -> None:
    angles = with_own(ANGLES, -impacts.chain.angles[0])
    panel_title(axes, "c", "final impulse over friction")
    _draw_impulses(axes, impacts, impulse_over_friction(impacts.chain, impacts.surface, angles=angles), f"{GAMMA} =")
    for angle, color in zip(angles, SERIES, strict=False):
        _draw_stiction(axes, stiction_friction(impacts.surface, angle), color)


def _draw_impulse_by_restitution(axes: Axes, impacts: Impacts) -> None:
    restitutions = with_own(RESTITUTIONS, impacts.surface.restitution)
    panel_title(axes, "d", "final impulse over friction")
    _draw_impulses(
        axes, impacts, impulse_over_friction(impacts.chain, impacts.surface, restitutions=restitutions), "e* ="
    )
    _draw_stiction(axes, stiction_friction(impacts.surface, -impacts.chain.angles[0]), GREY)


def _draw_impulses(axes: Axes, impacts: Impacts, curves: tuple[Curve, ...], parameter: str) -> None:
    """Final impulses up to where most curves have left for stiction."""
    shown = 1.8 * max(float(curve.theory[0]) for curve in curves)
    scale = scale_for(shown, "N·s")
    draw_family(axes, curves, parameter, up=lambda y: y * scale.factor)
    star(axes, impacts.surface.friction, impacts.strikes[impacts.law].contact.impulse[0] * scale.factor)
    axes.set_ylim(0.0, shown * scale.factor or 1.0)
    _frame_frictions(axes, curves)
    axes.set_ylabel(f"$p_f$ ({scale.unit})")


def _frame_frictions(axes: Axes, curves: tuple[Curve, ...]) -> None:
    """As far as the curves go, with room for points at no friction."""
    most = max(float(curve.x[-1]) for curve in curves)
    axes.set_xlim(-0.02 * most, 1.04 * most)
    axes.locator_params(axis="x", nbins=6)
    axes.set_xlabel("friction μ")


def _draw_stiction(axes: Axes, friction: float, color: str) -> None:
    """A dotted line where p_f has no bound; named where there is but one."""
    if friction < axes.get_xlim()[1]:
        axes.axvline(friction, color=color, linewidth=0.8, linestyle=":", zorder=1, gid="stiction")
        if color == GREY:
            note(axes, "stiction", (friction, 0.0), (-1.0, 4.0), ha="right", va="bottom", rotation=90.0)


def _draw_rates(axes: Axes, impacts: Impacts) -> None:
    """Rates of both rods over the ratio of their masses; the heavy rod's tends to what it was."""
    curves = final_rates_over_mass_ratio(impacts.chain, impacts.surface)
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


def _draw_heavy_rod(axes: Axes) -> None:
    """The bristle as a double pendulum, up to where p_f leaves for stiction."""
    curves = heavy_rod_impulse_over_friction()
    scale = scale_for(float(curves[-1].theory[0]), "N·s")
    draw_family(axes, curves, "$m_1/m_2$ =", up=lambda y: y * scale.factor)
    _draw_stiction(axes, float(stiction_friction(HEAVY_ROD_SURFACE, -HEAVY_ROD.angles[1])), GREY)
    axes.set_ylim(0.0, 2.0 * float(curves[-1].theory[0]) * scale.factor)
    _frame_frictions(axes, curves)
    panel_title(axes, "c", "bristle as double pendulum")
    angle, restitution = math.degrees(-HEAVY_ROD.angles[0]), HEAVY_ROD_SURFACE.restitution
    note(axes, f"both rods at {angle:g}°, e* = {restitution:g}", (0.0, axes.get_ylim()[1]), (0.0, -3.0), va="top")
    axes.set_xlabel("friction μ")
    axes.set_ylabel(f"$p_f$ ({scale.unit})")


def _draw_energies(axes: Axes, impacts: Impacts) -> None:
    panel_title(axes, "d", "more iterations, more energy", _coefficients(impacts))
    if impacts.strikes[impacts.law].kinetic_energy_ratio is None:
        say(axes, "at rest: no energy to compare")
    else:
        draw_energy(axes, engine_energy(impacts.chain, impacts.surface))
