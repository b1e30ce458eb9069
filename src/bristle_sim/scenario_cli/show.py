"""Pictures, films and series that several scenarios share; drawing libraries are imported when one is requested."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bristle_sim.comparison import Report


def figure(name: str) -> Callable[[Report, Path], None]:
    """Return a plot of a report's subject by a function of ``bristle_sim.render`` that has its module's name."""

    def plot(report: Report, path: Path) -> None:
        from bristle_sim.render.style import save_figure

        draw = getattr(importlib.import_module(f"bristle_sim.render.{name}"), name)
        save_figure(draw(report.subject), path)

    return plot


def film_of_impact(report: Report, path: Path) -> None:
    """Film an impact in ultra slow motion, compressed in the printed 50 us unless contact_duration says otherwise."""
    from bristle_sim.render.impact_video import impact_video
    from bristle_sim.studies.timed_contact import with_visible_contact

    impact_video(with_visible_contact(report.subject), path)


def series_of_impact(report: Report) -> dict[str, Any]:
    """Return an impact in time, where its law resolves it."""
    return dict(report.subject.strikes[report.subject.law].contact.columns())


def series_of_contact(report: Report) -> dict[str, Any]:
    """Return a contact resolved in time, or raise ValueError where there is none."""
    if report.subject.contact is None:
        raise ValueError(report.subject.no_contact)
    return dict(report.subject.contact.record.columns())


def series_of_pass(report: Report) -> dict[str, Any]:
    """Return the simulated motion."""
    return dict(report.subject.trajectory.columns())
