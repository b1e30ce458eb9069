"""Impact laws in anybody's pymunk space: the engine finds the contacts, impacts are resolved by a law, rest by the engine.

Chipmunk restores a fraction of the approach velocity (Newton's restitution) and iterates Coulomb friction; where bodies are
joined, that can create energy. Here the engine still finds the contacts and solves the joints, but a contact that
approaches takes the impulse of an impact law, Stronge's by default, on all bodies that joints connect to it, at once.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import pymunk

from bristle_sim.contact_space.contact_pair import ContactPair, LocatedImpact, refusal
from bristle_sim.contact_space.rest_filter import RestFilter
from bristle_sim.contact_space.sequence import ImpactSequence
from bristle_sim.contact_space.touching import TouchingPoint
from bristle_sim.theory.checks import checked_numbers
from bristle_sim.theory.impact import Impact, energetic_impact


class EnergeticContact:
    """Energetic restitution and Coulomb friction between collision types of a space.

    Args:
        space: the space, in its own units. It takes one EnergeticContact, with any number of pairs.
        collision_type_a, collision_type_b: of the shapes of the first pair.
        friction: Coulomb's mu, >= 0.
        restitution: energetic coefficient e*, in [0, 1].
        restitution_friction: mu in restitution; equal to ``friction`` by default.
        tangential_compliance: eta^2 of a contact that is elastic along the surface, as in ``energetic_impact``; impacts
            that are too many for one after the other are resolved without it.
        resting_speed: slower approach is left to the engine's contact with ``friction`` and no restitution, so that
            bodies rest; so is approach slower than gravity makes up in two steps.
        report: called with a :class:`~bristle_sim.contact_space.contact_pair.LocatedImpact` for each faster impact.

    Raises:
        ValueError: for coefficients out of range, for anything but a space and collision types, and if the space has an
            EnergeticContact already.

    Step the space with :meth:`step`, always by the same duration, as the engine's solver wants it; ``space.step`` leaves
    contacts to the engine. An impact acts at the instant of touch within the step. Several impacts of bodies that touch each
    other are resolved one after the other, the earliest and of those the fastest first; all at once after ``sequence.MOST``
    of them. A copied or unpickled space has an EnergeticContact without ``report``, which :meth:`of` returns.

    Energy: just before an impact all bodies that take part get the nearest velocities at which the joints do not open,
    which costs energy, if any; the impact itself changes the energy by the works of its record, a sum that is never positive
    for ``energetic_impact`` (moving kinematic bodies, motors and surface velocities do work of their own). The engine is not
    bound to this between impacts: it solves joints in iterations, gives extra velocity to correct their
    positions (``error_bias``; none at 1), and moves overlapping bodies apart (``collision_bias``). Its velocities are those
    half a step later than its positions.

    Joints of any kind take part by their Jacobian, at limits if they push throughout the impact; springs, joints with a
    finite ``max_force`` and joints outside the space do not. Sensors, filters and ``process_collision`` are respected. Users'
    callbacks on the same types are kept: a ``pre_solve`` of theirs is called first, whether registered before or after. One
    that they register for any type (with None) is called by the engine after ours: its friction and restitution count.
    """

    def __init__(
        self,
        space: pymunk.Space,
        collision_type_a: int,
        collision_type_b: int,
        *,
        friction: float,
        restitution: float,
        restitution_friction: float | None = None,
        tangential_compliance: float = 0.0,
        resting_speed: float = 0.0,
        report: Callable[[LocatedImpact], None] | None = None,
    ) -> None:
        if not isinstance(space, pymunk.Space):
            raise refusal("space", space, "must be a pymunk.Space")
        if not (report is None or callable(report)):
            raise refusal("report", report, "must be None or a function of one LocatedImpact")
        if self.of(space) is not None:
            raise ValueError("space: has an EnergeticContact already; take its add_pair for further collision types")
        self.space = space
        (self.resting_speed,) = checked_numbers(resting_speed=resting_speed)
        self.report = report
        self.time = 0.0
        self.pairs: dict[frozenset[int], ContactPair] = {}
        self._callbacks: list[tuple[Any, Any, ContactPair]] = []
        self._filter: RestFilter | None = None
        self.add_pair(
            collision_type_a,
            collision_type_b,
            friction=friction,
            restitution=restitution,
            restitution_friction=restitution_friction,
            tangential_compliance=tangential_compliance,
        )

    def add_pair(
        self,
        collision_type_a: int,
        collision_type_b: int,
        *,
        friction: float,
        restitution: float,
        restitution_friction: float | None = None,
        tangential_compliance: float = 0.0,
        law: Callable[..., Impact] = energetic_impact,
    ) -> None:
        """Take contacts between two more collision types, with coefficients and a law of their own.

        Args:
            collision_type_a, collision_type_b: of the shapes; they may be equal.
            friction, restitution, restitution_friction, tangential_compliance: as for the class, as ``law`` understands them.
            law: called like :func:`~bristle_sim.theory.impact.energetic_impact`, with ``stick_compliance`` if it takes it, and
                with ``tangential_compliance`` unless it is 0.

        Raises:
            ValueError: as the class, and for a pair that is there already.
        """
        types = {"collision_type_a": collision_type_a, "collision_type_b": collision_type_b}
        pair = ContactPair(types, friction, restitution, restitution_friction, tangential_compliance, law)
        if pair.types in self.pairs:
            given = (collision_type_a, collision_type_b)
            raise ValueError(f"collision_type_a, collision_type_b = {given}: must be a pair that is not added yet")
        self.pairs[pair.types] = pair
        self.space.on_collision(collision_type_a, collision_type_b)
        handler = _handlers(self.space)[collision_type_a, collision_type_b]
        handler.data.setdefault("pre_solve", None)
        callback = functools.partial(self._notice, pair)
        pair.chained, handler.pre_solve = handler.pre_solve, callback
        self._callbacks.append((handler, callback, pair))

    def step(self, duration: float) -> None:
        """Advance the space by one step and resolve the impacts in it.

        Raises:
            ValueError: for a duration that is negative or not finite.
        """
        if type(duration) is not float or not 0.0 <= duration <= 1.0:
            (duration,) = checked_numbers(duration=duration)
        rest = self._attached()
        rest.begin(self.resting_speed)
        try:
            self.space.step(duration)
        finally:
            rest.end()
        self.time += duration
        if rest.met:
            try:
                if rest.skipped:
                    self._resolve(rest, duration)
            finally:
                rest.clear()

    def _resolve(self, rest: RestFilter, duration: float) -> None:
        rest.motion.finish(duration)
        sequence = ImpactSequence(rest, self._record)
        sequence.resolve()
        rest.jammed |= sequence.jammed
        for body in sequence.struck:
            self.space.reindex_shapes_for_body(body)

    def _record(self, point: TouchingPoint, impact: Impact) -> None:
        if self.report is not None:
            self.report(point.located(impact, self.time))

    @staticmethod
    def of(space: pymunk.Space) -> EnergeticContact | None:
        """Return the EnergeticContact that a space has, such as that of a copy; None if there is none."""
        owners = (_owner(each.pre_solve) for each in _handlers(space).values())
        return next((each for each in owners if isinstance(each, EnergeticContact)), None)

    def detach(self) -> None:
        """Give all contacts back to the engine, and the users' callbacks their place: the space is as without this object."""
        self._attached()
        for handler, callback, pair in self._callbacks:
            if handler.pre_solve is callback:
                handler.pre_solve = pair.chained
        self._callbacks.clear()
        self.pairs.clear()

    def __getstate__(self) -> dict[str, Any]:
        """Return the state of a copy: everything but the function that takes reports."""
        jammed = set() if self._filter is None else self._filter.jammed
        return {**self.__dict__, "report": None, "_callbacks": [], "_filter": None, "_jammed": jammed}

    def _attached(self) -> RestFilter:
        """Return the filter that looks at the contacts first, before users' callbacks that are newer than ours."""
        if self._filter is None:
            self._filter = RestFilter(self.space)
            self._filter.jammed |= self.__dict__.pop("_jammed", set())
            ours = [each for each in _handlers(self.space).values() if _owner(each.pre_solve) is self]
            self._callbacks = [(each, each.pre_solve, each.pre_solve.args[0]) for each in ours]
        for handler, callback, pair in self._callbacks:
            if handler.pre_solve is not callback:
                pair.chained, handler.pre_solve = handler.pre_solve, callback
        return self._filter

    def _notice(self, pair: ContactPair, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        """Leave a contact at rest to the engine; keep the engine from responding to one that approaches."""
        try:
            if pair.chained is not None:
                pair.chained(arbiter, space, data)
        finally:
            if self._filter is not None:
                self._filter.divide(pair, arbiter)


def _handlers(space: pymunk.Space) -> dict[Any, Any]:
    """Return the space's collision handlers by types: pymunk 7 has no public way to ask who listens already."""
    return space._handlers


def _owner(callback: Any) -> object:
    function = getattr(callback, "func", None)
    return getattr(function, "__self__", None)
