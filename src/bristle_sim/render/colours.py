"""Colours of all pictures, distinguishable to the colour-blind, and their order for curves."""

BLACK = "#1a1a1a"
GREY = "#6b6b6b"
LIGHT = "#e4e4e4"
BLUE = "#0072b2"
ORANGE = "#e69f00"
GREEN = "#009e73"
VERMILION = "#d55e00"
PURPLE = "#b8578e"
SKY = "#56b4e9"
OUTCOMES = {
    "rebounds": BLUE,
    "reverses its slip": GREEN,
    "sticks and rebounds": ORANGE,
    "stays": PURPLE,
    "jams": VERMILION,
    "does not strike": GREY,
    "refused": LIGHT,
}
"""Colour of each outcome, as worded in sentences, on pages and maps."""

SERIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
