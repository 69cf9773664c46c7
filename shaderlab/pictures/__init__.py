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
    palette,
    to_display,
)
from shaderlab.pictures.files import (
    LARGEST_SIDE,
    copy_png,
    load,
    load_library,
    reduced,
    save_png,
)
from shaderlab.pictures.previews import preview, save_previews
from shaderlab.pictures.values import WINDOW, Values, judged_part, pack

__all__ = [
    "BAND_HIGH",
    "BAND_LOW",
    "BAND_MIDDLE",
    "LARGEST_SIDE",
    "NOT_FINITE",
    "OUTSIDE",
    "UNCOVERED",
    "WINDOW",
    "Display",
    "Values",
    "copy_png",
    "distance_picture",
    "judged_part",
    "load",
    "load_library",
    "pack",
    "palette",
    "preview",
    "reduced",
    "save_png",
    "save_previews",
    "to_display",
]
