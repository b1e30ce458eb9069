"""A run as a sequence of snapshots: the state and the contacts after each interval and each
event."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from bristle_sim.parameters import Tool
from bristle_sim.scene.contact import ActiveContact
from bristle_sim.scene.results import contacts_in_si
from bristle_sim.scene.run import run
from bristle_sim.scene.simulate import prepare
from bristle_sim.scene.spring import SpringContact
from bristle_sim.scene.system import System
from bristle_sim.scene.tool import Units
from bristle_sim.settings import Settings, StopReason
from bristle_sim.trajectory import ContactRecord

SLIDING = {0: "stick", 1: "slip +", -1: "slip -"}
"""Names of the senses of slip, used in ``ContactState.mode``."""


@dataclass(frozen=True, slots=True)
class ContactState:
    """The state of a sustained contact at an instant.

    Attributes:
        obstacle: ``bar`` or ``workpart``.
        link: number of the link in contact, from 1 at the root.
        mode: ``stick``, ``slip +`` or ``slip -`` (the sense of the tangential velocity),
            ``at rest``, or ``frictionless``. For a compliant contact the phase of its spring is
            written first: ``loading,``, ``unloading,`` or ``at rest,``.
        normal_force: normal force on the wire, N; None for a contact without a spring that begins
            at this instant.
        tangential_force: tangential force on the wire, N; None if ``normal_force`` is None.
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
    """State and contacts of a run at an instant, in SI units.

    The instant is the end of an interval. If an event has ended the interval, a second snapshot at
    the same time follows, with the contacts after the event.

    Attributes:
        time: time, s.
        angles: absolute angle of each link, rad.
        rates: absolute angular velocity of each link, rad/s.
        contacts: the active contacts with their forces.
        event: kind of the event that ended the interval, in words. The text is empty if no event
            ended the interval, and in the second snapshot after an event.
        events: names of the events that the trajectory has recorded since the previous snapshot.
        impacts: records of impacts, and of contacts that ended, since the previous snapshot.
        stop_reason: reason why the run stops here; None if it continues.
    """

    time: float
    angles: tuple[float, ...]
    rates: tuple[float, ...]
    contacts: tuple[ContactState, ...]
    event: str
    events: tuple[str, ...]
    impacts: tuple[ContactRecord, ...]
    stop_reason: StopReason | None

    def __str__(self) -> str:
        """Return time, contacts, event, impacts and stop reason in one line."""
        parts = [f"{1e3 * self.time:.6f} ms: {', '.join(map(str, self.contacts)) or 'no contact'}"]
        parts += [self.event] if self.event else []
        parts += [f"{each.obstacle} {each.outcome}" for each in self.impacts]
        parts += [f"stopped: {self.stop_reason}"] if self.stop_reason else []
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
    """Yield snapshots of the run of one bristle: state and contacts, interval by interval.

    :func:`bristle_sim.simulate` computes the same intervals. The first snapshot is the start of the
    run, the last one its end. Each snapshot is computed when it is requested, so the caller may
    stop after any of them.

    Args:
        tool, settings, start_hub_angle, start_relative_angle, start_relative_rate, stop_after: as
            for ``simulate``.

    Raises:
        ValueError: as for ``simulate``. Invalid input raises the error at the call. A contact law
            that cannot resolve the first contact raises the error during the run.
    """
    begin = (start_hub_angle, start_relative_angle, start_relative_rate)
    system, units, _ = prepare(tool, settings, begin, stop_after=stop_after)
    return _snapshots(system, units)


def _snapshots(system: System, units: Units) -> Iterator[Snapshot]:
    """Yield the snapshots of a prepared run."""
    recording = system.recording
    event_count = record_count = 0
    for motion, event in run(system):
        time, angles, rates = system.state
        yield Snapshot(
            time=time * units.time,
            angles=angles,
            rates=tuple([rate / units.time for rate in rates]),
            contacts=tuple([contact_state(contact, units) for contact in motion.contacts]),
            event="" if event is None else event.kind.replace("_", " "),
            events=tuple([recorded.name for recorded, _ in recording.events[event_count:]]),
            impacts=contacts_in_si(recording.contacts[record_count:], system.mechanism, 0, units),
            stop_reason=recording.stop_reason,
        )
        event_count = len(recording.events)
        record_count = len(recording.contacts)


def contact_state(contact: ActiveContact, units: Units) -> ContactState:
    """Return the state of a contact in SI units, with its last computed forces."""
    if isinstance(contact, SpringContact):
        phase = "at rest" if contact.at_rest else "loading" if contact.law.loading else "unloading"
        mode = f"{phase}, {SLIDING[contact.slip]}"
    elif contact.slip is None:
        mode = "at rest" if contact.pair.friction else "frictionless"
    else:
        mode = SLIDING[contact.slip]
    normal = contact.force
    return ContactState(
        obstacle=contact.pair.name,
        link=contact.pair.link + 1,
        mode=mode,
        normal_force=None if normal is None else normal * units.force,
        tangential_force=None if normal is None else contact.tangential * units.force,
    )
