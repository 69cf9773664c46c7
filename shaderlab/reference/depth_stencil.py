"""The comparisons of the depth and the stencil test.

Source: "The OpenGL Graphics System: A Specification", version 3.3 core, section 4.1.4 (stencil)
and 4.1.5 (depth). The incoming value stands on the left: LESS passes where incoming < stored.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping

FUNCTIONS: Mapping[str, Callable[[float, float], bool]] = {
    "never": lambda incoming, stored: False,
    "less": operator.lt,
    "equal": operator.eq,
    "lequal": operator.le,
    "greater": operator.gt,
    "notequal": operator.ne,
    "gequal": operator.ge,
    "always": lambda incoming, stored: True,
}
"""The eight comparisons, by OpenGL's names in lower case."""


def depth_passes(func: str, incoming: float, stored: float) -> bool:
    """Whether a fragment at window depth `incoming` (0…1) passes the test against `stored`.

    >>> depth_passes("less", 0.4, 0.5), depth_passes("less", 0.5, 0.5)
    (True, False)
    """
    return bool(FUNCTIONS[func](incoming, stored))


def stencil_passes(func: str, reference: int, stored: int, mask: int) -> bool:
    """Whether `(reference & mask) func (stored & mask)`; all of them 0…255.

    A mask of 0 does not switch the test off: it compares 0 with 0.

    >>> stencil_passes("less", 1, 2, 0xFF), stencil_passes("less", 1, 2, 0x00)
    (True, False)
    """
    return bool(FUNCTIONS[func](reference & mask, stored & mask))


OPERATIONS: Mapping[str, Callable[[int, int], int]] = {
    "keep": lambda stored, reference: stored,
    "zero": lambda stored, reference: 0,
    "replace": lambda stored, reference: reference,
    "incr": lambda stored, reference: min(stored + 1, 0xFF),
    "incr_wrap": lambda stored, reference: (stored + 1) & 0xFF,
    "decr": lambda stored, reference: max(stored - 1, 0),
    "decr_wrap": lambda stored, reference: (stored - 1) & 0xFF,
    "invert": lambda stored, reference: ~stored & 0xFF,
}
"""The new 8-bit value by the stored one: section 4.1.4; INCR and DECR saturate."""


def stencil_after(operation: str, stored: int, reference: int, write_mask: int = 0xFF) -> int:
    """The value in the stencil buffer after an operation; only bits in `write_mask` change.

    >>> stencil_after("incr", 255, 9), stencil_after("incr_wrap", 255, 9)
    (255, 0)
    >>> stencil_after("invert", 90, 9), stencil_after("replace", 0xF0, 0x0F, 0x3C)
    (165, 204)
    """
    changed = OPERATIONS[operation](stored, reference)
    return (stored & ~write_mask & 0xFF) | (changed & write_mask)


def depth_after(func: str | None, write: bool, incoming: float, stored: float) -> float:
    """The value in the depth buffer after a fragment: its own if the test passes and the mask
    (glDepthMask) allows writes. With the test off (None) nothing is written.

    >>> depth_after("less", True, 0.25, 0.5), depth_after("less", False, 0.25, 0.5)
    (0.25, 0.5)
    >>> depth_after(None, True, 0.25, 0.5), depth_after("always", True, 0.75, 0.5)
    (0.5, 0.75)
    """
    written = func is not None and write and depth_passes(func, incoming, stored)
    return incoming if written else stored
