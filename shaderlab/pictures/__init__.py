"""Arrays as pictures for people, and image files as arrays.

Arrays are in OpenGL's order: row 0 is the lowest, shape (height, width, channels).
OpenImageIO is loaded when a function needs it, not before.
"""

from shaderlab.pictures.display import (
    BAND_HIGH as BAND_HIGH,
    BAND_LOW as BAND_LOW,
    BAND_MIDDLE as BAND_MIDDLE,
    NOT_FINITE as NOT_FINITE,
    OUTSIDE as OUTSIDE,
    UNCOVERED as UNCOVERED,
    Display as Display,
    distance_picture as distance_picture,
    to_display as to_display,
)
from shaderlab.pictures.files import (
    LARGEST_SIDE as LARGEST_SIDE,
    coarse as coarse,
    load as load,
    save_png as save_png,
)
from shaderlab.pictures.packing import repacked as repacked
from shaderlab.pictures.png import SIGNATURE as SIGNATURE
from shaderlab.pictures.previews import preview as preview, save_preview as save_preview
from shaderlab.pictures.values import (
    WINDOW as WINDOW,
    Values as Values,
    judged_part as judged_part,
    pack as pack,
)
from shaderlab.pictures.viridis import VIRIDIS as VIRIDIS
