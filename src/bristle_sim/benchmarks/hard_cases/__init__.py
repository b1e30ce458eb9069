"""Hard cases by theme: what each promises, and what was reached.

A module a theme, each with ``cases(full)``: its cases, all of them or those that take a second or two together.
``tests/stability`` holds every one to its promise; ``scenarios/hard_cases.py`` prints what was reached.
"""
