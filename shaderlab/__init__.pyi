"""The public interface: each name and where it is. The package loads a name at its first use."""

from .bands import Rules as Rules
from .errors import ShaderlabError as ShaderlabError
from .expectations import (
    any_order as any_order,
)
from .expectations import (
    attribute_layout as attribute_layout,
)
from .expectations import (
    block_layout as block_layout,
)
from .expectations import (
    both_ways as both_ways,
)
from .expectations import (
    bounded as bounded,
)
from .expectations import (
    compile_fails as compile_fails,
)
from .expectations import (
    computed as computed,
)
from .expectations import (
    cost as cost,
)
from .expectations import (
    coverage as coverage,
)
from .expectations import (
    energy_conserving as energy_conserving,
)
from .expectations import (
    exact as exact,
)
from .expectations import (
    formula as formula,
)
from .expectations import (
    gl_call as gl_call,
)
from .expectations import (
    gl_error as gl_error,
)
from .expectations import (
    inactive_uniforms as inactive_uniforms,
)
from .expectations import (
    mean_of as mean_of,
)
from .expectations import (
    measure as measure,
)
from .expectations import (
    monotone as monotone,
)
from .expectations import (
    query as query,
)
from .expectations import (
    reading as reading,
)
from .expectations import (
    refused as refused,
)
from .expectations import (
    sweep as sweep,
)
from .expectations import (
    symmetric as symmetric,
)
from .expectations import (
    value as value,
)
from .model import (
    Blend as Blend,
)
from .model import (
    Case as Case,
)
from .model import (
    Cell as Cell,
)
from .model import (
    CompressedTexture as CompressedTexture,
)
from .model import (
    CubeTexture as CubeTexture,
)
from .model import (
    Depth as Depth,
)
from .model import (
    Draw as Draw,
)
from .model import (
    Erratum as Erratum,
)
from .model import (
    Mesh as Mesh,
)
from .model import (
    Output as Output,
)
from .model import (
    Pass as Pass,
)
from .model import (
    Pixel as Pixel,
)
from .model import (
    Ramp as Ramp,
)
from .model import (
    State as State,
)
from .model import (
    Stencil as Stencil,
)
from .model import (
    Target as Target,
)
from .model import (
    Texture as Texture,
)
from .model import (
    TextureArray as TextureArray,
)
from .model import (
    UniformBuffer as UniformBuffer,
)
from .model import (
    Variant as Variant,
)
from .model import (
    across as across,
)
from .model import (
    fullscreen as fullscreen,
)
from .model import (
    mesh_pass as mesh_pass,
)
from .model import (
    up as up,
)

__version__: str
