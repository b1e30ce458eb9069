"""The time-domain simulation in pymunk, in engine units.

The public functions are in ``simulate``. The modules in reading order; each imports only from
modules below it in this list:

- ``snapshots``: the state and the contacts of a run after each interval.
- ``simulate``: the public functions; ``strike``: a single contact of a chain of rods or of a wire.
- ``tool``: a tool's parameters as a scene in engine units; ``results``: the recorded motion and
  contacts in SI units.
- ``run``: the loop over intervals and events, and the decision after an event; ``collisions``:
  impacts, and the growth of the run's error in them; ``spring_phases``: the phases of a contact
  with a spring.
- ``touches``: the first event of an interval, and gaps that close.
- ``motion``: a smooth motion, integrated interval by interval.
- ``locate``: the search for the instant of an event, by a root finder; ``events``: the kinds of
  events, and the functions whose sign changes mark them.
- ``system``: the state, the plan and the record of a run.
- ``compliant``: the law of contacts with springs; ``spring``: such a contact, and its forces on the
  bodies.
- ``extrapolation``: the integrator, which extrapolates engine steps to zero step length.
- ``contact``: sustained contacts, and the forces of rigid contacts.
- ``impacts``: the response of a contact point to an impulse, and the impact laws.
- ``build``: the pymunk space of a mechanism, and the engine's steps.
- ``solver``: joint and contact forces.
- ``pairs``: the geometry of a link and an obstacle that can touch.
- ``mechanism``: chains of links.
"""
