"""shaderlab makes shader formulas testable: GLSL in, a judged picture and a report out.

Everything a case file needs is here (`Case`, what it draws, what must hold), and nothing here
touches a device: importing a case is reading data. Formulas are written with
`shaderlab.glslmath`, meshes and textures come from `shaderlab.assets`.

The names are listed in __init__.pyi. Each is imported when it is first used, so that what needs
only a part, such as the compile harness and its workers, does not wait for NumPy.
"""

__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    # Reading the stub takes longer than starting Python; the commands do without, and first of all
    # they see to it that they can be interrupted.
    import lazy_loader

    find, list_names, names = lazy_loader.attach_stub(__name__, __file__)
    globals().update(__getattr__=find, __dir__=list_names, __all__=names)
    return names if name == "__all__" else find(name)


def __dir__() -> list[str]:
    return list(__getattr__("__all__"))
