"""Picture, film and time series of the scenarios of a single impact."""

from bristle_sim.cli.scenario import Columns, Film, Picture
from bristle_sim.comparison import Report


def plot(report: Report) -> Picture:
    """Draw the tip's velocities over the normal impulse of an impact."""
    from bristle_sim.render.impact_figure import impact_figure

    return impact_figure(report.subject)


def film(report: Report, **size: int) -> Film:
    """Film an impact in slow motion; ``size`` is ``width`` and ``height`` in px.

    If no contact duration is given, compression lasts the 50 us printed in the dissertation.
    """
    from bristle_sim.render.impact_film import ImpactFilm
    from bristle_sim.studies.timed_contact import with_visible_contact

    return ImpactFilm(with_visible_contact(report.subject), **size)


def series(report: Report) -> Columns:
    """Return the motion and forces of an impact over time, if its law resolves the impact in time."""
    return dict(report.subject.strikes[report.subject.contact.law].contact.columns())


def contact_series(report: Report) -> Columns:
    """Return the motion and forces of the simulated contact over time, in a study of its force.

    Raises:
        ValueError: if there is no contact.
    """
    if report.subject.contact is None:
        raise ValueError(report.subject.no_contact)
    return dict(report.subject.contact.strike.contact.columns())
