"""Formulas in closed form, as short functions of numbers or arrays, and the impact laws.

Public: ``impact`` (``energetic_impact``, ``poisson_impact``, ``newton_impact``), ``monofilament``,
``pendulums``, ``cueing``, ``force_history``, ``force_fit``, ``merchant``, ``crater`` and the
``crater_`` modules, ``inertia_drive``, ``wire``. Formulas of the dissertation cite its equations.
"""
