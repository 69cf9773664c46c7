"""What the rosette of the chapter on buffers looks like: vertices handed on, light encoded.

Source: The OpenGL Graphics System: A Specification (version 4.5 core profile), M. Segal and
K. Akeley, 2017, §8.3.8 and §17.3.7 for colours that are linear in light; the square root stands
for the display's curve, a gamma of 2.
"""

from __future__ import annotations

from shaderlab.glslmath import Value, sqrt, vec4


def as_it_is(aPos: Value) -> Value:
    """A vertex in device coordinates as clip coordinates.

    >>> as_it_is((0.5, 0.25, 0.0)).tolist()
    [0.5, 0.25, 0.0, 1.0]
    """
    return vec4(aPos, 1.0)


def color_of(aColor: Value) -> Value:
    """A vertex's colour, handed on.

    >>> color_of(0.5)
    0.5
    """
    return aColor


def encoded(ourColor: Value) -> Value:
    """Interpolated light, (…, 3) in 0…1, as the display's numbers, (…, 4).

    >>> encoded((0.25, 1.0, 0.0)).tolist()
    [0.5, 1.0, 0.0, 1.0]
    """
    return vec4(sqrt(ourColor), 1.0)
