"""The time-domain simulation in pymunk. Entry: ``simulate.simulate``; everything runs in the scene's own units.

In reading order:

- ``simulate``: the public functions; ``tool``: a tool's parameters as a scene in engine units.
- ``build``: the pymunk space of a ``mechanism`` (links on a hub), whose steps and bodies ``engine`` calls bare.
- ``extrapolation``: engine steps extrapolated to the accuracy over an interval.
- ``run``: the loop, from one change of contact to the next, and the decision which contacts stay closed after it.
- ``motion``: one smooth motion between two changes, integrated interval by interval; ``progress``: the state of a run.
- ``spring_contact``: the phases of a contact resolved in time.
- ``results``: the recorded motion and contacts in SI units.
- ``strike``: a single contact of a chain of rods or of a wire, by the same loop.

Subpackages:

- ``events/``: the ``table`` of event functions, the one locator (``locate``), gaps that close (``touches``).
- ``contact/``: geometry (``obstacles``, ``gaps``); impacts (``laws``); contacts that last (``sustained``): rigid ones (``rigid``,
  by the engine's ``shapes`` or, of several links, by the ``solver``) and those with springs (``compliant``, ``spring``, ``course``).
"""
