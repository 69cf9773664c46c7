"""Images of compute passes: what they are given, what is left in them, mistakes noticed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Case,
    Output,
    Pixel,
    Target,
    TextureArray,
    Variant,
    compute,
    exact,
    formula,
    fullscreen,
    measure,
    value,
)
from shaderlab.drivers.programs.storage import FORMATS
from shaderlab.engine.catalogue import load_case
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import ivec3, uvec4, vec3, vec4, where
from shaderlab.glslmath.sampling import imageLoad, imageSize, texture
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record
from shaderlab.mutation.judging import Judge
from shaderlab.mutation.shader_mutants import mutate_case
from tests.meta.examples import File, examples

HEAD = "#version 430 core\nlayout (local_size_x = 4, local_size_y = 2) in;\n"
PLACE = "ivec2 p = ivec2(gl_GlobalInvocationID.xy);"
LAYERED = f"""{HEAD}
layout (rgba32f) uniform image3D volume;
layout (r32i) uniform iimage2DArray sums;
layout (rgba8) readonly uniform image2D colour;
layout (std430) buffer Total {{ uint total; }};
uniform int depth;
uniform float scale;
void main() {{
    {PLACE}
    for (int z = 0; z < depth; z++) {{
        vec4 before = imageLoad(volume, ivec3(p, z));
        imageStore(volume, ivec3(p, z), before * scale + vec4(p, z, 0.0));
        imageAtomicAdd(sums, ivec3(p, 1), z + 1);
    }}
    if (imageLoad(colour, p).r > 0.5) atomicAdd(total, 1u);
}}
"""
RANDOM = np.random.default_rng(20)
VOLUME = RANDOM.random((3, 4, 8, 4), np.float32)
COLOUR = RANDOM.random((4, 8, 4), np.float32)
GIVEN: dict[str, Any] = {
    "groups": (2, 2, 1),
    "uniforms": {"depth": 3, "scale": 0.7},
    "buffers": {"total": 0},
    "images": {"volume": VOLUME, "sums": np.ones((2, 4, 8)), "colour": COLOUR},
}


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions()) as made:
        yield made


def run(lab: SceneRunner, folder: Path, text: str, *expect: Any, **given: Any) -> Record:
    """The record of one shader's dispatch, or of given passes of it."""
    (folder / "t.comp").write_text(text)
    passes = given.pop("passes", None) or compute("t.comp", **{"groups": (1, 1, 1), **given})
    case = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect)
    lab.forget_shaders()
    record = lab.run(case.scene("default"))
    print(record.message, *record.expectations, sep="\n")
    return record


def failed(record: Record) -> list[str]:
    assert record.status in ("pass", "fail"), record.message
    return [o.name for o in record.expectations if o.status == "fail"]


def scaled(volume: Any, texel: Any, scale: Any) -> Any:
    return imageLoad(volume, texel) * scale + vec4(texel.x, texel.y, texel.z, 0.0)


def miscounted(total: Any) -> float:
    codes = np.rint(COLOUR[..., 0] * 255.0)
    return float(abs(total.item() - (codes > 127.5).sum()))


# The guide's example ------------------------------------------------------------------------


@pytest.fixture
def guide(repository: Path, tmp_path: Path) -> Path:
    for each in examples(repository / "docs" / "guide" / "stages.md"):
        if isinstance(each, File) and each.name.startswith("relief"):
            (tmp_path / each.name).write_text(each.text, encoding="utf-8")
    return tmp_path


def test_the_guides_example_passes_and_shows_its_images(guide: Path, tmp_path: Path) -> None:
    with SceneRunner(RunOptions(folder=tmp_path / "out")) as lab:
        (record,) = (lab.run(scene) for scene in load_case(guide / "relief.py").scenes())
    assert record.status == "pass", record
    assert record.unread == ()
    assert [a.name for a in record.passes[0].attachments] == ["slope", "steep"]
    assert record.passes[1].reads == ("relief.slope",)


@pytest.mark.parametrize(
    ("right", "wrong", "noticed"),
    [
        ("p + ivec2(1, 0)", "p + ivec2(0, 1)", "relief.slope"),
        ("imageStore(slope, p,", "imageStore(slope, p.yx,", "relief.slope"),
        ("imageAtomicAdd(steep, ivec2(0), 1u)", "imageStore(steep, ivec2(0), uvec4(1))",
         "relief.steep"),
        ("> 0.02", "> 0.021", "relief.steep"),
        ("local_size_x = 8", "local_size_x = 7", "relief.slope"),
    ],
)  # fmt: skip
def test_mistakes_in_a_shader_are_noticed(
    lab: SceneRunner, guide: Path, right: str, wrong: str, noticed: str
) -> None:
    shader = guide / "relief.comp"
    assert right in shader.read_text()
    shader.write_text(shader.read_text().replace(right, wrong))
    lab.forget_shaders()
    assert noticed in failed(lab.run(load_case(guide / "relief.py").scene("default")))


def test_mutants_of_a_shader_of_images_are_judged(lab: SceneRunner, guide: Path) -> None:
    lab.forget_shaders()
    case = load_case(guide / "relief.py")
    judge = Judge(lab, case)
    mutants = [m for m in mutate_case(case) if m.shader == "relief.comp"]
    fates = {f"{m.line}: {m.after}": judge.judge(m).status for m in mutants}
    survivors = [m for m, fate in fates.items() if fate == "survived"]
    assert list(fates.values()).count("killed") > 40
    assert survivors == ["15: right - here >= 0.02"]  # no slope is that to the last bit


# Kinds and formats --------------------------------------------------------------------------


def test_layers_are_judged_texel_by_texel(lab: SceneRunner, tmp_path: Path) -> None:
    sums = np.stack([np.ones((4, 8), int), np.full((4, 8), 7)]).reshape(8, 8)
    counted = measure("counted wrongly", miscounted, equals=0, digits=0)
    expect = [formula("volume", scaled), exact("sums", sums), counted]
    record = run(lab, tmp_path, LAYERED, *expect, **GIVEN)
    assert failed(record) == [] and record.unread == ()
    for right, wrong, noticed in (
        ("imageStore(volume, ivec3(p, z)", "imageStore(volume, ivec3(p, depth - 1 - z)", "volume"),
        ("imageAtomicAdd(sums, ivec3(p, 1)", "imageAtomicAdd(sums, ivec3(p, 0)", "sums"),
        ("imageLoad(colour, p).r", "imageLoad(colour, p).g", "counted wrongly"),
    ):
        text = LAYERED.replace(right, wrong)
        assert text != LAYERED and noticed in failed(run(lab, tmp_path, text, *expect, **GIVEN))


@pytest.mark.parametrize("word", FORMATS)
def test_each_format_keeps_what_is_given_and_what_is_stored(
    lab: SceneRunner, tmp_path: Path, word: str
) -> None:
    letter = "u" if word.endswith("ui") else "i" if word.endswith("i") else ""
    count = {"r": 1, "rg": 2, "rgba": 4}[word.rstrip("0123456789uif")]
    kind = f"layout ({word}) uniform {letter}image2D"
    text = f"""{HEAD}{kind} given; {kind} made;
    void main() {{ {PLACE} imageStore(made, p.yx, imageLoad(given, p)); }}
    """
    numbers = RANDOM.integers(0, 255, (2, 4, count))
    held = numbers if letter else numbers.astype(np.float32) / 255.0
    codes = numbers.astype(np.uint8)
    stored = codes if word.endswith("8") else held.astype("f2" if word.endswith("16f") else "f4")
    images = {"given": held, "made": np.zeros((4, 2, count))}
    wanted = numbers if letter else stored
    expect = exact("made", wanted.swapaxes(0, 1))
    assert failed(run(lab, tmp_path, text, expect, images=images)) == []
    turned = text.replace("p.yx", "p")
    assert failed(run(lab, tmp_path, turned, expect, images=images)) == ["made"]


def test_an_image_without_a_layout_is_as_wide_as_can_be(lab: SceneRunner, tmp_path: Path) -> None:
    text = f"{HEAD}writeonly uniform uimage2D ids;\n"
    text += f"void main() {{ {PLACE} imageStore(ids, p, uvec4(p, imageSize(ids))); }}\n"

    def ids(texel: Any, ids: Any) -> Any:
        size = imageSize(ids)
        return uvec4(texel.x, texel.y, size.x, size.y)

    images = {"ids": lambda: np.zeros((2, 4, 4))}
    assert failed(run(lab, tmp_path, text, formula("ids", ids), images=images)) == []


def test_what_lies_outside_is_read_as_zeros_and_is_not_written(
    lab: SceneRunner, tmp_path: Path
) -> None:
    text = f"""{HEAD}layout (r32f) uniform image2D a;
    void main() {{ {PLACE} imageStore(a, p - 1, imageLoad(a, p + ivec2(4, 0)) + 1.0); }}
    """

    given = {"images": {"a": np.full((2, 4), 2.0)}}
    held = [[1, 1, 1, 2], [2, 2, 2, 2]]
    assert failed(run(lab, tmp_path, text, exact("a", np.array(held)[..., None]), **given)) == []


def test_a_variant_changes_what_an_image_holds(lab: SceneRunner, tmp_path: Path) -> None:
    text = f"""{HEAD}layout (r32f) restrict uniform image2D a;
    void main() {{ {PLACE} imageStore(a, p, 2.0 * imageLoad(a, p)); }}
    """
    (tmp_path / "t.comp").write_text(text)
    passes = compute("t.comp", groups=(1, 1, 1), images={"a": np.zeros((2, 4))})
    ones = Variant("ones", {"a": np.ones((2, 4))}, expect=[exact("a", 2.0)])
    case = Case(
        title="t", id="t", file=str(tmp_path / "t.py"), passes=passes, variants=[ones], expect=[]
    )
    lab.forget_shaders()
    assert failed(lab.run(case.scene("ones"))) == []
    (tmp_path / "t.comp").write_text(text.replace("2.0 *", "3.0 *"))
    lab.forget_shaders()
    assert failed(lab.run(case.scene("ones"))) == ["a"]


# From pass to pass --------------------------------------------------------------------------


def test_later_passes_read_images_as_images_and_as_textures(
    lab: SceneRunner, tmp_path: Path
) -> None:
    (tmp_path / "first.comp").write_text(LAYERED)
    array = "#version 330 core\nin vec2 TexCoords; uniform sampler2DArray s; out vec4 c;\n"
    array += "void main() { c = texture(s, vec3(TexCoords, 2.0)); }\n"
    (tmp_path / "t.frag").write_text(array)
    text = f"""{HEAD}layout (rgba32f) uniform image3D volume;
    layout (rgba8) uniform image2D drawn;
    void main() {{
        {PLACE}
        imageStore(volume, ivec3(p, 0), imageLoad(volume, ivec3(p, 2)) + imageLoad(drawn, p));
    }}
    """

    def doubled(volume: Any, texel: Any, drawn: Any) -> Any:
        summed = imageLoad(volume, ivec3(texel.xy, 2)) + imageLoad(drawn, texel.xy)
        return where(texel.z == 0, summed, imageLoad(volume, texel))

    def third(s: Any, TexCoords: Any) -> Any:
        return texture(s, vec3(TexCoords, 2.0))

    first = compute("first.comp", name="first", **GIVEN)
    small = Target(size=(8, 4), colors={"c": "rgba8"})
    drawn = fullscreen("t.frag", textures={"s": Output("first.volume")}, name="d", target=small)
    images = {"volume": Output("first.volume"), "drawn": Output("d.c")}
    last = compute("t.comp", groups=(2, 2, 1), images=images)
    expect = [formula("d.c", third), formula("volume", doubled)]
    assert failed(run(lab, tmp_path, text, *expect, passes=(*first, *drawn, *last))) == []
    wrong = text.replace("ivec3(p, 2)", "ivec3(p, 1)")
    record = run(lab, tmp_path, wrong, *expect, passes=(*first, *drawn, *last))
    assert failed(record) == ["volume"]


# What is refused ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"volume": None}, "t.comp: nothing is given for image volume (image3D)"),
        ({"volumes": VOLUME}, "t.comp: there is no image 'volumes'"),
        ({"volume": VOLUME[0]}, "image 'volume' is an image3D: it takes an array (layers, height"),
        ({"volume": "a.png"}, "it takes an array (layers, height, width, 4), no file"),
        ({"colour": COLOUR[..., :3]}, "a rgba8 texture takes (height, width, 4), not (4, 8, 3)"),
        ({"sums": np.full((2, 4, 8), 0.5)}, "image 'sums' is r32i, which holds not all of what"),
        ({"colour": Output("later.c")}, "no earlier pass gives later.c"),
    ],
)
def test_what_does_not_fit_is_an_error(
    lab: SceneRunner, tmp_path: Path, change: dict[str, Any], said: str
) -> None:
    images = {n: v for n, v in {**GIVEN["images"], **change}.items() if v is not None}
    record = run(lab, tmp_path, LAYERED, exact("total", 0), **{**GIVEN, "images": images})
    assert record.status == "error" and said in record.message, record.message


def test_outputs_that_do_not_fit_are_errors(lab: SceneRunner, tmp_path: Path) -> None:
    (tmp_path / "first.comp").write_text(LAYERED)
    first = compute("first.comp", name="first", **GIVEN)
    images = {**GIVEN["images"], "colour": Output("first.volume")}
    second = compute("t.comp", **{**GIVEN, "images": images})
    record = run(lab, tmp_path, LAYERED, exact("total", 0), passes=(*first, *second))
    said = "is an image2D of rgba8, but first.volume has 4 components of float32 in 3 layers"
    assert record.status == "error" and said in record.message, record.message
    (tmp_path / "t.frag").write_text(
        "#version 330 core\nin vec2 TexCoords; uniform sampler2DArray s; out vec4 c;\n"
        "void main() { c = texture(s, vec3(TexCoords, 0.0)); }\n"
    )
    stacked = TextureArray(layers=[Output("first.volume")])
    passes = (*first, *fullscreen("t.frag", textures={"s": stacked}))
    record = run(lab, tmp_path, LAYERED, exact("c", 0.0), passes=passes)
    assert "an image of 3 layers is no layer of another" in record.message, record.message


@pytest.mark.parametrize(
    ("declared", "said"),
    [
        ("layout (rgba32f) uniform image1D a;", "a is an image1D; compute passes have image2D"),
        ("layout (rgba32f) uniform imageCube a;", "a is an imageCube"),
        ("layout (rgb10_a2) uniform image2D a;", "a has the format rgb10_a2"),
        ("layout (r32f) uniform image2D a[2];", "a is an array of images"),
    ],
)
def test_what_is_not_supported_is_named(
    lab: SceneRunner, tmp_path: Path, declared: str, said: str
) -> None:
    name, at = ("a[1]" if "[2]" in declared else "a"), "0"
    at = {"image1D": "0", "imageCube": "ivec3(0)"}.get(declared.split()[3], "ivec2(0)")
    text = f"{HEAD}{declared}\nvoid main() {{ imageStore({name}, {at}, vec4(1.0)); }}\n"
    record = run(lab, tmp_path, text, exact("a", 0), images={"a": np.zeros((2, 4))})
    assert record.status == "unsupported" and said in record.message, record.message


def test_images_of_a_fragment_stage_are_not_supported_by_name(
    lab: SceneRunner, tmp_path: Path
) -> None:
    (tmp_path / "t.frag").write_text(
        "#version 430 core\nlayout (r32f) uniform image2D a; out vec4 c;\n"
        "void main() { c = imageLoad(a, ivec2(0)); }\n"
    )
    record = run(lab, tmp_path, LAYERED, exact("c", 0.0), passes=fullscreen("t.frag"))
    assert record.status == "unsupported"
    assert "t.frag: a is an image2D; compute passes alone have images" in record.message


def test_an_image_that_is_only_read_is_no_output(lab: SceneRunner, tmp_path: Path) -> None:
    record = run(lab, tmp_path, LAYERED, exact("colour", 0), **GIVEN)
    assert (
        record.status == "error" and "there is no output 'colour'" in record.expectations[0].message
    )


def test_single_texels_have_their_reference(lab: SceneRunner, tmp_path: Path) -> None:
    text = f"""{HEAD}layout (r32f) uniform image2D a; layout (std430) buffer B {{ float b[]; }};
    void main() {{ {PLACE} imageStore(a, p, imageLoad(a, p) * b[p.y * 4 + p.x]); }}
    """

    def product(a: Any, b: Any, texel: Any) -> Any:
        return imageLoad(a, texel).x * b

    held = np.arange(8.0).reshape(2, 4)
    given = {"images": {"a": held}, "buffers": {"b": np.arange(8.0) + 0.1}}
    one = value("a", reference=product, equals=6 * 6.1, digits=4, at=Pixel(2, 1))
    assert failed(run(lab, tmp_path, text, one, formula("a", product), **given)) == []
    other = text.replace("imageLoad(a, p) *", "imageLoad(a, p + ivec2(1, 0)) *")
    assert len(failed(run(lab, tmp_path, other, one, formula("a", product), **given))) == 2
