"""The case model: frozen, pure data. Importing it, or a case, touches no device."""

from shaderlab.model.calls import (
    COUNTERS as COUNTERS,
    GL_ERRORS as GL_ERRORS,
    Argument as Argument,
    Call as Call,
    Location as Location,
    Object as Object,
    Program as Program,
    call as call,
    error_name as error_name,
)
from shaderlab.model.case import (
    DEFAULT_VARIANT as DEFAULT_VARIANT,
    Case as Case,
    Erratum as Erratum,
    Scene as Scene,
    Variant as Variant,
)
from shaderlab.model.expectation import (
    Expectation as Expectation,
    Judgement as Judgement,
    LazyArrays as LazyArrays,
    Need as Need,
    Programs as Programs,
    Read as Read,
)
from shaderlab.model.mesh import Mesh as Mesh, Placement as Placement
from shaderlab.model.passes import (
    compute as compute,
    fullscreen as fullscreen,
    mesh_pass as mesh_pass,
)
from shaderlab.model.scene import (
    BufferValue as BufferValue,
    Draw as Draw,
    Pass as Pass,
    Pixel as Pixel,
    Ramp as Ramp,
    Target as Target,
    UniformBuffer as UniformBuffer,
    UniformValue as UniformValue,
    across as across,
    up as up,
)
from shaderlab.model.state import (
    Blend as Blend,
    Cell as Cell,
    Depth as Depth,
    State as State,
    Stencil as Stencil,
    one_of as one_of,
)
from shaderlab.model.textures import (
    CompressedTexture as CompressedTexture,
    CubeTexture as CubeTexture,
    ImageValue as ImageValue,
    Output as Output,
    Texture as Texture,
    Texture3D as Texture3D,
    TextureArray as TextureArray,
    TextureSource as TextureSource,
    outputs_read as outputs_read,
)
