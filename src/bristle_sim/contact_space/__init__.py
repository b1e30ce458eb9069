"""Impacts in any pymunk space: inverse mass at a contact, velocities that obey joints, and EnergeticContact.

This package needs NumPy, pymunk and the impact law alone, nothing of the tool. In reading order:

- ``joints``: velocity constraints J V = b of pymunk's joints, and the nearest velocities that obey them.
- ``impulse``: the contact's inverse mass K, and the change of all velocities by an impulse.
- ``collision_rule``: two collision types, their coefficients and law; the record of an impact.
- ``touching``: how bodies moved in the last step, and the points where shapes touch, followed back to the instant of touch.
- ``rest_filter``: contacts at rest, which the engine keeps, distinguished from impacts.
- ``sequence``: impacts one after the other; ``simultaneous``: all of a group at once, where there are too many.
- ``tunnelling``: a warning where a step is so long that shapes pass each other.
- ``energetic_contact``: :class:`EnergeticContact`, the law in a user's own space.
"""
