"""Colours that all pictures share: black and greys, six that differ also to the colour-blind, and their order in series."""

BLACK, GREY, LIGHT = "#1a1a1a", "#6b6b6b", "#e4e4e4"
BLUE, ORANGE, GREEN, VERMILION = "#0072b2", "#e69f00", "#009e73", "#d55e00"
PURPLE, SKY = "#b8578e", "#56b4e9"
SERIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
