"""What the modules declare against what a driver reports of the same program."""

import os
from collections.abc import Iterator, Mapping
from typing import Any

import moderngl
import numpy as np
import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.reflection import Interface

# GL's type enumerants by their GLSL names.
GL_TYPES: Mapping[int, str] = {
    0x1404: "int",
    0x1405: "uint",
    0x1406: "float",
    0x140A: "double",
    0x8B50: "vec2",
    0x8B51: "vec3",
    0x8B52: "vec4",
    0x8B53: "ivec2",
    0x8B54: "ivec3",
    0x8B55: "ivec4",
    0x8B56: "bool",
    0x8B57: "bvec2",
    0x8B58: "bvec3",
    0x8B59: "bvec4",
    0x8B5A: "mat2",
    0x8B5B: "mat3",
    0x8B5C: "mat4",
    0x8B65: "mat2x3",
    0x8B66: "mat2x4",
    0x8B67: "mat3x2",
    0x8B68: "mat3x4",
    0x8B69: "mat4x2",
    0x8B6A: "mat4x3",
    0x8DC6: "uvec2",
    0x8DC7: "uvec3",
    0x8DC8: "uvec4",
    0x8B5D: "sampler1D",
    0x8B5E: "sampler2D",
    0x8B5F: "sampler3D",
    0x8B60: "samplerCube",
    0x8B62: "sampler2DShadow",
    0x8DC1: "sampler2DArray",
    0x8DC5: "samplerCubeShadow",
    0x8DC4: "sampler2DArrayShadow",
    0x8DCA: "isampler2D",
    0x8DD2: "usampler2D",
    0x9108: "sampler2DMS",
    0x8DC2: "samplerBuffer",
    0x8B63: "sampler2DRect",
    0x904D: "image2D",
}

LIT = {
    "vertex": """#version 330 core
layout (location = 3) in vec3 aPos;
in vec2 aUV;
in mat3 aBasis;
in ivec4 aBones;
in vec3 aUnread;
uniform mat4 model, view;
uniform mat3x2 narrow;
uniform float weights[5];
out vec3 FragPos;
flat out int bone;
noperspective out vec2 uv;
void main() {
    FragPos = aBasis * aPos * weights[int(aUV.x)];
    bone = aBones.z;
    uv = aUV + narrow * aPos;
    gl_Position = view * model * vec4(FragPos, 1.0);
}
""",
    "fragment": """#version 330 core
struct Light { vec3 position; float constant; };
struct Pair { Light near; Light far[2]; };
struct Material { sampler2D diffuse; sampler2D specular; float shininess; };
in vec3 FragPos;
noperspective in vec2 uv;
flat in int bone;
uniform Light light;
uniform Light lights[3];
uniform Pair pairs[2];
uniform Material material;
uniform bool on;
uniform uvec2 size;
uniform samplerCube sky;
uniform sampler2DShadow shadow;
uniform sampler2DArray layers;
uniform isampler2D ids;
uniform usampler2D masks;
uniform sampler3D volume;
uniform sampler2D maps[2];
uniform vec3 inactive;
uniform mat4 view;
layout (location = 0) out vec4 FragColor;
layout (location = 1) out vec3 extra[2];
out uint unset;
void main() {
    vec4 c = texture(material.diffuse, uv) * material.shininess + texture(material.specular, uv);
    for (int i = 0; i < 3; i++) c.rgb += lights[i].position / lights[i].constant;
    c.rgb += light.position * light.constant + pairs[1].far[0].position + pairs[0].near.constant;
    c += texture(sky, FragPos) + texture(shadow, FragPos) + texture(layers, FragPos);
    c += vec4(texture(ids, uv)) + vec4(texture(masks, uv)) + texture(volume, FragPos);
    c += texture(maps[0], uv) + texture(maps[1], uv) + view[0];
    FragColor = on ? c : vec4(size, bone, 1.0);
    extra[0] = c.rgb; extra[1] = c.bgr;
    unset = 1u;
}
""",
}
BLOCKS = {
    "vertex": """#version 430 core
struct Inner { vec3 h; float i; };
layout (std140) uniform Matrices { mat4 projection; mat4 view; };
layout (std140) uniform Mixed {
    float a; vec3 b; float c[3]; mat3 d; vec2 e; bool f; int g;
    Inner s[2];
} mixed;
layout (std430, binding = 2) buffer Store { vec3 first; float second; vec2 pairs[]; } store;
in vec4 aPos;
out Out { vec3 normal; vec2 uv[2]; } vs_out;
void main() {
    vs_out.normal = mixed.b * mixed.a * mixed.c[1] * mixed.d * mixed.s[1].h + store.first;
    vs_out.uv[0] = mixed.e * mixed.s[0].i + store.pairs[1];
    vs_out.uv[1] = mixed.f ? vec2(mixed.g) : vec2(store.second);
    gl_Position = projection * view * aPos;
}
""",
    "fragment": """#version 430 core
layout (std140) uniform Matrices { mat4 projection; mat4 view; };
in Out { vec3 normal; vec2 uv[2]; } fs_in;
layout (rgba8, binding = 1) uniform image2D target;
out vec4 c;
void main() {
    c = vec4(fs_in.normal, fs_in.uv[0].x + fs_in.uv[1].y) * view[0];
    imageStore(target, ivec2(0), c);
}
""",
}
FEEDBACK = {
    "vertex": "#version 330 core\nin vec3 a;\nout vec3 tint;\nvoid main() { tint = a; "
    "gl_Position = vec4(a, 1.0); }\n",
    "geometry": """#version 330 core
layout (points) in;
layout (points, max_vertices = 1) out;
in vec3 tint[];
out vec3 shade;
uniform float push;
void main() {
    shade = tint[0] * push;
    gl_Position = gl_in[0].gl_Position;
    EmitVertex();
}
""",
    "fragment": "#version 330 core\nin vec3 shade;\nout vec4 c;\n"
    "void main() { c = vec4(shade, 1.0); }\n",
}


@pytest.fixture(scope="module")
def context() -> Iterator[Any]:
    try:
        create: Any = moderngl.create_context  # its stubs type keywords of back ends wrongly
        made = create(standalone=True, backend="egl", require=430)
    except Exception as error:  # moderngl raises plain Exception
        pytest.skip(f"no OpenGL driver here: {error}")
    yield made
    made.release()


def interface(program: Mapping[str, str]) -> Interface:
    sources = [Shaders([]).from_text(text, stage, stage) for stage, text in program.items()]
    compiled = compile_program(sources, ["glsl", "opengl"])
    compiled.require()
    assert compiled.interface is not None
    return compiled.interface


def linked(context: Any, program: Mapping[str, str]) -> Any:
    names = {s: f"{s}_shader" for s in ("vertex", "geometry", "fragment")}
    return context.program(**{names[stage]: text for stage, text in program.items()})


@pytest.mark.parametrize("program", [LIT, BLOCKS, FEEDBACK], ids=["lit", "blocks", "geometry"])
def test_active_uniforms_are_declared_with_the_drivers_types(
    context: Any, program: Mapping[str, str]
) -> None:
    ours = interface(program)
    members = linked(context, program)
    uniforms = [members[name] for name in members if isinstance(members[name], moderngl.Uniform)]
    assert uniforms
    for uniform in uniforms:
        mine = ours.uniforms[uniform.name]
        assert mine.type == GL_TYPES[uniform.gl_type], uniform.name
        assert (mine.array or 1) == uniform.array_length, uniform.name
    # A driver may call the rest of a nested struct active too, never less than what is read.
    assert {name for name, mine in ours.uniforms.items() if mine.used} <= {
        uniform.name for uniform in uniforms
    }


def test_unused_uniforms_are_declared_and_marked_unused(context: Any) -> None:
    ours = interface(LIT)
    assert not ours.uniforms["inactive"].used
    assert "inactive" not in linked(context, LIT)
    assert not ours.uniforms["pairs[0].far[0].constant"].used
    assert ours.uniforms["pairs[1].far[0].position"].used
    assert ours.uniforms["lights[2].constant"].used


@pytest.mark.parametrize("program", [LIT, BLOCKS, FEEDBACK], ids=["lit", "blocks", "geometry"])
def test_attributes_are_the_drivers(context: Any, program: Mapping[str, str]) -> None:
    ours = interface(program)
    members = linked(context, program)
    theirs = [members[name] for name in members if isinstance(members[name], moderngl.Attribute)]
    assert {attribute.name for attribute in theirs} == {
        name for name, mine in ours.attributes.items() if mine.used
    }
    for attribute in theirs:
        assert ours.attributes[attribute.name].components == attribute.dimension


def test_explicit_locations_and_interpolation_are_kept() -> None:
    ours = interface(LIT)
    assert ours.attributes["aPos"].location == 3
    assert not ours.attributes["aUnread"].used
    assert {name: v.interpolation for name, v in ours.varyings.items()} == {
        "FragPos": "smooth",
        "uv": "noperspective",
        "bone": "flat",
    }
    for name, varying in ours.varyings.items():
        assert ours.vertex_outputs[name].location == varying.location
        assert ours.vertex_outputs[name].interpolation == varying.interpolation
        assert ours.vertex_outputs[name].type == varying.type
    assert (ours.outputs["FragColor"].location, ours.outputs["FragColor"].type) == (0, "vec4")
    assert (ours.outputs["extra"].location, ours.outputs["extra"].array) == (1, 2)
    assert (ours.outputs["unset"].type, ours.outputs["unset"].components) == ("uint", 1)


def test_blocks_have_the_drivers_size_and_std140_offsets(context: Any) -> None:
    ours = interface(BLOCKS)
    members = linked(context, BLOCKS)
    for name in ("Matrices", "Mixed"):
        block = members[name]
        assert isinstance(block, moderngl.UniformBlock)
        assert ours.blocks[name].size == block.size
    assert {m.name: m.offset for m in ours.blocks["Matrices"].members.values()} == {
        "projection": 0,
        "view": 64,
    }
    mixed = ours.blocks["Mixed"]
    # OpenGL 4.6, 7.6.2.2: vec3 aligns to 16, array elements and matrix columns take 16 each.
    assert {m.name: m.offset for m in mixed.members.values()} == {
        "a": 0,
        "b": 16,
        "c": 32,
        "d": 80,
        "e": 128,
        "f": 136,
        "g": 140,
        "s[0].h": 144,
        "s[0].i": 156,
        "s[1].h": 160,
        "s[1].i": 172,
    }
    assert mixed.members["c"].array_stride == mixed.members["d"].matrix_stride == 16
    assert (mixed.members["c"].size, mixed.members["d"].size) == (48, 48)
    store = ours.blocks["Store"]
    assert (store.kind, store.binding) == ("storage", 2)
    assert (store.members["pairs"].offset, store.members["pairs"].array_stride) == (16, 8)
    assert store.members["pairs"].array == 0


def test_varying_blocks_are_named_as_transform_feedback_names_them(
    context: Any,
) -> None:
    ours = interface(BLOCKS)
    assert set(ours.varyings) == set(ours.vertex_outputs) == {"Out.normal", "Out.uv"}
    assert ours.varyings["Out.uv"].array == 2
    context.program(vertex_shader=BLOCKS["vertex"], varyings=sorted(ours.vertex_outputs))


def test_the_geometry_stages_outputs_are_what_is_rasterised(context: Any) -> None:
    ours = interface(FEEDBACK)
    assert set(ours.vertex_outputs) == {"shade"}
    assert (ours.vertex_outputs["shade"].type, ours.vertex_outputs["shade"].array) == ("vec3", None)
    context.program(
        vertex_shader=FEEDBACK["vertex"],
        geometry_shader=FEEDBACK["geometry"],
        varyings=["shade"],
    )


def test_a_compute_program_has_a_size_and_blocks(context: Any) -> None:
    text = (
        "#version 430 core\nlayout (local_size_x = 8, local_size_y = 4) in;\n"
        "layout (std430, binding = 1) buffer Data { vec4 items[]; };\nuniform float gain;\n"
        "void main() { items[gl_GlobalInvocationID.x] *= gain; }\n"
    )
    ours = interface({"compute": text})
    assert ours.local_size == (8, 4, 1)
    assert ours.blocks["Data"].used
    members = context.compute_shader(text)
    assert {name for name in members if isinstance(members[name], moderngl.Uniform)} == set(
        ours.uniforms
    )


CROSSED = {
    "vertex": """#version 430 core
out vec2 uv;
out vec3 tint;
uniform vec3 base;
uniform float unlike[3];
void main() {
    uv = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
    tint = base + unlike[1];
    gl_Position = vec4(uv, 0.0, 1.0);
}
""",
    "fragment": """#version 430 core
in vec3 tint;
in vec2 uv;
uniform float gain;
uniform vec3 base;
out vec4 c;
void main() { c = vec4(tint * gain - base, uv.x + 1.0); }
""",
}


def test_a_driver_runs_the_modules_and_gets_the_varyings_and_uniforms_right(context: Any) -> None:
    """glslang alone would give `uv` the location of `tint`, and `base` that of `gain`."""
    if "GL_ARB_gl_spirv" not in context.extensions:
        pytest.skip("this driver takes no SPIR-V")
    sources = [Shaders([]).from_text(text, stage, stage) for stage, text in CROSSED.items()]
    compiled = compile_program(sources)
    compiled.require()
    assert compiled.interface is not None
    pixels = _draw(context, compiled.spirv["opengl"], compiled.interface)
    # tint = (1, 2, 3) + 0.5, times 2, less (1, 2, 3); the last is uv.x + 1 at a pixel's middle.
    expected = np.broadcast_to(np.array([2.0, 3.0, 4.0], np.float32), (4, 4, 3))
    np.testing.assert_array_equal(pixels[..., :3], expected)
    middles = np.array([0.25, 0.75, 1.25, 1.75], np.float32)
    np.testing.assert_allclose(pixels[..., 3], np.broadcast_to(middles, (4, 4)), rtol=1e-6)


def _draw(context: Any, modules: Mapping[str, bytes], interface: Interface) -> Any:
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")  # read when OpenGL is first imported
    from OpenGL import GL
    from OpenGL.GL.ARB import gl_spirv

    kinds = {"vertex": GL.GL_VERTEX_SHADER, "fragment": GL.GL_FRAGMENT_SHADER}
    program = GL.glCreateProgram()
    for stage, module in modules.items():
        shader = GL.glCreateShader(kinds[stage])
        words = np.frombuffer(module, np.uint8)
        handles = np.array([shader], np.uint32)
        GL.glShaderBinary(
            1, handles, gl_spirv.GL_SHADER_BINARY_FORMAT_SPIR_V_ARB, words, words.size
        )
        gl_spirv.glSpecializeShaderARB(shader, b"main", 0, None, None)
        assert GL.glGetShaderiv(shader, GL.GL_COMPILE_STATUS), GL.glGetShaderInfoLog(shader)
        GL.glAttachShader(program, shader)
    GL.glLinkProgram(program)
    assert GL.glGetProgramiv(program, GL.GL_LINK_STATUS), GL.glGetProgramInfoLog(program)
    place = {name: uniform.location for name, uniform in interface.uniforms.items()}
    target = context.simple_framebuffer((4, 4), components=4, dtype="f4")
    target.use()
    GL.glUseProgram(program)
    GL.glUniform3f(place["base"], 1.0, 2.0, 3.0)
    GL.glUniform1f(place["gain"], 2.0)
    GL.glUniform1fv(place["unlike"], 3, np.array([9.0, 0.5, 9.0], np.float32))
    vertices = GL.glGenVertexArrays(1)
    GL.glBindVertexArray(vertices)
    GL.glDrawArrays(GL.GL_TRIANGLES, 0, 3)
    pixels = np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(4, 4, 4)
    GL.glDeleteVertexArrays(1, [vertices])
    GL.glUseProgram(0)
    GL.glDeleteProgram(program)
    target.release()
    return pixels
