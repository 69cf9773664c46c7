"""The names of the room, and where they are."""

from .colours import (
    BAND_HIGH as BAND_HIGH,
    BAND_LOW as BAND_LOW,
    BAND_MIDDLE as BAND_MIDDLE,
    NOT_FINITE as NOT_FINITE,
    OUTSIDE as OUTSIDE,
    UNCOVERED as UNCOVERED,
    VIRIDIS as VIRIDIS,
)
from .display import (
    Display as Display,
    distance_picture as distance_picture,
    to_display as to_display,
)
from .files import (
    LARGEST_SIDE as LARGEST_SIDE,
    coarse as coarse,
    load as load,
    save_png as save_png,
    save_preview as save_preview,
)
from .packing import SIGNATURE as SIGNATURE, repacked as repacked
from .previews import preview as preview
from .values import WINDOW as WINDOW, Values as Values, judged_part as judged_part, pack as pack
