"""Picture, film and time series of the scenarios of a single impact."""

from bristle_sim.cli.scenario import Columns, Film, Picture
from bristle_sim.comparison import Report


def plot(report: Report) -> Picture:
    """Draw the tip's velocity components during an impact against the normal impulse."""
    from bristle_sim.render.impact_pictures import impact_figure

    return impact_figure(report.subject)


def film(report: Report, **size: int) -> Film:
    """Film an impact in slow motion; ``size`` is ``width`` and ``height`` in px.

    If the impact law has no contact duration, the film shows a compression of 50 us, the value
    printed in the dissertation.
    """
    from bristle_sim.render.impact_pictures import ImpactFilm
    from bristle_sim.studies.timed_contact import with_visible_contact

    return ImpactFilm(with_visible_contact(report.subject), **size)


def series(report: Report) -> Columns:
    """Return the motion and forces of an impact over time.

    The impact law must be one that resolves the contact in time.
    """
    return dict(report.subject.strikes[report.subject.contact.law].contact.columns())


def contact_series(report: Report) -> Columns:
    """Return the motion and forces over time of the contact that a force study has simulated.

    Raises:
        ValueError: if there is no contact.
    """
    if report.subject.contact is None:
        raise ValueError(report.subject.no_contact)
    return dict(report.subject.contact.strike.contact.columns())
