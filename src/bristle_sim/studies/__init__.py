"""Questions about one run or many, each answered by a function that returns a ``comparison.Report``.

Public: ``sweep.sweep``, and the function of each scenario: ``whole_pass``, ``cue_timing``, ``cue_map``, ``bent_bristles``,
``inertia_driven``, ``flexible_wire``, ``neighbours``, ``force_comparison``, ``crater_study``, ``tolerances``,
``whole_tool``, and those of ``impacts``.
"""
