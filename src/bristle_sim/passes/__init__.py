"""Many passes of straight rigid bristles at once, computed from the equations of motion in NumPy
arrays.

A pass is the motion of one bristle past bar and workpart, up to its impact on the workpart. The
passes form three groups: bristles in flight, bristles that have just touched the bar, and bristles
that lie on the bar. The largest group is always advanced next. At a touch or a release, a bristle
changes its group.

The modules in reading order:

- ``ensemble`` contains the public function.
- ``request`` checks the values of the tools.
- ``state`` holds the passes in dimensionless numbers.
- ``motion`` computes the motion in flight as Taylor series.
- ``bar`` computes the kinematics at the bar.
- ``crossing`` finds roots.
- ``flight`` advances bristles by a step, up to a touch.
- ``touch`` resolves impacts on the bar, and advances bristles that lie on it.
- ``strike`` applies the impact law at the workpart.
- ``result`` holds the results.
"""
