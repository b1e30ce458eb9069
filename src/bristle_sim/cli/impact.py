"""Picture, film and time series that several scenarios of a single impact show."""

from bristle_sim.cli.scenario import Columns, Film, Picture
from bristle_sim.comparison import Report


def plot(report: Report) -> Picture:
    """Draw the impact over its normal impulse."""
    from bristle_sim.render.impact_figure import impact_figure

    return impact_figure(report.subject)


def film(report: Report, **size: int) -> Film:
    """Film the impact in ultra slow motion, compressed in the printed 50 us unless contact_duration says otherwise."""
    from bristle_sim.render.impact_film import ImpactFilm
    from bristle_sim.studies.timed_contact import with_visible_contact

    return ImpactFilm(with_visible_contact(report.subject), **size)


def series(report: Report) -> Columns:
    """Return the impact in time, where its law resolves it."""
    return dict(report.subject.strikes[report.subject.law].contact.columns())


def contact_series(report: Report) -> Columns:
    """Return the contact resolved in time of a study of its force."""
    if report.subject.contact is None:
        raise ValueError(report.subject.no_contact)
    return dict(report.subject.contact.record.columns())
