"""The cost of accuracy: error against CPU time of this project's methods and of other packages on the same cases.

``cases`` has the cases with their exact answers. ``own_methods``, ``scipy_methods`` and ``peers`` (MuJoCo, Exudyn, heyoka)
list the attempts at each case. ``measure`` takes errors and times in separate passes, and ``effects`` the cost of each part of
a scene. ``study`` runs them and writes the report (``results``).
"""
