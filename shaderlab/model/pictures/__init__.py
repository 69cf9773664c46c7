"""Arrays as pictures for people, and image files as arrays.

Arrays are in OpenGL's order: row 0 is the lowest, shape (height, width, channels).
OpenImageIO is loaded when a function needs it, not before. The names are listed in __init__.pyi;
each is imported when it is first used: pages need no NumPy.
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
