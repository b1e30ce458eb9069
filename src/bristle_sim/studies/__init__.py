"""Questions about one run or many; each is answered by a function that returns a
``comparison.Report``.

Public: ``sweep.sweep``, ``design.design``, and the function of each scenario: ``whole_pass``,
``cue_timing``, ``cue_map``, ``bent_bristles``, ``inertia_driven``, ``flexible_wire``,
``neighbours``, ``force_comparison``, ``crater_study``, ``tolerances``, ``whole_tool``, and the
functions of ``impacts``.
"""
