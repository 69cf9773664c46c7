"""Work in processes that may die: a crash, a hang or runaway memory costs one item, no more.

`Pool` hands items to workers in batches and gives each item's outcome back in order. A worker is
a fresh interpreter and not a fork: it inherits no threads, no OpenGL context and no `__main__`,
and it is the same on every system.
"""

from shaderlab.workers.pool import Outcome, Pool
from shaderlab.workers.process import Limits

__all__ = ["Limits", "Outcome", "Pool"]
