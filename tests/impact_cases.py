"""Impacts that tests of pictures share, and what their panels hold."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from bristle_sim.parameters import Bristle, Contact, DoublePendulum, Hub, Strike, Surface
from bristle_sim.settings import Settings
from bristle_sim.studies.contact_laws import Impacts
from bristle_sim.studies.impacts import double_pendulum, oblique_impact

ROUGH = Surface(friction=0.5, restitution=0.5)
TRAPEZOIDAL = (math.pi / 24.0) ** 2 / 12.0
"""Relative error of an impulse summed by the trapezoidal rule over the 24 intervals of a record."""


def bristle(
    state: Strike | None = None, contact: Contact | None = None, **surface: float
) -> Impacts:
    report = oblique_impact(
        Hub(), Bristle(), state or Strike(), Surface(**surface), contact or Contact(), Settings()
    )
    assert isinstance(report.subject, Impacts)
    return report.subject


def rods(surface: Surface = ROUGH, **pendulum: float) -> Impacts:
    report = double_pendulum(DoublePendulum(**pendulum), surface, Contact(), Settings())
    assert isinstance(report.subject, Impacts)
    return report.subject


def panel(figure: Figure, title: str) -> Axes:
    """The panel whose title begins with some words."""
    return next(axes for axes in figure.axes if axes.get_title(loc="left").startswith(title))


def line(axes: Axes, name: str) -> Line2D:
    return next(each for each in axes.get_lines() if each.get_gid() == name)


def data(axes: Axes, name: str) -> tuple[np.ndarray, np.ndarray]:
    x, y = line(axes, name).get_data()
    return np.asarray(x, dtype=float), np.asarray(y, dtype=float)


def words(axes: Axes) -> str:
    return "\n".join(text.get_text() for text in axes.texts)
