"""The same laws by other people: libraries that a formula is compared with.

Source: colour-science, "Colour", colour.models.rgb.transfer_functions.srgb.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np


def srgb_by_colour_science(linear: Any) -> Any:
    """The sRGB encoding by the colour-science library, of float64 arrays only.

    >>> print(f"{srgb_by_colour_science(0.5):.6f}")
    0.735357
    """
    # It announces which optional parts of it are not installed, and changes how NumPy prints.
    with warnings.catch_warnings(), np.printoptions():
        warnings.simplefilter("ignore")
        from colour.models import eotf_inverse_sRGB

    return eotf_inverse_sRGB(np.asarray(linear))
