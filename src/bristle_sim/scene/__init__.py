"""The time-domain simulation in pymunk. Entry: ``simulate.simulate``; everything runs in the scene's own units.

In reading order; a file imports only from files below it in this list:

- ``snapshots``: a run interval by interval.
- ``simulate``: the public functions; ``strike``: a single contact of a chain of rods or of a wire, by the same loop.
- ``tool``: a tool's parameters as a scene in engine units; ``results``: the recorded motion and contacts in SI units.
- ``run``: the loop over intervals and events.
- ``decide``: the decision after an event; ``collisions``, ``spring_phases``: its impacts, with the error over them, and its springs.
- ``motion``: one smooth motion, integrated interval by interval up to its first event.
- ``events``: events, their kinds, and those of a motion; ``touches``: gaps that close; ``locate``: the locator and its root finder.
- ``system``: the state, the plan and the record of a run.
- ``impacts``, ``compliant``: the contact laws.
- ``contact``: a contact that lasts; ``rigid``, ``spring``: its two kinds.
- ``extrapolation``: engine steps extrapolated over an interval; ``interval``: its result, and the load that contacts put on it.
- ``build``: the pymunk space of a mechanism.
- ``solver``: joints and contacts of several links; ``link_solver``: of a single one.
- ``gaps``, ``pairs``: the geometry of pairs that can touch; ``engine``: bare calls of the engine.
- ``mechanism``: chains of links.
"""
