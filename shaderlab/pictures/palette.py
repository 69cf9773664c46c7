"""The colours of a false-colour picture as a table, for whoever draws one elsewhere."""

from __future__ import annotations

import numpy as np

from shaderlab.pictures.display import to_display


def palette(colours: str = "viridis", count: int = 256) -> str:
    """`count` colours from a map's dark end to its bright one, six hexadecimal digits each.

    Raises:
        AssetError: there is no such map.
    """
    ramp = np.linspace(0.0, 1.0, count)[None, :, None]
    table: bytes = to_display(ramp, colours=colours).image[0].tobytes()
    return table.hex()
