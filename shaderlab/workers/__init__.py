"""Execution: jobs in, records out, whatever a scene does to its process.

Names are imported when they are first asked for (PEP 562): a worker needs none of those that start
workers.
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from .executor import Executor, InProcessExecutor, ProcessExecutor
    from .jobs import Job
    from .pool import WorkerPool
    from .prefetcher import Prefetcher

__all__ = ["Executor", "InProcessExecutor", "Job", "Prefetcher", "ProcessExecutor", "WorkerPool"]
_MODULES = {"Job": "jobs", "Prefetcher": "prefetcher", "WorkerPool": "pool"}


def __getattr__(name: str) -> _typing.Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = _importlib.import_module(f".{_MODULES.get(name, 'executor')}", __name__)
    globals()[name] = value = getattr(module, name)
    return value
