"""Every kind of texture on a driver: what shaders sample lies in the references' bands, and wrong
filters, wraps, levels, faces and comparisons do not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    CompressedTexture,
    CubeTexture,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    Pixel,
    Ramp,
    State,
    Target,
    Texture,
    TextureArray,
    exact,
    formula,
    fullscreen,
    value,
)
from shaderlab.compiler import Shaders
from shaderlab.drivers.opengl import textures as opengl_textures
from shaderlab.drivers.programs.prepare import Preparer
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import swizzle
from shaderlab.glslmath.sampling import Sampler, texelFetch, texture, textureLod
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

RNG = np.random.default_rng(11)
HEAD = "#version 330 core\nout vec4 FragColor;\n"
SHADERS = {
    "plain": "in vec2 p; uniform sampler2D image;\nvoid main() { FragColor = texture(image, p); }",
    "level": "in vec3 p; uniform sampler2D image;\n"
    "void main() { FragColor = textureLod(image, p.xy, p.z); }",
    "stack": "in vec3 p; uniform sampler2DArray image;\n"
    "void main() { FragColor = texture(image, p); }",
    "cube": "in vec3 p; uniform samplerCube image;\n"
    "void main() { FragColor = textureLod(image, p, 0.0); }",
    "shadow": "in vec3 p; uniform sampler2DShadow image;\n"
    "void main() { FragColor = vec4(texture(image, p)); }",
    "layers": "in vec3 p; uniform sampler2DArrayShadow image;\n"
    "void main() { FragColor = vec4(texture(image, vec4(p, 0.5))); }",
    "fetch": "in vec2 p; uniform sampler2D image; uniform int level;\nvoid main() {"
    " FragColor = texelFetch(image, ivec2(gl_FragCoord.xy) % textureSize(image, level), level); }",
    "samples": "in vec2 p; uniform sampler2DMS image; uniform int number;\n"
    "void main() { FragColor = texelFetch(image, ivec2(gl_FragCoord.xy), number); }",
    "colour": "in vec4 p;\nvoid main() { FragColor = p; }",
    "white": "void main() { FragColor = vec4(1.0); }",
}
PLACED = "#version 330 core\nin vec3 aPos;\nvoid main() { gl_Position = vec4(aPos, 1.0); }\n"
TILTED = Mesh(
    attributes={"aPos": np.array([(-1, -1, -0.9), (1, -1, -0.2), (1, 1, 0.8), (-1, 1, 0.1)])},
    indices=np.array([0, 1, 2, 0, 2, 3]),
)
TRIANGLE = Mesh(attributes={"aPos": np.array([(-1, -1, 0.0), (0.7, -1, 0.3), (-1, 0.9, 0.6)])})
# Texel edges would fall on pixel centres at a rounder number.
WIDE = {"p": Ramp((-1.53, -0.71), (4.04, 0.31), (0.17, 2.23))}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("shaders")
    (made / "placed.vert").write_text(PLACED)
    for name, text in SHADERS.items():
        (made / f"{name}.frag").write_text(HEAD + text)
    return made


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


def run(lab: SceneRunner, folder: Path, passes: Any, *expect: Any) -> Record:
    made = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)
    return lab.run(made.scene("default"))


def noise(*shape: int) -> Any:
    return RNG.random(shape).astype(np.float32)


def sampled(image: Any, p: Any) -> Any:
    return texture(image, p)


def spread(image: Any, p: Any) -> Any:
    return texture(image, p) * np.ones(4)


def otherwise(reference: Callable[..., Any], **changes: Any) -> Callable[..., Any]:
    """The reference, with the texture's sampling changed: it must not hold any more."""

    def wrong(image: Any, p: Any) -> Any:
        return reference(Sampler(replace(image.texels, **changes), image.rules), p)

    return wrong


@pytest.mark.parametrize("wrap", ["repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border"])
@pytest.mark.parametrize("word", ["nearest", "linear"])
def test_every_filter_and_wrap(lab: SceneRunner, folder: Path, word: str, wrap: str) -> None:
    image = Texture(
        image=noise(3, 5, 4), filter=(word, word), wrap=(wrap, wrap), border=(0.4, 3.0, -2.0, 9.0)
    )
    passes = fullscreen("plain.frag", domain=WIDE, textures={"image": image})
    assert run(lab, folder, passes, formula("FragColor", sampled)).status == "pass"
    other = "linear" if word == "nearest" else "nearest"
    turned = "repeat" if wrap != "repeat" else "mirrored_repeat"
    for changes in ({"filter": (other, other)}, {"wrap": (turned, wrap)}, {"wrap": (wrap, turned)}):
        wrong = formula("FragColor", otherwise(sampled, **changes))
        assert run(lab, folder, passes, wrong).status == "fail", changes


@pytest.mark.parametrize("between", ["nearest", "linear"])
@pytest.mark.parametrize("within", ["nearest", "linear"])
def test_every_mipmap_filter(lab: SceneRunner, folder: Path, within: str, between: str) -> None:
    def at_level(image: Any, p: Any) -> Any:
        return textureLod(image, swizzle(p, "xy"), swizzle(p, "z"))

    filters = (f"{within}_mipmap_{between}", "linear")
    levels = [noise(4, 6, 4), noise(2, 3, 4), noise(1, 1, 4)]
    image = Texture(image=noise(8, 12, 4), mipmaps=levels, filter=filters, lod=(-1.0, 1.6))
    domain = {"p": Ramp((0.03, 0.07, -0.93), (1.31, 0.2, 0.11), (0.2, 1.43, 4.91))}
    passes = fullscreen("level.frag", domain=domain, textures={"image": image})
    assert run(lab, folder, passes, formula("FragColor", at_level)).status == "pass"
    turned = {"nearest": "linear", "linear": "nearest"}
    for words in ((turned[within], between), (within, turned[between])):
        wrong = otherwise(at_level, filter=("_mipmap_".join(words), "linear"))
        assert run(lab, folder, passes, formula("FragColor", wrong)).status == "fail", words
    free = otherwise(at_level, lod=(-1000.0, 1000.0))
    assert run(lab, folder, passes, formula("FragColor", free)).status == "fail"


def test_generated_levels_are_read_back(lab: SceneRunner, folder: Path) -> None:
    image = noise(8, 8, 4)
    mean = image.reshape(4, 2, 4, 2, 4).mean((1, 3))

    def fetched(image: Any, frag_coord: Any, level: Any) -> Any:
        half = np.floor(image.texels.smaller[0].shape[0])
        place = np.mod(np.floor(frag_coord.lo if image.rules else frag_coord)[:, :2], half)
        return texelFetch(image, place, 1)

    passes = fullscreen(
        "fetch.frag",
        textures={"image": Texture(image=image, mipmaps=True)},
        uniforms={"level": 1},
        domain={"p": Ramp((0.0, 0.0))},
    )
    assert run(lab, folder, passes, formula("FragColor", fetched)).status == "pass"
    for x, y in ((0, 0), (3, 1)):
        figure = value("FragColor", at=Pixel(x, y), equals=mean[y, x].tolist(), digits=5)
        assert run(lab, folder, passes, figure).status == "pass"


@pytest.mark.parametrize("seamless", [True, False])
def test_cubes(lab: SceneRunner, folder: Path, seamless: bool) -> None:
    faces = [noise(4, 4, 4) for _ in range(6)]
    for word in ("nearest", "linear"):
        image = CubeTexture(faces=faces, filter=(word, word), seamless=seamless)
        for sign in (1.0, -1.0):
            origin = (-1.31 * sign, -1.23 * sign, sign)
            domain = {"p": Ramp(origin, (2.7, 0.11, -0.2 * sign), (0.13, 2.51, 0.7))}
            passes = fullscreen("cube.frag", domain=domain, textures={"image": image})
            record = run(lab, folder, passes, formula("FragColor", sampled))
            assert record.status == "pass", record
        if word == "linear":
            wrong = formula("FragColor", otherwise(sampled, seamless=not seamless))
            assert run(lab, folder, passes, wrong).status == "fail"
        turned = np.stack(faces)[[1, 0, 2, 3, 5, 4]]
        wrong = formula("FragColor", otherwise(sampled, values=turned))
        assert run(lab, folder, passes, wrong).status == "fail"


def test_arrays(lab: SceneRunner, folder: Path) -> None:
    image = TextureArray(layers=[noise(2, 3, 4) for _ in range(3)], filter=("linear", "linear"))
    domain = {"p": Ramp((0.1, 0.1, -0.83), (1.0, 0.3, 0.01), (0.1, 1.0, 3.71))}
    passes = fullscreen("stack.frag", domain=domain, textures={"image": image})
    assert run(lab, folder, passes, formula("FragColor", sampled)).status == "pass"
    wrong = otherwise(sampled, filter=("nearest", "nearest"))
    assert run(lab, folder, passes, formula("FragColor", wrong)).status == "fail"


@pytest.mark.parametrize("format", ["depth16", "depth24", "depth32f"])
@pytest.mark.parametrize("word", ["nearest", "linear"])
def test_shadow_samplers(lab: SceneRunner, folder: Path, word: str, format: str) -> None:
    """With LINEAR, whatever lies between the texels' verdicts is allowed: where these differ a
    value says nothing, and such an image alone would be no check."""
    depths = noise(4, 4, 1)
    image = Texture(image=depths, format=format, filter=(word, word), compare="lequal")
    domain = {"p": Ramp((-0.53, 0.07, -0.1), (1.91, 0.1, 0.4), (0.1, 0.83, 0.73))}
    passes = fullscreen("shadow.frag", domain=domain, textures={"image": image})
    (right,) = run(lab, folder, passes, formula("FragColor", spread)).expectations
    assert right.judged and right.outside == 0, right
    assert right.status == ("pass" if word == "nearest" else "fail"), right.message
    mistakes: list[dict[str, Any]] = [{"compare": "greater"}, {"wrap": ("clamp_to_border",) * 2}]
    for changes in mistakes:
        formula_ = formula("FragColor", otherwise(spread, **changes))
        (wrong,) = run(lab, folder, passes, formula_).expectations
        assert wrong.outside > 0, changes


def shadow_pass(format: str) -> Pass:
    draw = Draw(
        vertex="placed.vert", fragment="white.frag", mesh=TILTED, state=State(depth=Depth())
    )
    return Pass(name="shadow", target=Target(depth=format), draws=(draw,))


def depth_of(frag_coord: Any) -> Any:
    return swizzle(frag_coord, "z")


@pytest.mark.parametrize(
    "format", ["depth16", "depth24", "depth32f", "depth24_stencil8", "depth32f_stencil8"]
)
def test_a_depth_attachment_is_an_output(lab: SceneRunner, folder: Path, format: str) -> None:
    if format == "depth16" and "softpipe" in lab.driver["renderer"]:
        pytest.skip("softpipe steps 16-bit depth from pixel to pixel in whole codes")
    copy = fullscreen(
        "plain.frag",
        name="copy",
        domain={"p": Ramp((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))},
        textures={"image": Output("shadow.depth")},
    )
    record = run(
        lab,
        folder,
        (shadow_pass(format), *copy),
        formula("shadow.depth", depth_of),
        formula("copy.FragColor", sampled),
        value("shadow.depth", at=Pixel(0, 0), equals=0.07, digits=1),
    )
    assert record.status == "pass", record

    def shifted(frag_coord: Any) -> Any:
        return swizzle(frag_coord, "z") + 0.0001

    wrong = formula("shadow.depth", shifted)
    assert run(lab, folder, (shadow_pass(format), *copy), wrong).status == "fail"


def test_a_depth_attachment_is_sampled_as_a_shadow_map(lab: SceneRunner, folder: Path) -> None:
    def lit(image: Any, p: Any) -> Any:
        return texture(image, p) * np.ones(4)

    for word in ("nearest", "linear"):
        source = Output("shadow.depth", compare="less", filter=(word, word))
        look = fullscreen(
            "shadow.frag",
            name="look",
            domain={"p": Ramp((0.01, 0.02, 0.21), (0.97, 0.0, 0.5), (0.0, 0.95, 0.2))},
            textures={"image": source},
        )
        passes = (shadow_pass("depth24"), *look)
        (found,) = run(lab, folder, passes, formula("look.FragColor", lit)).expectations
        assert found.judged and found.outside == 0 and found.informative > 0.8, found


def test_depth_is_read_only_where_it_is_asked_for(lab: SceneRunner, folder: Path) -> None:
    record = run(lab, folder, (shadow_pass("depth24"),), formula("FragColor", ones))
    assert record.status == "pass", record
    scene = Case(
        title="t",
        file=str(folder / "t.py"),
        passes=(shadow_pass("depth24"),),
        expect=[exact("FragColor", 1.0)],
    ).scene("default")
    preparer = Preparer(Shaders([folder]))
    prepared = {"shadow": tuple(preparer.prepare(draw) for draw in scene.passes[0].draws)}
    with lab.backend.session(scene, prepared, (4, 4)) as session:
        assert set(session.draw().images) == {("shadow", "FragColor")}


def ones(frag_coord: Any) -> Any:
    return swizzle(frag_coord, "xyzw") * 0.0 + 1.0


def test_earlier_passes_fill_faces_and_layers(lab: SceneRunner, folder: Path) -> None:
    def drawn(name: str, start: float) -> tuple[Pass, ...]:
        return fullscreen(
            "colour.frag",
            name=name,
            domain={"p": Ramp((start, 0.0, 0.1, 1.0), (0.3, 0.2, 0.0, 0.0), (0.0, 0.5, 0.3, 0.0))},
            target=Target(size=(8, 8)),
        )

    names = [f"face{n}" for n in range(6)]
    parts = tuple(p for n, name in enumerate(names) for p in drawn(name, 0.1 * n))
    outputs = [Output(f"{name}.FragColor") for name in names]
    cube = fullscreen(
        "cube.frag",
        name="cube",
        domain={"p": Ramp((-1.31, -1.23, 1.0), (2.7, 0.11, 0.3), (0.13, 2.51, 0.7))},
        textures={"image": CubeTexture(faces=outputs, filter=("linear", "linear"))},
    )
    stack = fullscreen(
        "stack.frag",
        name="stack",
        domain={"p": Ramp((0.1, 0.1, -0.3), (1.0, 0.3, 0.01), (0.1, 1.0, 5.4))},
        textures={"image": TextureArray(layers=outputs)},
    )
    record = run(
        lab, folder, (*parts, *cube, *stack),
        formula("cube.FragColor", sampled), formula("stack.FragColor", sampled),
    )  # fmt: skip
    assert record.status == "pass", record


def test_depths_of_earlier_passes_are_layers_of_a_shadow_array(
    lab: SceneRunner, folder: Path
) -> None:
    def lit(image: Any, p: Any) -> Any:
        from shaderlab.glslmath import vec4

        return texture(image, vec4(p, 0.5)) * np.ones(4)

    layers = [Output("shadow.depth"), np.full((16, 16), 0.6)]
    image = TextureArray(layers=layers, format="depth24", compare="less")
    look = fullscreen(
        "layers.frag",
        name="look",
        domain={"p": Ramp((0.01, 0.02, 0.0), (0.97, 0.0, 0.0), (0.0, 0.95, 1.0))},
        textures={"image": image},
    )
    record = run(lab, folder, (shadow_pass("depth24"), *look), formula("look.FragColor", lit))
    assert record.status == "pass", record


def test_an_outputs_own_levels(lab: SceneRunner, folder: Path) -> None:
    drawn = fullscreen(
        "colour.frag",
        name="drawn",
        domain={"p": Ramp((0.0, 0.2, 0.4, 1.0), (1.0, 0.2, 0.0, 0.0), (0.0, 0.7, 0.3, 0.0))},
    )

    def at_level(image: Any, p: Any) -> Any:
        return textureLod(image, swizzle(p, "xy"), swizzle(p, "z"))

    source = Output("drawn.FragColor", filter=("linear_mipmap_linear", "linear"), mipmaps=True)
    look = fullscreen(
        "level.frag",
        name="look",
        domain={"p": Ramp((0.03, 0.07, 0.3), (0.91, 0.1, 0.1), (0.1, 0.83, 3.1))},
        textures={"image": source},
    )
    record = run(lab, folder, (*drawn, *look), formula("look.FragColor", at_level))
    assert record.status == "pass", record


def test_every_sample_of_a_multisampled_target(lab: SceneRunner, folder: Path) -> None:
    if int(lab.backend.info["max_samples"]) < 4:
        pytest.skip("this driver takes one sample a pixel")
    draw = Draw(vertex="placed.vert", fragment="white.frag", mesh=TRIANGLE)
    drawn = Pass(name="drawn", target=Target(samples=4), draws=(draw,))

    def one_sample(image: Any, frag_coord: Any, number: Any) -> Any:
        place = frag_coord.lo if image.rules else frag_coord
        which = number.lo if image.rules else number
        return texelFetch(image, np.floor(place[:, :2]), which)

    def look(number: int) -> tuple[Pass, ...]:
        return fullscreen(
            "samples.frag",
            name=f"look{number}",
            domain={"p": Ramp((0.0, 0.0))},
            textures={"image": Output("drawn.FragColor")},
            uniforms={"number": number},
        )

    passes = (drawn, *(p for n in range(4) for p in look(n)))
    record = run(
        lab, folder, passes, *(formula(f"look{n}.FragColor", one_sample) for n in range(4))
    )
    assert record.status == "pass", record
    same = exact("look0.FragColor", Output("look3.FragColor"))
    assert run(lab, folder, passes, same).status == "fail"


@pytest.mark.parametrize(
    ("shader", "image", "says"),
    [
        ("cube", Texture(image=noise(2, 2, 4)), ("samplerCube", "Texture", "sampler2D")),
        ("plain", CubeTexture(faces=[noise(2, 2, 4)] * 6), ("sampler2D", "CubeTexture")),
        ("plain", Texture(image=np.ones((2, 2, 4), int), format="rgba32i"), ("isampler2D",)),
        (
            "shadow",
            Texture(image=noise(2, 2, 1), format="depth16"),
            ("compare=", "sampler2DShadow"),
        ),
        (
            "plain",
            Texture(image=noise(2, 2, 1), format="depth16", compare="less"),
            ("compare='less'", "sampler2DShadow"),
        ),
        ("stack", Texture(image=noise(2, 2, 4)), ("sampler2DArray", "sampler2D")),
        ("plain", TextureArray(layers=[noise(2, 2, 4), noise(3, 2, 4)]), ("sampler2D",)),
        ("stack", TextureArray(layers=[noise(2, 2, 4), noise(3, 2, 4)]), ("layer 1 is 2 × 3",)),
        ("plain", Texture(image=noise(4, 4, 4), mipmaps=[noise(2, 2, 4)]), ("2 × 2, 1 × 1",)),
        ("cube", CubeTexture(faces=[noise(2, 3, 4)] * 6), ("3 × 2, not square",)),
    ],
)
def test_a_texture_that_does_not_fit(
    lab: SceneRunner, folder: Path, shader: str, image: Any, says: tuple[str, ...]
) -> None:
    size = 2 if shader == "plain" else 3
    domain = {"p": Ramp((0.1,) * size)}
    passes = fullscreen(f"{shader}.frag", domain=domain, textures={"image": image})
    record = run(lab, folder, passes, exact("FragColor", 0.0))
    assert record.status == "error"
    for word in says:
        assert word in record.message, record.message


def test_a_dds_file_with_its_levels(lab: SceneRunner, folder: Path) -> None:
    """Two levels of plain colours, read by texelFetch: red, then blue."""
    import struct

    def plain(color: int) -> bytes:
        return struct.pack("<2HI", color, color, 0)

    head = struct.pack("<4s7I44x", b"DDS ", 124, 0x1007, 4, 8, 16, 0, 2)
    head += struct.pack("<2I4s5I", 32, 4, b"DXT1", 0, 0, 0, 0, 0) + bytes(20)
    (folder / "plain.dds").write_bytes(head + plain(0xF800) * 2 + plain(0x001F))
    for level, color in ((0, (1.0, 0.0, 0.0, 1.0)), (1, (0.0, 0.0, 1.0, 1.0))):
        passes = fullscreen(
            "fetch.frag",
            textures={"image": CompressedTexture(file="plain.dds")},
            uniforms={"level": level},
            domain={"p": Ramp((0.0, 0.0))},
        )
        assert run(lab, folder, passes, exact("FragColor", color)).status == "pass"
    passes = fullscreen(
        "plain.frag",
        textures={"image": CompressedTexture(blocks=[bytes(9)], format="bc1", size=(4, 4))},
        domain={"p": Ramp((0.0, 0.0))},
    )
    record = run(lab, folder, passes, exact("FragColor", 0.0))
    assert "takes 8 bytes, not 9" in record.message


def test_a_format_that_the_driver_lacks_names_its_extension(
    lab: SceneRunner, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from shaderlab.drivers.opengl import textures

    there_is_none = (0x8E8C, "GL_ARB_no_such_thing", 999)
    monkeypatch.setitem(textures.COMPRESSED, "bc7", there_is_none)
    passes = fullscreen(
        "plain.frag",
        textures={"image": CompressedTexture(blocks=[bytes(16)], format="bc7", size=(4, 4))},
        domain={"p": Ramp((0.0, 0.0))},
    )
    record = run(lab, folder, passes, exact("FragColor", 0.0))
    assert record.status == "unsupported" and "GL_ARB_no_such_thing" in record.message


def test_texels_of_blocks_are_those_that_samplers_decode(
    monkeypatch: pytest.MonkeyPatch, lab: SceneRunner, folder: Path
) -> None:
    """NVIDIA's glGetTexImage decodes BC1 in another way than its samplers do."""

    def decode_otherwise(*given: Any) -> Any:
        raise AssertionError("texels of blocks are read by glGetTexImage")

    monkeypatch.setattr(opengl_textures, "read_level", decode_otherwise)
    block = bytes((0x1F, 0xF8, 0x1F, 0x00)) + bytes(4 * [0b11100100])  # magenta and blue
    image = CompressedTexture(blocks=[block], format="bc1", size=(4, 4))
    passes = fullscreen("plain.frag", domain={"p": WIDE["p"]}, textures={"image": image})
    record = run(lab, folder, passes, formula("FragColor", sampled))
    assert (record.status, record.message) == ("pass", "")
