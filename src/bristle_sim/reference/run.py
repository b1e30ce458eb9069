"""The main loop of a run: intervals of smooth motion with sustained contacts, and the events that
end them.

SciPy's DOP853 integrates an interval; impulses and works of sustained contacts are further
unknowns. After every step the state is projected onto the closed gaps (Hairer, Lubich and Wanner,
Geometric Numerical Integration, IV.4). The interval ends at the first event: the wire touches an
obstacle, the force of a contact falls to zero, a contact passes a corner of the wire, or slip stops
or begins. After an event the impacts are resolved, the one with the fastest approach first. Then
the program determines which of the closed contacts stay closed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import DOP853

from bristle_sim.arrays import Array
from bristle_sim.reference.crossing import crossings, nodes
from bristle_sim.reference.decisions import record
from bristle_sim.reference.events import Event, Follow, events_of
from bristle_sim.reference.forces import Compliant, State, solve
from bristle_sim.reference.log import Finished
from bristle_sim.reference.system import Instant, System
from bristle_sim.settings import StopReason

# Least angular velocity that scales the absolute tolerances, rad/s. Where nothing moves, a scale of
# 0 would make the relative error 0/0.
LEAST_RATE = 1e-300
# Least relative tolerance that SciPy accepts: 100 times the spacing of floats at 1.
LEAST_RELATIVE = 100.0 * math.ulp(1.0)


@dataclass(slots=True)
class Run:
    """One run: the integration of a system from an initial state to a given time.

    Attributes:
        system: the wires with their obstacles and contacts.
        state: present state, at first the initial one.
        end: time at which the run ends, s.
        tolerance: relative tolerance of the integrator.
        most_evaluations: number of evaluations of the equations of motion after which the run
            stops.
        evaluations: number of evaluations so far.
    """

    system: System
    state: State
    end: float
    tolerance: float
    most_evaluations: float = math.inf
    evaluations: int = 0

    def run(self) -> StopReason:
        """Integrate to the end of the run, and return the reason why the run ended."""
        system = self.system
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
            reason, self.state = system.log.jam(self.state).args
            wedged = True
        outcome = "end of run" if reason is StopReason.END else str(reason)
        record(system, self.state, system.sustained, outcome)
        if wedged:  # the last sample has no contact forces, since they have no bound
            system.sustained = []
            self._sample(self.state)
        return reason

    def _interval(self) -> Follow:
        """Integrate until the next event, and return the function that applies its consequence."""
        system = self.system
        events = events_of(system, self.state)
        solver = self._solver()
        while solver.status == "running":
            if self.evaluations > self.most_evaluations:
                raise Finished(StopReason.STEP_BUDGET, self.state)
            with np.errstate(over="ignore", invalid="ignore"):  # a step that fails may overflow
                solver.step()
            if solver.status == "failed":
                # If there are rigid contacts, two wires lie flat on each other, and a contact has
                # lost its lever.
                raise (
                    system.log.jam(self.state)
                    if system.rigid
                    else Finished(StopReason.ACCURACY, self.state)
                )
            values = solver.dense_output()
            self.evaluations += solver.nfev
            solver.nfev = 0
            event = self._advance(events, values, solver.t_old, solver.t)
            if event is not None:
                return event.follow
            if system.rigid:  # the integrator continues from the state with closed gaps
                sums = solver.y[2 * system.chain.links :]
                solver.y = np.concatenate([self.state.angles, self.state.rates, sums])
                solver.f = solver.fun(solver.t, solver.y)
        return lambda state: state

    def _advance(
        self, events: list[Event], values: Callable[[Any], Array], start: float, end: float
    ) -> Event | None:
        """Record the motion in a step of the integrator, up to the first event if there is one.

        An event function that is zero within rounding error at the start of the step counts as
        having the sign that it has before its event.

        Args:
            events: the possible events.
            values: function that returns the unknowns at an array of times (s).
            start: start of the step, s.
            end: end of the step, s.

        Returns:
            The event, or None without an event.
        """
        system = self.system

        def motion(times: Array) -> Instant:
            """Return the motion at times within the step, projected onto the closed gaps."""
            return system.at(system.closed(self._state(times, values(times).T)))

        def along(event: Event, times: Array) -> Array:
            """Return the values of an event function at times within the step."""
            return np.asarray(event.value(motion(times)))

        sampled = motion(nodes(start, end))
        until = end
        first = None
        for event in events:
            changes = crossings(
                partial(along, event),
                start,
                end,
                event.resolution,
                0 if event.extreme else -event.direction,
                event.value(sampled),
            )
            time = next((time for time, sense in changes if sense == event.direction), end)
            if time < until:
                until = time
                first = event
        times = np.array([*system.log.times(start, until), until])
        course = motion(times)
        states = [State(*each) for each in zip(times.tolist(), *course.state[1:], strict=True)]
        for state, pushes in zip(states[:-1], course.balance.pushes[:-1], strict=True):
            self._sample(state, pushes)
        self.state = states[-1]
        sums = values(until)[2 * system.chain.links :].reshape(-1, 4)
        for contact, reached in zip(system.sustained, sums, strict=True):
            contact.sums = reached
        if first is not None:
            self._sample(self.state)
        return first

    def _solver(self) -> DOP853:
        """Return an integrator that starts at the present state.

        The absolute tolerance of each unknown is the relative tolerance times a bound of that
        unknown. During a contact with springs, an error of an angle causes an error of the angular
        velocity: the error of the angle times the angular frequency of the motion on the springs.
        The tolerance of the angle is reduced until this error does not exceed the tolerance of the
        angular velocity.
        """
        chain = self.system.chain
        size = self.system.size
        fastest = self.system.fastest
        sustained = self.system.sustained
        rate = max(chain.speed, float(np.abs(self.state.rates).max()), fastest, LEAST_RATE)
        force = chain.masses.sum() * size * rate
        work = force * size * rate
        instant = self.system.at(self.state)
        frequency = rate
        for each in sustained:
            if isinstance(each, Compliant):
                rows = instant.touch(each.point).rows
                inverse_mass = float(np.trace(rows @ solve(instant.mass, rows.T)))
                frequency = max(frequency, math.sqrt(each.steepest * inverse_mass))
        scale = [
            np.full(chain.links, rate / frequency),
            np.full(chain.links, rate),
            np.tile([force, force, work, work], len(sustained)),
        ]
        sums = [each.sums for each in sustained]
        relative = np.full(2 * chain.links + 4 * len(sustained), self.tolerance)
        relative[: chain.links] *= rate / frequency
        return DOP853(
            self._derivative,
            self.state.time,
            np.concatenate([self.state.angles, self.state.rates, *sums]),
            self.end,
            max_step=1.0 / fastest if fastest else np.inf,
            rtol=np.maximum(relative, LEAST_RELATIVE),
            atol=self.tolerance * np.concatenate(scale),
        )

    def _derivative(self, time: float, values: Array) -> Array:
        """Return the time derivatives of all unknowns of the integration.

        The unknowns are the angles and angular velocities of the links, then the impulses and works
        of the sustained contacts. The derivatives of impulses and works are forces and powers.
        """
        instant = self.system.at(self._state(time, values))
        accelerations, pushes = instant.balance
        sums = [
            np.concatenate([push, push * each.touch.velocity])
            for push, each in zip(pushes, instant.contacts, strict=True)
        ]
        return np.concatenate([instant.state.rates, accelerations, *sums])

    def _state(self, time: Any, values: Array) -> State:
        """Return the state of the links from the unknowns at one or several times (s).

        ``values`` has the shape (..., unknowns).
        """
        links = self.system.chain.links
        return State(time, values[..., :links], values[..., links : 2 * links])

    def _sample(self, state: State, pushes: Array | None = None) -> None:
        """Record a state and the forces ``pushes`` of the sustained contacts, N.

        Forces that are not given are computed.
        """
        system = self.system
        points = [each.point for each in system.sustained]
        if pushes is None:
            pushes = system.at(state).balance.pushes
        system.log.sample(state, zip(points, pushes, strict=True))
