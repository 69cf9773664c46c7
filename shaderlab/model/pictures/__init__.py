"""Arrays as pictures for people, and image files as arrays.

Arrays are in OpenGL's order: row 0 is the lowest, shape (height, width, channels).
"""

from .display import (
    BAND_HIGH as BAND_HIGH,
    BAND_LOW as BAND_LOW,
    BAND_MIDDLE as BAND_MIDDLE,
    CHECK as CHECK,
    MAGNITUDES as MAGNITUDES,
    NOT_FINITE as NOT_FINITE,
    OUTSIDE as OUTSIDE,
    UNCOVERED as UNCOVERED,
    VIRIDIS as VIRIDIS,
    Display as Display,
    distance_picture as distance_picture,
    shrink as shrink,
    to_display as to_display,
)
from .files import SIGNATURE as SIGNATURE, load as load, save_png as save_png
from .values import WINDOW as WINDOW, Values as Values, judged_part as judged_part, pack as pack
