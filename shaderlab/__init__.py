"""shaderlab makes shader formulas testable: GLSL in, a judged picture and a report out.

Everything a case file needs is here (`Case`, what it draws, what must hold), and nothing here
touches a device: importing a case is reading data. Formulas are written with
`shaderlab.glslmath`, meshes and textures come from `shaderlab.assets`.

The names are listed in __init__.pyi. Each is imported when it is first used, so that what needs
only a part, such as the compile harness and its workers, does not wait for NumPy.
"""

import lazy_loader as _lazy

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
