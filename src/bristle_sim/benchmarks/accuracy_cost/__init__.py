"""What accuracy costs in time: error against CPU time for this project's methods and for other tools' on the same cases.

``cases`` says what is computed and what is exact; ``own_methods``, ``scipy_methods``, ``mujoco_methods`` and
``exudyn_methods``, ``heyoka_methods`` each offer attempts at a case; ``measure`` finds errors and times in separate passes; ``effects`` prices
every part of a scene; ``study`` runs it all and writes the report.
"""
