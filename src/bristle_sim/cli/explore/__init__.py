"""The bench: a page with a knob for every key of the tool, and the run that follows each change.

``entry`` starts it, ``bench`` computes a run for typed values, ``server`` answers the browser.
``render.report`` makes the page.
"""
