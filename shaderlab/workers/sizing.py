"""How many workers are worth their start."""

from __future__ import annotations

import os

MOST = 4
"""More are started only where they are asked for: each may take all that `--memory` allows, and
what more of them gain was not measured."""
VARIANTS_EACH = 4
"""A worker takes about as long to start as so many variants to run, so fewer do not repay it."""
LOADS = 8
"""So many case files are sent to a worker at once, where there are many: to load a small one takes
a worker little longer than sending it."""
TURNS = 4
"""Each of as many workers as there may be gets files so often, lest one waits for another's."""
WORDS = f"one for every {VARIANTS_EACH} variants, as cores allow, at most {MOST}"


def cores() -> int:
    """The processors that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # macOS and Windows have no such list
        return os.cpu_count() or 1


def suitable(variants: int) -> int:
    """How many workers run so many variants in the least time; one at least.

    >>> suitable(VARIANTS_EACH), suitable(0)
    (1, 1)
    """
    return max(1, min(variants // VARIANTS_EACH, cores(), MOST))


def loads(files: int) -> int:
    """How many case files a worker is sent at once.

    >>> loads(5), loads(64), loads(1000)
    (1, 4, 8)
    """
    return max(1, min(files // (MOST * TURNS), LOADS))
