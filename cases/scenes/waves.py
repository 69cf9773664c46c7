"""Things that swing in time.

The first is that of section 2.3.4 of the notes.
"""

from __future__ import annotations

from shaderlab.glslmath import Value, sin


def pulse(time: Value) -> Value:
    """sin(t)/2 + 0.5: a sine moved into the range 0…1 of a colour.

    Args:
        time: t in seconds (the sine takes it as radians).

    >>> print(f"{pulse(1.0).item():.6f}")
    0.920735
    """
    return sin(time) / 2.0 + 0.5
