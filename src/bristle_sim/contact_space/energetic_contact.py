"""Impacts in any pymunk space: an impact law replaces the engine's own restitution and friction.

The engine, Chipmunk, restores a fraction of the approach velocity (Newton's restitution) and
iterates Coulomb friction. Where bodies are joined, this can create energy. Here the engine still
finds the contacts, solves the joints and keeps resting contacts at rest. An approaching contact
gets the impulse of an impact law, Stronge's by default. The impulse acts simultaneously on all
bodies that joints connect.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import pymunk

from bristle_sim.contact_space.collision_rule import CollisionRule, LocatedImpact
from bristle_sim.contact_space.rest_filter import RestFilter
from bristle_sim.contact_space.sequence import ImpactSequence
from bristle_sim.contact_space.tunnelling import TunnellingWatch
from bristle_sim.theory.impact import Impact, energetic_impact
from bristle_sim.theory.numbers import checked_numbers
from bristle_sim.units import shown


class EnergeticContact:
    """Energetic restitution and Coulomb friction between collision types of a space.

    Args:
        space: the pymunk space, in its own units. A space can have one EnergeticContact, with any
            number of pairs of collision types.
        collision_type_a, collision_type_b: collision types of the shapes of the first pair.
        friction: Coulomb's coefficient of friction, >= 0.
        restitution: energetic coefficient of restitution, in [0, 1].
        restitution_friction: coefficient of friction in restitution; equal to ``friction`` by
            default.
        tangential_compliance: ratio of the normal to the tangential contact stiffness, as in
            ``energetic_impact``. Impacts that are resolved simultaneously ignore it.
        resting_speed: approach speed up to which a contact counts as at rest. The engine resolves
            contacts at rest, with ``friction`` and without restitution. If gravity adds a greater
            speed in two steps, that speed is the bound instead.
        report: function that is called with a
            :class:`~bristle_sim.contact_space.collision_rule.LocatedImpact` for each impact that is
            faster than a contact at rest.

    Raises:
        ValueError: for coefficients out of range, for arguments that are not a space and collision
            types, and if the space has an EnergeticContact already.

    Call :meth:`step` instead of ``space.step``, always with the same duration. ``space.step`` alone
    applies no impact law. The impacts in a step are resolved one by one at the instants of touch,
    the earliest first. Of impacts at the same instant the fastest is resolved first. Bodies that
    contacts and joints connect form a group. After 12 impacts at one point in a step
    (``sequence.COLLAPSE``), or 40 impacts in a group (``sequence.MOST``), all contacts of the group
    are resolved simultaneously.

    A copied or unpickled space has its own EnergeticContact, which :meth:`of` returns. The copy's
    ``report`` is None. Threads may step different spaces at the same time; Chipmunk does not permit
    two threads in one space.

    Just before an impact, the velocities are changed as little as possible so that they obey the
    joints. Neither this change nor the impact increases the energy, except by the work of moving
    kinematic bodies, motors and surface velocities. Between impacts the engine may gain energy: it
    solves joints iteratively, and it corrects position errors by additional velocities. With
    ``error_bias`` and ``collision_bias`` equal to 1 the engine does not correct positions.

    Every kind of joint transmits the impulse of an impact. A joint at a limit transmits it only if
    the limit pushes. Springs, joints with a finite ``max_force`` and joints outside the space
    transmit no impulse. A user's ``pre_solve`` callback for the same two types is called before
    this class reads the contact, a ``pre_solve`` callback for any type (None) afterwards.
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
            raise ValueError(f"space = {shown(space)}: must be a pymunk.Space")
        if not (report is None or callable(report)):
            raise ValueError(
                f"report = {shown(report)}: must be None or a function of one LocatedImpact"
            )
        if self.of(space) is not None:
            raise ValueError(
                "space: has an EnergeticContact already; use its add_pair for further collision types"
            )
        (self.resting_speed,) = checked_numbers(resting_speed=resting_speed)
        self.space = space
        self.report = report
        self.time = 0.0
        self.pairs: dict[tuple[int, int], CollisionRule] = {}
        self._filter = RestFilter(space)
        self._tunnelling = TunnellingWatch()
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
        """Apply an impact law to another pair of collision types, with its own coefficients.

        Args:
            collision_type_a, collision_type_b: collision types of the shapes; they may be equal.
            friction, restitution, restitution_friction, tangential_compliance: coefficients that
                are passed to ``law``, with the same meaning as the arguments of the class.
            law: function that returns the impact; it has the arguments of
                :func:`~bristle_sim.theory.impact.energetic_impact`.

        Raises:
            ValueError: for coefficients out of range, and for a pair that has been added already.
        """
        given = (collision_type_a, collision_type_b)
        pair = CollisionRule(
            given, friction, restitution, restitution_friction, tangential_compliance, law
        )
        if given in self.pairs or given[::-1] in self.pairs:
            raise ValueError(
                f"collision_type_a, collision_type_b = {given}: must be a pair that is not added yet"
            )
        self.pairs[given] = pair
        self.space.on_collision(*given)
        self._attach()

    def step(self, duration: float) -> None:
        """Advance the space by one step of ``duration`` >= 0, and resolve the impacts in the step.

        Warns:
            RuntimeWarning: once, if a body moves so far in a step that it passes through a shape
                with which it should collide. The warning states a step that is short enough. While
                no body moves by more than the width of the narrowest shape in a step, speeds are
                read only in every 16th step. A body that becomes fast may then be noticed up to 15
                steps later.
        """
        if type(duration) is not float or not 0.0 <= duration <= 1.0:
            (duration,) = checked_numbers(duration=duration)
        self._attach()
        if not self._tunnelling.warned:
            self._tunnelling.watch(self.space, self.pairs, duration)
        contacts = self._filter
        contacts.begin(self.resting_speed)
        try:
            self.space.step(duration)
        finally:
            contacts.end()
        self.time += duration
        if not contacts.impacts:
            contacts.at_rest.clear()
            return
        try:
            contacts.motion.finish(duration)
            sequence = ImpactSequence(contacts, self.report, self.time)
            sequence.resolve()
            for body in sequence.struck:
                self.space.reindex_shapes_for_body(body)
        finally:
            contacts.clear()

    @staticmethod
    def of(space: pymunk.Space) -> EnergeticContact | None:
        """Return the EnergeticContact of a space; None for a space without an EnergeticContact.

        For a copied space this is the copy's own EnergeticContact.
        """
        owners = (_owner(each.pre_solve) for each in space._handlers.values())
        return next((each for each in owners if isinstance(each, EnergeticContact)), None)

    def detach(self) -> None:
        """Remove all pairs and restore the users' callbacks; the engine then resolves impacts."""
        self._attach()
        for types, pair in self.pairs.items():
            self.space._handlers[types].pre_solve = pair.chained
        self.pairs.clear()

    def __getstate__(self) -> dict[str, Any]:
        """Return the attributes for a copy or a pickle, with None in place of ``report``."""
        return {**self.__dict__, "report": None}

    def _attach(self) -> None:
        """Register this object's ``pre_solve`` callback for every pair of collision types.

        If the user has registered another callback for the pair since the last call, that callback
        is stored as ``chained`` and called first.
        """
        for types, pair in self.pairs.items():
            handler = self.space._handlers[types]
            if _owner(handler.pre_solve) is not self:
                handler.data.setdefault("pre_solve", None)
                pair.chained = handler.pre_solve
                handler.pre_solve = functools.partial(self._notice, pair)

    def _notice(
        self, pair: CollisionRule, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any
    ) -> None:
        """Call the user's callback for a contact, then classify the contact.

        The engine resolves a contact at rest. An impact is recorded, and the engine ignores it.
        """
        try:
            if pair.chained is not None:
                pair.chained(arbiter, space, data)
        finally:
            self._filter.filter_impact(pair, arbiter)


def _owner(callback: Any) -> object:
    return getattr(getattr(callback, "func", None), "__self__", None)
