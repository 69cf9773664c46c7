"""The public interface: each name and where it is. The package loads a name at its first use."""

from .bands import Rules as Rules
from .engine.expectations.any_order import any_order as any_order, both_ways as both_ways
from .engine.expectations.boundaries import boundaries as boundaries
from .engine.expectations.cost import cost as cost
from .engine.expectations.driver_answers import (
    attribute_layout as attribute_layout,
    block_layout as block_layout,
    coverage as coverage,
    gl_error as gl_error,
    inactive_uniforms as inactive_uniforms,
    query as query,
)
from .engine.expectations.exact import exact as exact
from .engine.expectations.figures import computed as computed, value as value
from .engine.expectations.formula import formula as formula, sweep as sweep
from .engine.expectations.gl_call import gl_call as gl_call, gl_calls as gl_calls
from .engine.expectations.laws import (
    bounded as bounded,
    even as even,
    monotone as monotone,
    odd as odd,
    symmetric as symmetric,
)
from .engine.expectations.measure import measure as measure, reading as reading
from .engine.expectations.rejections import compile_fails as compile_fails, refused as refused
from .errors import ShaderlabError as ShaderlabError
from .model.case import Case as Case, Erratum as Erratum, Variant as Variant
from .model.mesh import Mesh as Mesh
from .model.scene import (
    Draw as Draw,
    Pass as Pass,
    Pixel as Pixel,
    Ramp as Ramp,
    Target as Target,
    UniformBuffer as UniformBuffer,
    across as across,
    compute as compute,
    fullscreen as fullscreen,
    mesh_pass as mesh_pass,
    up as up,
)
from .model.state import (
    Blend as Blend,
    Cell as Cell,
    Depth as Depth,
    State as State,
    Stencil as Stencil,
)
from .model.textures import (
    CompressedTexture as CompressedTexture,
    CubeTexture as CubeTexture,
    Output as Output,
    Texture as Texture,
    Texture3D as Texture3D,
    TextureArray as TextureArray,
)

__version__: str
