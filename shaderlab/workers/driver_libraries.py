"""The libraries of the usual driver, loaded beside what a fork server imports.

Half of the time in which Mesa is opened is that of LLVM's loading. The loader takes no lock of
Python's, and workers that are forked afterwards have the libraries already. It loads one library
at a time: what is imported meanwhile should have few of its own.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from contextlib import suppress

_SOFTWARE = ("", "llvmpipe", "llvmpipe-spirv", "softpipe")
_EGL = "libEGL_mesa.so.0"
_DRIVER = "swrast_dri.so"
"""What Mesa's EGL loads when it is opened; later versions of it are linked with that."""
_MODE = os.RTLD_NOW | os.RTLD_LOCAL


def load() -> threading.Thread | None:
    """Begin to load them, where they are the ones that SHADERLAB_DRIVER means. A library that is
    not there is left to those who open the driver, and who say so.

    Returns:
        what has to be waited for before this process is forked.
    """
    wanted = os.environ.get("SHADERLAB_DRIVER", "") in _SOFTWARE
    if not wanted or not sys.platform.startswith("linux"):
        return None
    thread = threading.Thread(target=_load, daemon=True)
    thread.start()
    return thread


def _load() -> None:
    with suppress(OSError, AttributeError):
        # `ctypes.CDLL` would keep Python's lock meanwhile.
        dlopen = ctypes.CDLL(None).dlopen
        dlopen.restype, dlopen.argtypes = ctypes.c_void_p, (ctypes.c_char_p, ctypes.c_int)
        if dlopen(os.fsencode(_EGL), _MODE):
            for folder in _folders():
                if dlopen(os.fsencode(os.path.join(folder, _DRIVER)), _MODE):
                    return


def _folders() -> list[str]:
    """Where Mesa looks for its drivers."""
    given = os.environ.get("LIBGL_DRIVERS_PATH")
    if given:
        return given.split(os.pathsep)
    with open("/proc/self/maps", encoding="utf-8", errors="surrogateescape") as maps:
        found = (line.split(maxsplit=5)[-1].rstrip("\n") for line in maps if "/libEGL_mesa" in line)
        return [os.path.join(os.path.dirname(path), "dri") for path in dict.fromkeys(found)]
