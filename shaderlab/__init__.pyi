"""The public interface: each name and where it is. The package loads a name at its first use."""

from .bands import Rules as Rules
from .errors import ShaderlabError as ShaderlabError
from .expectations.any_order import any_order as any_order, both_ways as both_ways
from .expectations.attribute_layout import attribute_layout as attribute_layout
from .expectations.block_layout import block_layout as block_layout
from .expectations.boundaries import boundaries as boundaries
from .expectations.bounded import bounded as bounded
from .expectations.compile_fails import compile_fails as compile_fails
from .expectations.computed import computed as computed
from .expectations.cost import cost as cost
from .expectations.coverage import coverage as coverage
from .expectations.energy_conserving import energy_conserving as energy_conserving
from .expectations.exact import exact as exact
from .expectations.formula import formula as formula
from .expectations.gl_call import gl_call as gl_call
from .expectations.gl_calls import gl_calls as gl_calls
from .expectations.gl_error import gl_error as gl_error
from .expectations.inactive_uniforms import inactive_uniforms as inactive_uniforms
from .expectations.mean_of import mean_of as mean_of
from .expectations.measure import measure as measure
from .expectations.monotone import monotone as monotone
from .expectations.portable import portable as portable
from .expectations.query import query as query
from .expectations.readings import reading as reading
from .expectations.refused import refused as refused
from .expectations.same_as import same_as as same_as
from .expectations.sweep import sweep as sweep
from .expectations.symmetric import symmetric as symmetric
from .expectations.value import value as value
from .model import (
    Blend as Blend,
    Case as Case,
    Cell as Cell,
    CompressedTexture as CompressedTexture,
    CubeTexture as CubeTexture,
    Depth as Depth,
    Draw as Draw,
    Erratum as Erratum,
    Mesh as Mesh,
    Output as Output,
    Pass as Pass,
    Pixel as Pixel,
    Ramp as Ramp,
    State as State,
    Stencil as Stencil,
    Target as Target,
    Texture as Texture,
    Texture3D as Texture3D,
    TextureArray as TextureArray,
    UniformBuffer as UniformBuffer,
    Variant as Variant,
    across as across,
    compute as compute,
    fullscreen as fullscreen,
    mesh_pass as mesh_pass,
    up as up,
)

__version__: str
