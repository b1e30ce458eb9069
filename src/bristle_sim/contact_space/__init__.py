"""Impacts in any pymunk space: inverse mass at a contact, velocities that obey joints, and
EnergeticContact.

The package needs NumPy, SciPy, pymunk and the impact law alone, and nothing of the tool. Modules in
reading order:

- ``joints``: velocity constraints J V = b of pymunk's joints, and the nearest velocities that obey
  them.
- ``impulse``: the contact's inverse mass K, and the change of all velocities by an impulse.
- ``collision_rule``: two collision types with their coefficients and law; the record of an impact.
- ``touching``: motion of bodies in the last step, and contact points, traced back to the instant of
  touch.
- ``rest_filter``: contacts at rest, which the engine keeps, distinguished from impacts.
- ``sequence``: impacts one after the other.
- ``simultaneous``: all impacts of a group at once, if there are too many for a sequence.
- ``tunnelling``: a warning if a step is so long that shapes pass each other.
- ``energetic_contact``: :class:`EnergeticContact`, the impact law in a user's own space.
"""
