"""Arrays as pictures for people, and image files as arrays.

Arrays are in OpenGL's order: row 0 is the lowest, shape (height, width, channels).
OpenImageIO is loaded when a function needs it, not before.
"""

from shaderlab.pictures.display import (
    BAND_HIGH,
    BAND_LOW,
    BAND_MIDDLE,
    NOT_FINITE,
    OUTSIDE,
    UNCOVERED,
    Display,
    distance_picture,
    to_display,
)
from shaderlab.pictures.files import LARGEST_SIDE, load, save_png, thumbnail

__all__ = [
    "BAND_HIGH",
    "BAND_LOW",
    "BAND_MIDDLE",
    "LARGEST_SIDE",
    "NOT_FINITE",
    "OUTSIDE",
    "UNCOVERED",
    "Display",
    "distance_picture",
    "load",
    "save_png",
    "thumbnail",
    "to_display",
]
