"""Many passes of straight rigid bristles at once, from the equations of motion alone, in NumPy arrays.

In reading order: ``ensemble`` (the entry), ``request`` (the tools), ``state`` (their numbers without dimension), ``motion``
(flight), ``bar`` (kinematics at the bar), ``crossing`` (roots), ``flight`` (a step up to a touch), ``slide`` (on the bar),
``run`` (a step and its consequences), ``strike`` (the law and the outcome), ``result``.
"""
