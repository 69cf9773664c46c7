"""shaderlab makes shader formulas testable: GLSL in, a judged picture and a report out.

Everything a case file needs is here (`Case`, what it draws, what must hold), and nothing here
touches a device: importing a case is reading data. Formulas are written with
`shaderlab.glslmath`, meshes and textures come from `shaderlab.assets`.
"""

from shaderlab.bands import Rules
from shaderlab.errors import ShaderlabError
from shaderlab.model import (
    Blend,
    Case,
    Cell,
    Depth,
    Draw,
    Erratum,
    Mesh,
    Output,
    Pass,
    Pixel,
    Ramp,
    State,
    Stencil,
    Target,
    Texture,
    Variant,
    across,
    compile_fails,
    computed,
    coverage,
    exact,
    formula,
    fullscreen,
    gl_error,
    mesh_pass,
    sweep,
    up,
    value,
)

__version__ = "0.1.0"

__all__ = [
    "Blend",
    "Case",
    "Cell",
    "Depth",
    "Draw",
    "Erratum",
    "Mesh",
    "Output",
    "Pass",
    "Pixel",
    "Ramp",
    "Rules",
    "ShaderlabError",
    "State",
    "Stencil",
    "Target",
    "Texture",
    "Variant",
    "__version__",
    "across",
    "compile_fails",
    "computed",
    "coverage",
    "exact",
    "formula",
    "fullscreen",
    "gl_error",
    "mesh_pass",
    "sweep",
    "up",
    "value",
]
