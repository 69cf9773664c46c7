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


def decoded_blocks(blocks: bytes, format: str, size: tuple[int, int]) -> Any:
    """Compressed blocks as the library `texture2ddecoder` decodes them: codes (height, width, 4).

    Args:
        blocks: of one level, its first row first.
        format: "etc1", "etc2_rgb8", "etc2_eac_rgba8", "bc1", "bc3" or "bc7".
        size: (width, height).

    >>> decoded_blocks(bytes(8), "bc1", (4, 4))[0, 0].tolist()
    [0, 0, 0, 255]
    """
    import texture2ddecoder

    function = {
        "etc1": texture2ddecoder.decode_etc1,
        "etc2_rgb8": texture2ddecoder.decode_etc2,
        "etc2_eac_rgba8": texture2ddecoder.decode_etc2a8,
        "bc1": texture2ddecoder.decode_bc1,
        "bc3": texture2ddecoder.decode_bc3,
        "bc7": texture2ddecoder.decode_bc7,
    }[format]
    width, height = size
    codes = np.frombuffer(function(blocks, width, height), np.uint8)
    return codes.reshape(height, width, 4)[..., [2, 1, 0, 3]]
