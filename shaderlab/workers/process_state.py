"""What imported code may have changed for everything else that runs in its process."""

import _thread
import builtins
import contextlib
import gc
import locale
import os
import pickle
import random
import resource
import signal
import sys
import warnings
from collections.abc import Mapping
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

_LIMITS = [value for name, value in vars(resource).items() if name.startswith("RLIMIT_")]


_SHARED = {
    *("builtins", "collections", "contextlib", "dataclasses", "functools", "hashlib", "inspect"),
    *("itertools", "json", "math", "numpy", "operator", "os", "pathlib", "pickle", "random"),
    *("re", "shaderlab", "struct", "time", "weakref", "zlib"),
}
"""Packages whose functions count: what the lab computes with, and what formulas are made of."""


_METHODS = FunctionType, property, classmethod, staticmethod


class ProcessState:
    """The state of this process at one time: its folder, environment, search path, signals, limits,
    threads and child processes; the settings of Python, NumPy and arithmetic; and the functions and
    methods of shared modules that are imported by then."""

    def __init__(self) -> None:
        self._settings = _read_settings()
        self._modules = {n: m for n, m in sys.modules.items() if n.partition(".")[0] in _SHARED}
        self._functions: list[tuple[Mapping[str, Any], list[tuple[str, Any]]]] = [
            (vars(module), _functions_of(module)) for module in self._modules.values()
        ]
        for name, module in self._modules.items():
            for kind in vars(module).values():
                if isinstance(kind, type) and kind.__module__ == name:
                    methods = [(k, v) for k, v in vars(kind).items() if isinstance(v, _METHODS)]
                    self._functions.append((vars(kind), methods))

    def has_changed(self) -> bool:
        """Whether anything is another than at that time; what modules have besides is not."""
        try:
            if _read_settings() != self._settings or _gives_others():
                return True
            if any(sys.modules[name] is not module for name, module in self._modules.items()):
                return True
            for names, functions in self._functions:
                for key, value in functions:  # thousands: `all` would take three times as long
                    if names[key] is not value:
                        return True
        except Exception:  # what would tell is broken itself, or something is gone
            return True
        return False


def _functions_of(module: ModuleType) -> list[tuple[str, Any]]:
    """The functions and classes of a module, but for those by which it is imported lazily."""
    named = vars(module).items()
    return [(k, v) for k, v in named if callable(v) and not k.startswith("__")]


def _gives_others() -> bool:
    """Whether `shaderlab` has other names than those that it imports when they are first used."""
    lab = sys.modules["shaderlab"]
    public = {k: v for k, v in vars(lab).items() if k[0] != "_" and not isinstance(v, ModuleType)}
    return any(lab.__getattr__(name) is not value for name, value in public.items())


def _read_settings() -> list[Any]:
    # A hook that can't be taken back may raise at each of these.
    sys.audit("open", os.devnull, "r", 0)
    sys.audit("import", "os", None, [], [], [])
    sys.audit("exec", None)
    mask = os.umask(0o077)
    os.umask(mask)
    one, tiny = float("1.0"), float("5e-324")  # in words, so that no compiler computes with them
    return [
        os.getcwd(),
        {k: v for k, v in os.environ.items() if k != "OpenImageIO_ROOT"},  # set by importing it
        mask,
        [resource.getrlimit(limit) for limit in _LIMITS],
        [signal.getsignal(number) for number in signal.valid_signals()],
        signal.pthread_sigmask(signal.SIG_BLOCK, ()),
        _thread._count(),
        _has_children(),
        list(map(os.close, [os.dup(0) for _ in range(16)])),  # there is room for files
        [sys.path[:], sys.meta_path[:], sys.path_hooks[:], sys.stdout, sys.stderr],
        [sys.getrecursionlimit(), sys.gettrace(), sys.getprofile(), sys.excepthook, gc.isenabled()],
        list(vars(builtins)),
        warnings.filters[:],
        locale.setlocale(locale.LC_ALL),
        [np.geterr(), np.geterrcall(), np.get_printoptions()],
        [random.getstate(), pickle.dumps(np.random.get_state())],
        # Where rounding goes, and whether small numbers become 0.
        [one + 1e-20, one - 1e-20, -one - 1e-20, tiny * one],
    ]


def _has_children() -> bool:
    with contextlib.suppress(ChildProcessError):
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOWAIT | os.WNOHANG)
        return True
    return False
