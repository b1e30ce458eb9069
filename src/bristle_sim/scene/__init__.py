"""The time-domain simulation in pymunk. Entry: ``tool.simulate``; everything runs in the scene's own units.

In reading order:

- ``tool``: ``simulate`` and its kin; a tool's parameters as a scene in engine units (``units``, ``wire_links``, ``starts``).
- ``build``: the pymunk space of a ``mechanism`` (links on a hub), whose steps and bodies ``engine`` calls bare.
- ``run``: the loop, from one change of contact to the next, with a ``plan`` and its ``progress``.
- ``motion``: one smooth motion between two changes, integrated interval by interval.
- ``decisions``: which contacts stay closed after an event; ``spring_contact``: the phases of a contact resolved in time.
- ``results``: what was recorded, in SI units.
- ``strike``, ``wire_strike``: a single contact of a chain of rods or of a wire, by the same loop.

Rooms:

- ``integrate/``: ``stepping`` (one interval), ``extrapolation`` of engine steps to the accuracy, ``time_scales``.
- ``events/``: ``functions`` and their ``table``, ``signs`` that change, the one locator (``locate``), gaps that close (``touches``).
- ``contact/``: geometry (``obstacles``, ``gaps``); impacts (``laws``); contacts that last (``sustained``): rigid ones (``rigid``,
  by the engine's ``shapes`` or, of several links, by the ``solver``) and those with a ``spring`` (``compliant``).
"""
