"""Picture, film and time series of the scenarios of a single impact."""

from bristle_sim.cli.scenario import Columns, Film, Picture
from bristle_sim.comparison import Report


def plot(report: Report) -> Picture:
    """Draw the impact over its normal impulse."""
    from bristle_sim.render.impact_figure import impact_figure

    return impact_figure(report.subject)


def film(report: Report, **size: int) -> Film:
    """Film the impact in slow motion, with the printed 50 us of compression unless contact_duration
    is given.
    """
    from bristle_sim.render.impact_film import ImpactFilm
    from bristle_sim.studies.timed_contact import with_visible_contact

    return ImpactFilm(with_visible_contact(report.subject), **size)


def series(report: Report) -> Columns:
    """Return the history of the impact, if its law resolves it in time."""
    return dict(report.subject.strikes[report.subject.law].contact.columns())


def contact_series(report: Report) -> Columns:
    """Return the history of the contact in a study of its force."""
    if report.subject.contact is None:
        raise ValueError(report.subject.no_contact)
    return dict(report.subject.contact.record.columns())
