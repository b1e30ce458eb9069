"""The dissertation recomputed: its figures and table 3.1 with their own data, and an audit of its printed numbers."""
