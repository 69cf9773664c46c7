"""shaderlab makes shader formulas testable: GLSL in, a judged picture and a report out.

Everything a case file needs is here (`Case`, what it draws, what must hold), and nothing here
touches a device: importing a case is reading data. Formulas are written with
`shaderlab.glslmath`, meshes and textures come from `shaderlab.assets`.

Names are imported when they are first asked for (PEP 562), so that what needs only a part, such as
the compile harness and its workers, does not wait for NumPy.
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from shaderlab.bands import Rules
    from shaderlab.errors import ShaderlabError
    from shaderlab.model import (
        Blend,
        Case,
        Cell,
        CompressedTexture,
        CubeTexture,
        Depth,
        Draw,
        Erratum,
        Location,
        Mesh,
        Object,
        Output,
        Pass,
        Pixel,
        Program,
        Ramp,
        State,
        Stencil,
        Target,
        Texture,
        TextureArray,
        UniformBuffer,
        Variant,
        across,
        attribute_layout,
        block_layout,
        bounded,
        call,
        compile_fails,
        computed,
        cost,
        coverage,
        energy_conserving,
        exact,
        formula,
        fullscreen,
        gl_call,
        gl_error,
        inactive_uniforms,
        mean_of,
        measure,
        mesh_pass,
        monotone,
        query,
        reading,
        refused,
        sweep,
        symmetric,
        up,
        value,
    )

__version__ = "0.1.0"

__all__ = [
    "Blend",
    "Case",
    "Cell",
    "CompressedTexture",
    "CubeTexture",
    "Depth",
    "Draw",
    "Erratum",
    "Location",
    "Mesh",
    "Object",
    "Output",
    "Pass",
    "Pixel",
    "Program",
    "Ramp",
    "Rules",
    "ShaderlabError",
    "State",
    "Stencil",
    "Target",
    "Texture",
    "TextureArray",
    "UniformBuffer",
    "Variant",
    "__version__",
    "across",
    "attribute_layout",
    "block_layout",
    "bounded",
    "call",
    "compile_fails",
    "computed",
    "cost",
    "coverage",
    "energy_conserving",
    "exact",
    "formula",
    "fullscreen",
    "gl_call",
    "gl_error",
    "inactive_uniforms",
    "mean_of",
    "measure",
    "mesh_pass",
    "monotone",
    "query",
    "reading",
    "refused",
    "sweep",
    "symmetric",
    "up",
    "value",
]


def __getattr__(name: str) -> _typing.Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = {"Rules": "shaderlab.bands", "ShaderlabError": "shaderlab.errors"}
    value = getattr(_importlib.import_module(home.get(name, "shaderlab.model")), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
