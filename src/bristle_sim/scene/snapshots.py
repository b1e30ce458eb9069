"""A run interval by interval: the state, the contacts, the event that ended the interval, and the
decision after it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from bristle_sim.parameters import Tool
from bristle_sim.scene.contact import ActiveContact
from bristle_sim.scene.events import Happening, Kind
from bristle_sim.scene.mechanism import State
from bristle_sim.scene.results import contacts_in_si
from bristle_sim.scene.run import run_by_intervals
from bristle_sim.scene.simulate import prepare
from bristle_sim.scene.system import System
from bristle_sim.scene.tool import Units
from bristle_sim.settings import Settings, StopReason
from bristle_sim.trajectory import ContactRecord

SLIDING = {0: "stick", 1: "slip +", -1: "slip -"}
"""Names of the senses of slip."""


@dataclass(frozen=True, slots=True)
class ContactState:
    """The state of a lasting contact at an instant.

    Attributes:
        obstacle: ``bar`` or ``workpart``.
        link: number of the link in contact, from 1 at the root.
        mode: ``stick``, ``slip +`` or ``slip -`` (the sense of the tangential velocity),
            ``at rest``, or ``frictionless``. For a contact resolved in time the phase of its spring
            comes first: ``loading,``, ``unloading,`` or ``at rest,``.
        normal_force: normal force on the wire, N; None where a contact without a spring begins at
            this instant.
        tangential_force: tangential force on the wire, N; None likewise.
    """

    obstacle: str
    link: int
    mode: str
    normal_force: float | None
    tangential_force: float | None

    def __str__(self) -> str:
        """Return obstacle, mode and normal force, for example ``bar (slip + 12.3 N)``."""
        force = "" if self.normal_force is None else f" {self.normal_force:.3g} N"
        return f"{self.obstacle} ({self.mode}{force})"


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The end of one interval of a run, and the decision after the event that ended it; SI units
    and radians.

    Attributes:
        time: time of the interval's end, s.
        interval: length of the interval, s; 0 at the run's start, and for an event at the
            interval's beginning.
        angles: absolute angle of each link after the decision, rad.
        rates: absolute rate of each link after the decision, rad/s.
        rates_before: rates before the decision, rad/s; an impact changes them.
        contacts: the contacts that were active during the interval, with their forces at its end.
        event: the kind of event that ended the interval, in words; empty without an event.
        subject: the obstacle of the contact that had the event, or ``wire`` for an event of the
            motion; empty without an event.
        events: names of the events that the trajectory records at this instant.
        began: the contacts that the decision began.
        ended: the contacts that the decision ended.
        changed: the contacts whose mode the decision changed.
        impacts: records of the impacts at this instant, and of the contacts that ended.
        stop_reason: why the run stops here; None while it goes on.
    """

    time: float
    interval: float
    angles: tuple[float, ...]
    rates: tuple[float, ...]
    rates_before: tuple[float, ...]
    contacts: tuple[ContactState, ...] = ()
    event: str = ""
    subject: str = ""
    events: tuple[str, ...] = ()
    began: tuple[ContactState, ...] = ()
    ended: tuple[ContactState, ...] = ()
    changed: tuple[ContactState, ...] = ()
    impacts: tuple[ContactRecord, ...] = ()
    stop_reason: StopReason | None = None

    def __str__(self) -> str:
        """Return time, contacts, event and decision in one line."""
        parts = [f"{1e3 * self.time:.6f} ms: {', '.join(map(str, self.contacts)) or 'no contact'}"]
        if self.event:
            parts.append(f"{self.subject}: {self.event}")
        parts += [f"{each.obstacle} {each.outcome}" for each in self.impacts]
        for name in ("began", "ended", "changed"):
            contacts = getattr(self, name)
            if contacts:
                parts.append(f"{name}: {', '.join(map(str, contacts))}")
        if self.stop_reason is not None:
            parts.append(f"stopped: {self.stop_reason}")
        return "; ".join(parts)


def snapshots(
    tool: Tool,
    settings: Settings | None = None,
    *,
    start_hub_angle: float | None = None,
    start_relative_angle: float = 0.0,
    start_relative_rate: float = 0.0,
    stop_after: str | None = None,
) -> Iterator[Snapshot]:
    """Yield the run of one bristle interval by interval; :func:`bristle_sim.simulate` goes through
    the same intervals.

    The first snapshot is the start of the run, the last one its end. Each snapshot is computed when
    it is requested, so the caller may stop anywhere.

    Args:
        tool, settings, start_hub_angle, start_relative_angle, start_relative_rate, stop_after: as
            for ``simulate``.

    Raises:
        ValueError: as for ``simulate``: at once for bad input, and during the run for a contact
            that cannot be resolved.
    """
    begin = (start_hub_angle, start_relative_angle, start_relative_rate)
    system, units, _ = prepare(tool, settings, begin, stop_after=stop_after)
    return _snapshots(system, units)


def _snapshots(system: System, units: Units) -> Iterator[Snapshot]:
    """Yield the snapshots of a system's run."""
    recording = system.recording
    run = run_by_intervals(system)
    active: tuple[ActiveContact, ...] = ()
    time = 0.0
    event_count = record_count = 0
    for motion, event in run:
        reached = system.state
        before = {contact: contact_state(contact, units) for contact in active}
        active = motion.contacts if event is None else next(run)[0].contacts
        after = {contact: contact_state(contact, units) for contact in active}
        lasting = [contact for contact in active if contact in before]
        yield Snapshot(
            time=reached.time * units.time,
            interval=(reached.time - time) * units.time,
            angles=system.state.angles,
            rates=_rates_in_si(system.state, units),
            rates_before=_rates_in_si(reached, units),
            contacts=tuple(before.values()),
            event="" if event is None else event.kind.name.lower().replace("_", " "),
            subject="" if event is None else _subject(event),
            events=tuple([recorded.name for recorded, _ in recording.events[event_count:]]),
            began=tuple([after[contact] for contact in active if contact not in before]),
            ended=tuple([before[contact] for contact in before if contact not in after]),
            changed=tuple(
                [
                    after[contact]
                    for contact in lasting
                    if after[contact].mode != before[contact].mode
                ]
            ),
            impacts=contacts_in_si(recording.contacts[record_count:], system.mechanism, 0, units),
            stop_reason=recording.stop_reason,
        )
        time = reached.time
        event_count = len(recording.events)
        record_count = len(recording.contacts)


def _rates_in_si(state: State, units: Units) -> tuple[float, ...]:
    return tuple([rate / units.time for rate in state.rates])


def contact_state(contact: ActiveContact, units: Units) -> ContactState:
    """Return the state of a contact in SI units, with the forces computed last."""
    pair = contact.pair
    spring = contact.spring
    normal, tangential = contact.force, None if contact.force is None else contact.tangential
    if spring is not None:
        _, normal, tangential, *_ = spring.course.rows[-1]
    return ContactState(
        obstacle=pair.name,
        link=pair.link + 1,
        mode=_mode(contact),
        normal_force=None if normal is None else normal * units.force,
        tangential_force=None if tangential is None else tangential * units.force,
    )


def _mode(contact: ActiveContact) -> str:
    """Return the mode of a contact, as in ``ContactState``."""
    spring = contact.spring
    if spring is not None:
        phase = "at rest" if spring.at_rest else "loading" if spring.loading else "unloading"
        return f"{phase}, {SLIDING[spring.slip]}"
    if contact.slip is None:
        return "at rest" if contact.pair.friction else "frictionless"
    return SLIDING[contact.slip]


def _subject(event: Happening) -> str:
    """Return the obstacle of the contact that had an event, or the wire for an event of the motion."""
    subject = event.subject
    if event.kind is Kind.DENT_LEFT:
        return "workpart"
    if subject is None:
        return "rigid contacts"
    if isinstance(subject, int):
        return "wire"
    parts = subject if isinstance(subject, tuple) else (subject,)
    names = [part.pair.name if isinstance(part, ActiveContact) else part.name for part in parts]
    return " and ".join(dict.fromkeys(names))
