"""Redraws the dissertation's figures, recomputes its table 3.1, and audits its printed numbers.

The values follow from the dissertation's equations and parameters, and from simulations.

Public: ``figures.redrawn``, ``figures.figures_report``, ``audit.audit_rows`` and
``audit.audit_report``.
"""
