"""The pass of a wire of links: intervals of smooth motion with any contacts sustained, and events between them.

scipy's DOP853 integrates an interval, with the impulses and works of sustained contacts as further unknowns; after every
step the state is projected on the closed gaps (Hairer, Lubich and Wanner, Geometric Numerical Integration, IV.4). The
interval ends at the first event: an obstacle is touched, a contact's force falls to zero, its place passes a corner of the
wire, slip stops or begins. After an event, impacts are resolved, the fastest approach first, and it is decided which of the
closed contacts stay.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from bristle_sim.arrays import Array
from bristle_sim.reference.crossing import Step, first_event, nodes, note_extremes
from bristle_sim.reference.decisions import record
from bristle_sim.reference.events import Event, Follow, events_of
from bristle_sim.reference.log import Finished, Log
from bristle_sim.reference.system import State, System
from bristle_sim.settings import StopReason


@dataclass(slots=True)
class Run:
    """One run of a system from a state up to a time, s.

    ``tolerance`` is the integrator's relative tolerance; ``most_evaluations`` of the right-hand side stop the run.
    """

    system: System
    log: Log
    state: State
    end: float
    tolerance: float
    most_evaluations: float = math.inf
    evaluations: int = 0

    def run(self) -> StopReason:
        """Run to the end and return the reason for stopping."""
        reason = StopReason.END
        wedged = False
        self._sample(self.state)
        try:
            while self.state.time < self.end:
                self.state = self._interval()(self.state)
                self._sample(self.state)
        except Finished as finished:
            reason, self.state = finished.args
            self._sample(self.state)
        except np.linalg.LinAlgError:  # more contacts than the links can keep closed
            reason = self.log.jam(self.state).args[0]
            wedged = True
        for each in self.system.sustained:
            record(
                self.system,
                self.log,
                self.state,
                each,
                "end of run" if reason is StopReason.END else str(reason),
            )
        if wedged:  # without the forces, which have no bound
            self.system.sustained = []
            self._sample(self.state)
        return reason

    def _interval(self) -> Follow:
        """Integrate to the next event; return its consequence."""
        events = events_of(self.system, self.log, self.state)
        solver = self._solver()
        while solver.status == "running":
            if self.evaluations > self.most_evaluations:
                raise Finished(StopReason.STEP_BUDGET, self.state)
            with np.errstate(over="ignore", invalid="ignore"):  # in a step that fails
                solver.step()
            if solver.status == "failed":
                # A contact that loses its lever within an instant: two wires lie flat on each other.
                raise (
                    self.log.jam(self.state)
                    if self.system.rigid
                    else Finished(StopReason.ACCURACY, self.state)
                )
            values = solver.dense_output()
            self.evaluations = self.evaluations + solver.nfev
            solver.nfev = 0
            if follow := self._follow(events, values, solver.t_old, solver.t):
                return follow
            if self.system.rigid:  # the integrator goes on from the closed gaps
                sums = solver.y[2 * self.system.chain.links :]
                solver.y = np.concatenate([self.state.angles, self.state.rates, sums])
                solver.f = solver.fun(solver.t, solver.y)
        return lambda state: state

    def _follow(
        self, events: list[Event], values: Callable[[Any], Array], start: float, end: float
    ) -> Follow | None:
        """Store the motion on a step up to its end or the first event, and return the consequence of that."""

        def motion(times: Array) -> list[State]:
            pairs = zip(times.tolist(), values(times).T, strict=True)
            return [self.system.closed(self._state(*each)) for each in pairs]

        step = Step(
            self.system,
            motion,
            [self.system.at(each) for each in motion(nodes(start, end))],
            start,
            end,
        )
        until, follow = first_event(events, step)
        extremes = [
            note_extremes(self.log, each, step._replace(end=until)) for each in self.log.records
        ]
        stop = min((each for each in extremes if each is not None), default=None)
        until = until if stop is None else stop
        *between, self.state = motion(np.array([*self.log.times(start, until), until]))
        for each in between:
            self._sample(each)
        sums = values(until)[2 * self.system.chain.links :].reshape(-1, 4)
        for contact, reached in zip(self.system.sustained, sums, strict=True):
            contact.sums = reached
        if stop is not None:
            raise Finished(StopReason.EVENT, self.state)
        if follow is not None:
            self._sample(self.state)
        return follow

    def _solver(self) -> DOP853:
        """Return an integrator that begins at the state, with an absolute tolerance for each unknown."""
        chain = self.system.chain
        size = self.system.size
        fastest = self.system.fastest
        rate = max(chain.speed, float(np.abs(self.state.rates).max()), fastest, 1e-300)
        force = chain.masses.sum() * size * rate
        work = force * size * rate
        sustained = self.system.sustained
        scale = [
            np.ones(chain.links),
            np.full(chain.links, rate),
            np.tile([force, force, work, work], len(sustained)),
        ]
        return DOP853(
            self._derivative,
            self.state.time,
            np.concatenate(
                [self.state.angles, self.state.rates, *(each.sums for each in sustained)]
            ),
            self.end,
            max_step=1.0 / fastest if fastest else np.inf,
            rtol=self.tolerance,
            atol=self.tolerance * np.concatenate(scale),
        )

    def _derivative(self, time: float, values: Array) -> Array:
        """Return the derivatives of angles and rates, and the forces and powers of the sustained contacts."""
        instant = self.system.at(self._state(time, values))
        if not instant.contacts:
            return np.concatenate([instant.state.rates, instant.balance.accelerations])
        normal, tangential = instant.balance.normal, instant.balance.tangential
        velocities = np.array([each.touch.velocity for each in instant.contacts])
        powers = normal * velocities[:, 0], tangential * velocities[:, 1]
        sums = np.column_stack([normal, tangential, *powers]).ravel()
        return np.concatenate([instant.state.rates, instant.balance.accelerations, sums])

    def _state(self, time: float, values: Array) -> State:
        """Return the state that the unknowns hold."""
        return State(time, *values[: 2 * self.system.chain.links].reshape(2, -1))

    def _sample(self, state: State) -> None:
        self.log.sample(self.system.at(state))
