"""Many passes of straight rigid bristles at once, computed from the equations of motion in NumPy
arrays.

The passes form three groups: bristles in flight, bristles that touch the bar, and bristles that lie
on it. The largest group is always advanced next. A pass changes its group at a touch and at a
release.

Modules in reading order: ``ensemble`` (the public function), ``request`` (the tools), ``state``
(their dimensionless numbers), ``motion`` (flight), ``bar`` (kinematics at the bar), ``crossing``
(roots), ``flight`` (a step up to a touch), ``touch`` (impact on the bar and motion on it),
``strike`` (impact law and outcome), ``result``.
"""
