"""Can this machine give an OpenGL 3.3 context without a screen? Exits 1 and says why not.

Runs before any package is installed, so it asks EGL itself, by its C interface.
"""

import ctypes
import os
import sys

OPENGL_API = 0x30A2
SURFACELESS_MESA = 0x31DD
CONTEXT_MAJOR, CONTEXT_MINOR, NONE = 0x3098, 0x30FB, 0x3038
SURFACE_TYPE, RENDERABLE_TYPE, OPENGL_BIT = 0x3033, 0x3040, 0x0008


def library(*names: str) -> ctypes.CDLL:
    """The first of these shared libraries that loads."""
    for name in names:
        try:
            return ctypes.CDLL(name)
        except OSError:
            continue
    sys.exit(f"no {names[0]}")


def main() -> None:
    """Make a context on EGL's surfaceless platform, as the lab does."""
    if sys.platform not in ("linux", "darwin"):
        return  # nothing is known to be missing; `shaderlab doctor` tells more
    os.environ.setdefault("LIBGL_ALWAYS_SOFTWARE", "1")
    library("libGL.so.1", "libGL.dylib", "/opt/homebrew/lib/libGL.dylib")
    egl = library("libEGL.so.1", "libEGL.dylib", "/opt/homebrew/lib/libEGL.dylib")
    pointer, integers = ctypes.c_void_p, ctypes.POINTER(ctypes.c_int32)
    egl.eglGetProcAddress.restype = pointer
    egl.eglGetProcAddress.argtypes = [ctypes.c_char_p]
    egl.eglInitialize.argtypes = [pointer, integers, integers]
    egl.eglChooseConfig.argtypes = [
        pointer, integers, ctypes.POINTER(pointer), ctypes.c_int32, integers,
    ]  # fmt: skip
    egl.eglCreateContext.restype = pointer
    egl.eglCreateContext.argtypes = [pointer, pointer, pointer, integers]

    address = egl.eglGetProcAddress(b"eglGetPlatformDisplayEXT")
    if not address:
        sys.exit("EGL has no platform displays")
    prototype = ctypes.CFUNCTYPE(pointer, ctypes.c_uint32, pointer, integers)
    display = prototype(address)(SURFACELESS_MESA, None, None)
    if not display:
        sys.exit("EGL has no Mesa driver")
    if not egl.eglInitialize(display, None, None):
        sys.exit("EGL's Mesa driver does not start")
    if not egl.eglBindAPI(OPENGL_API):
        sys.exit("EGL offers no desktop OpenGL")
    wanted = (ctypes.c_int32 * 5)(SURFACE_TYPE, 0, RENDERABLE_TYPE, OPENGL_BIT, NONE)
    config, count = pointer(), ctypes.c_int32()
    if not egl.eglChooseConfig(display, wanted, ctypes.byref(config), 1, count) or not count.value:
        sys.exit("EGL has no configuration for OpenGL")
    version = (ctypes.c_int32 * 5)(CONTEXT_MAJOR, 3, CONTEXT_MINOR, 3, NONE)
    if not egl.eglCreateContext(display, config, None, version):
        sys.exit("the driver has no OpenGL 3.3")


if __name__ == "__main__":
    main()
