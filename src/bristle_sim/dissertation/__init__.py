"""The dissertation recomputed: its figures and table 3.1 from their own data, and an audit of its
numbers.

Public: ``figures.redrawn``, ``figures.figures_report``, ``audit.audit_rows`` and
``audit.audit_report``.
"""
