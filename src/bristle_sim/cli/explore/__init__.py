"""The bench: an interactive page in the browser that shows the pass of a tool.

Each parameter of the tool has a control, and each change starts a new simulation. ``entry`` starts
the bench, ``bench`` simulates a pass for the typed values, ``server`` answers the browser.
``render.report`` makes the page.
"""
