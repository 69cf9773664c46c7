"""Running many scenes: each in a process that it may take down, each record kept at once.

Names are imported when they are first asked for (PEP 562): a worker needs none of those that start
workers.
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from shaderlab.running.ahead import Ahead
    from shaderlab.running.crew import Crew, Solo, Team
    from shaderlab.running.jobs import Job, Limits, Setup

__all__ = ["Ahead", "Crew", "Job", "Limits", "Setup", "Solo", "Team"]


def __getattr__(name: str) -> _typing.Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    homes = {"Ahead": "ahead", "Crew": "crew", "Solo": "crew", "Team": "crew"}
    value = getattr(_importlib.import_module(f".{homes.get(name, 'jobs')}", __name__), name)
    globals()[name] = value
    return value
