"""Several straight rigid bristles in one plane of one hub, which touch each other, bar and workpart."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence

import numpy as np

from bristle_sim.parameters import Tool
from bristle_sim.reference.contacts import Point, Surface, obstacles_of
from bristle_sim.reference.log import LARGEST_RETRACTION, PEAK, Log
from bristle_sim.reference.mechanics import Chain
from bristle_sim.reference.row import Row
from bristle_sim.reference.run import Run
from bristle_sim.reference.simulate import FINEST, Request, check_start, note_absences, parameters, span
from bristle_sim.reference.system import Instant, Obstacles, State, System
from bristle_sim.reference.wires import Wires
from bristle_sim.trajectory import Cost, Trajectory


class RowLog(Log):
    """The logs of a row's bristles: each records the events and contacts in which its bristle takes part."""

    def __init__(self, row: Row, wires: Wires, interval: float, stop_after: str | None) -> None:
        super().__init__(row.bristles[0], interval, stop_after)
        self.logs = [Log(each, interval, None, number) for number, each in enumerate(row.bristles)]
        self.wires = wires

    def of(self, point: Point | None = None) -> Sequence[Log]:
        """Return the logs of the bristles that touch in a contact, of all without one."""
        if point is None:
            return self.logs
        return [
            self.logs[each]
            for each in (self.wires.pairs[point.piece] if point.obstacle == Wires.name else [point.piece])
        ]

    def sample(self, instant: Instant) -> None:
        """Store a state, for all bristles or for none: they share the instants."""
        forces = np.zeros((len(self.logs), 2))
        if sustained := instant.system.sustained:
            balance = instant.balance
            for each, pushes in zip(sustained, np.column_stack([balance.normal, balance.tangential]), strict=True):
                forces[[log.first for log in self.of(each.point)]] += pushes
        new = [(log.own(instant.state), (float(n), float(t))) for log, (n, t) in zip(self.logs, forces, strict=True)]
        if any(log.differs(*one) for log, one in zip(self.logs, new, strict=True)):
            for log, one in zip(self.logs, new, strict=True):
                log.samples.append(one)

    def times(self, start: float, end: float) -> list[float]:
        """Return the instants to sample after a start and before an end."""
        return sorted({time for log in self.logs for time in log.times(start, end)})

    def event(self, name: str, time: float) -> None:
        """Note an event that concerns the whole row."""
        for log in self.logs:
            log.event(name, time)

    def seen(self, name: str) -> bool:
        """Whether every bristle has had an event of that name."""
        return all(log.seen(name) for log in self.logs)


def simulate_row_reference(
    tool: Tool,
    *,
    bristles: int,
    pitch: float,
    neighbour_friction: float = 0.0,
    neighbour_restitution: float = 1.0,
    start_hub_angle: float = -0.5 * math.pi,
    hub_turn: float = 1.5 * math.pi,
    accuracy: float = 1e-10,
    stop_after: str | None = None,
    sample_interval: float | None = None,
) -> tuple[Trajectory, ...]:
    """Simulate a row of bristles that touch each other, bar and workpart.

    All start together, radial and turning with the hub, each a pitch behind the one before it. A touch of two wires obeys
    the energetic impact law with both wires' inverse mass; taps that die out become a sustained contact, which holds as long
    as it pushes, with Coulomb friction.

    Args:
        tool: hub, belt, bristle, bar and workpart; the bristle must be straight and rigid.
        bristles: at least 1.
        pitch: angle between neighbours' roots, rad.
        neighbour_friction, neighbour_restitution: Coulomb's coefficient and the energetic one between two wires.
        start_hub_angle: of the foremost bristle, rad.
        hub_turn: after which the last bristle's pass ends, from its own passage through the foremost one's start, rad.
        accuracy: relative accuracy of the motion requested.
        stop_after: name of a touch or release; the run ends when every bristle has had one.
        sample_interval: s; as for ``simulate_reference``.

    Returns:
        One trajectory for each bristle, the foremost in the sense of rotation first, at common instants. A touch of a
        neighbour is the event ``wire touch`` of both; its contact records name the obstacle ``wire``.

    Raises:
        ValueError: for settings out of range, a bristle that is not straight and rigid, wires that touch each other at the
            start, or one inside an obstacle.
    """
    wall, cpu = clock.perf_counter(), clock.process_time()
    request = Request(
        start_hub_angle,
        hub_turn=hub_turn + (bristles - 1) * pitch,
        accuracy=accuracy,
        sample_interval=sample_interval,
        stop_after=stop_after,
    )
    surface = Surface(neighbour_friction, neighbour_friction, neighbour_restitution)
    _check(tool, bristles, pitch, stop_after)
    row = Row(tool, [request.start_hub_angle - number * pitch for number in range(bristles)])
    wires, fixed = Wires(row, tool.bristle.wire_diameter, surface), obstacles_of(tool)
    for each in row.bristles:
        check_start(each, fixed, _radial([each]))
    end, interval = span(row.bristles[0], request)
    log = RowLog(row, wires, interval, stop_after)
    obstacles: Obstacles = {**fixed, Wires.name: wires} if bristles > 1 else fixed
    run = Run(System(row, obstacles), log, _radial(row.bristles), end, max(accuracy / 100.0, FINEST))
    reason = run.run()
    cost = Cost(clock.perf_counter() - wall, clock.process_time() - cpu, run.evaluations)
    shared = parameters(tool, request) | {"bristles": bristles, "pitch": pitch}
    for own in log.logs:
        note_absences(fixed, own, run.state.time)
    return tuple(each.trajectory(reason, cost, shared) for each in log.logs)


def _radial(bristles: Sequence[Chain]) -> State:
    """Return the start: radial, turning with the hub."""
    return State(
        0.0,
        np.array([float(each.start_hub_angle) for each in bristles]),
        np.full(len(bristles), bristles[0].speed),
    )


def _check(tool: Tool, bristles: int, pitch: float, stop_after: str | None) -> None:
    """Refuse bristles that are not rigid and straight, a row that does not fit the hub, and events that do not stop it."""
    if tool.bristle.links != 1 or len(tool.bristle.path) != 1:
        raise ValueError(f"wire_links = {tool.bristle.links}: must be 1, without a knee, in a row (dimensionless)")
    if bristles < 1 or bristles != int(bristles):
        raise ValueError(f"bristles = {bristles!r}: must be a whole number of at least 1 (dimensionless)")
    apart = 2.0 * tool.hub.radius * math.sin(min(pitch, math.pi) / 2.0)
    if not (apart > tool.bristle.wire_diameter and (bristles - 1) * pitch < 2.0 * math.pi - pitch):
        raise ValueError(
            f"pitch = {pitch:g}: must be one at which the roots are more than wire_diameter apart, and the row less than a"
            " turn (in rad)"
        )
    if stop_after in (PEAK, LARGEST_RETRACTION):
        raise ValueError(f"stop_after = {stop_after!r}: must be a touch or a release in a row")
