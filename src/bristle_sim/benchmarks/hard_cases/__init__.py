"""Hard cases: tables of what is tried and promised, measures that many of them share, and the report of what was reached."""
