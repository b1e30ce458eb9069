"""Studies: functions that answer one question each with simulations, and return a
``comparison.Report``.

Public: ``sweep.sweep``, ``design.design``, and the function of each scenario: ``whole_pass``,
``cue_timing``, ``cue_map``, ``bent_bristles``, ``inertia_driven``, ``flexible_wire``,
``neighbours``, ``force_comparison``, ``crater_study``, ``tolerances``, ``whole_tool``, and the
functions of ``impacts``.
"""
