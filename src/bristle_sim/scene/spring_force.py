"""The forces of contacts with springs on the bodies of the engine, step by step.

The force law is that of :mod:`bristle_sim.theory.contact_spring`. A contact that is rigid along the
surface has no tangential spring. Its tangential force in stick, -(K_nt N + v_t/h)/K_tt, stops the
contact point within one engine step of length h. N is the normal force, v_t the slip velocity, and
K the contact-space inverse mass matrix.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from pymunk._chipmunk_cffi import lib

from bristle_sim.scene.build import Scene
from bristle_sim.scene.extrapolation import Load
from bristle_sim.scene.impacts import contact_at
from bristle_sim.scene.mechanism import State, xy
from bristle_sim.scene.spring import SpringContact


class SpringForce:
    """The force of a contact's springs on the tip or knee of a link, with its impulse and work.

    The tangential force T in stick cancels, in each step of length h, the slip velocity that
    remains from the previous step. In slip at rest T cancels the normal velocity v_n instead:
    T = -(K_nn N + v_n/h)/K_nt, with the normal force N and the contact-space inverse mass matrix K.
    The force of a step is therefore that at the end of the previous step. The force of the second
    step is taken for that at the interval's beginning, and the force of a further step for that at
    its end. The errors of both forces are power series in h, so extrapolation removes them.

    Attributes:
        totals: function that returns the contact's forces, impulses and work, in the order of
            ``Sums``.
    """

    def __init__(self, scene: Scene, spring: SpringContact) -> None:
        pair = spring.pair
        body = scene.links[pair.link]._body
        link = scene.mechanism.links[pair.link]
        self._spring = spring
        corner = xy(link.corners[pair.corner] - link.centre)
        self._push = partial(lib.cpBodyApplyForceAtWorldPoint, body)
        self._place = partial(lib.cpBodyLocalToWorld, body, corner)
        self._velocity = partial(lib.cpBodyGetVelocityAtLocalPoint, body, corner)
        self.totals: Callable[[], list[float]] = list

    def begin(self, step: float) -> Callable[[], None]:
        """Set impulse and work to zero, and return the function that applies the force.

        The integrator calls this function before each step; ``step`` is the length of a step. The
        force is that of the present phase.
        """
        spring = self._spring
        push = self._push
        place_of = self._place
        velocity_of = self._velocity
        law = spring.law
        stiffness = law.stiffness * law.steepness
        height = spring.surface - law.residual - spring.pair.depth - spring.pair.dent
        foot = spring.foot
        ratio = -law.coefficient * spring.slip
        stop_slip = stop_normal = rigidity = 0.0
        if spring.elastic and not spring.slip:
            rigidity = law.stiffness / law.compliance
        normal_gain, coupling = spring.inverse_mass[0]
        if spring.at_rest:
            ratio = -normal_gain / coupling
            stop_normal = 1.0 / (coupling * step)
        elif not (spring.slip or rigidity) and (tangential := spring.compliance_in_stick):
            ratio = -coupling / tangential
            stop_slip = 1.0 / (tangential * step)
        pushes = loss = heat = 0.0
        rubs: list[float] = []

        def act() -> None:
            """Apply the force of one step, and add its impulse and work to the sums."""
            nonlocal pushes, loss, heat
            place = place_of()
            velocity = velocity_of()
            x = place.x
            y = place.y
            u = velocity.x
            v = velocity.y
            normal = stiffness * (height - y)
            along = ratio * normal - stop_slip * u - stop_normal * v - rigidity * (x - foot)
            push((along, normal), (x, y))
            pushes += normal
            loss += normal * v
            heat += along * u
            rubs.append(along)

        def read() -> list[float]:
            """Return the contact's forces, impulses and work, in the order of ``Sums``."""
            place = place_of()
            velocity = velocity_of()
            normal = stiffness * (height - place.y)
            along = ratio * normal - stop_slip * velocity.x - stop_normal * velocity.y
            along -= rigidity * (place.x - foot)
            impulse = (step * pushes, step * sum(rubs))
            return [normal, along, *impulse, step * loss, step * heat, [*rubs, along][1]]

        self.totals = read
        return act


class ContactLoad:
    """The forces of all contacts with springs, and of rigid contacts that act at the same time.

    In the list of totals the rigid contacts come first.
    """

    symmetric = False  # springs act differently forwards and backwards in time

    def __init__(self, scene: Scene, rigid: Load | None, springs: Sequence[SpringContact]) -> None:
        self._rigid = rigid
        self._parts: list[Load | SpringForce] = [] if rigid is None else [rigid]
        self._parts += [SpringForce(scene, spring) for spring in springs]

    def begin(self, step: float, *, symmetric: bool = False) -> Callable[[], None]:
        """Set impulses and work to zero, and return the function that applies the forces.

        The integrator calls this function before each step; ``step`` is the length of a step.
        ``symmetric`` must be False, because with springs no step is symmetric in time.
        """
        assert not symmetric
        begun = [each.begin(step) for each in self._parts]
        calls = [call for call in begun if call is not None]

        def act() -> None:
            """Apply the forces of all contacts."""
            for each in calls:
                each()

        return act

    def totals(self) -> list[float]:
        """Return the forces, impulses and work of all contacts in one list, after the last step."""
        return [number for each in self._parts for number in each.totals()]

    def fails(self, totals: Sequence[float]) -> bool:
        """Return whether a rigid contact would have to pull to stay closed."""
        return self._rigid is not None and self._rigid.fails(totals)


def follow_bodies(scene: Scene, state: State, spring: SpringContact) -> None:
    """Update the inverse mass matrix of a contact with a spring from the bodies' positions.

    It is updated in stick and in slip at rest only, since the tangential force depends on it there.
    """
    if spring.at_rest or not spring.slip:
        spring.inverse_mass = contact_at(scene.mechanism, state, spring.pair).inverse_mass
