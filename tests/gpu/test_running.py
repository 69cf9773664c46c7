"""Real draws: state, capture, probes, targets, textures, and what goes wrong with them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Blend,
    Case,
    Cell,
    Depth,
    Draw,
    Mesh,
    Output,
    Pass,
    Pixel,
    State,
    Stencil,
    Target,
    Texture,
    across,
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
from shaderlab.drivers.opengl.backend import OpenGLBackend
from shaderlab.engine.run import SceneRunner
from shaderlab.glslmath import normalize, vec4
from shaderlab.glslmath.sampling import texture
from shaderlab.model import pictures
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

RAMP = """#version 330 core
in float x; in float y;
uniform float gain;
out vec4 FragColor; out float product;
void main() { FragColor = vec4(x, y, 0.0, 1.0); product = x * y * gain; }
"""
POINT = """#version 330 core
layout (location = 0) in vec3 aPos;
layout (location = 1) in vec3 aNormal;
uniform mat4 model;
out vec3 Normal; flat out int corner;
void main() { Normal = mat3(model) * aNormal; corner = gl_VertexID;
              gl_Position = model * vec4(aPos, 1.0); }
"""
SHADED = """#version 330 core
in vec3 Normal; flat in int corner;
out vec3 unit;
void main() { unit = normalize(Normal) * float(corner * 0 + 1); }
"""
FLAT = """#version 330 core
uniform vec4 color;
out vec4 FragColor;
void main() { FragColor = color; }
"""
SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
HALF = Mesh(attributes={"aPos": SQUARE * (0.5, 1.0, 1.0)}, indices=np.array([0, 1, 2, 0, 2, 3]))
PLACED = """#version 330 core
in vec3 aPos;
void main() { gl_Position = vec4(aPos, 1.0); }
"""


def product(x: Any, y: Any, gain: Any) -> Any:
    return x * y * gain


def unit(Normal: Any) -> Any:
    return normalize(Normal)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("shaders")
    for name, text in {
        "ramp.frag": RAMP,
        "point.vert": POINT,
        "shaded.frag": SHADED,
        "flat.frag": FLAT,
        "placed.vert": PLACED,
        "copy.frag": "#version 330 core\nin vec2 TexCoords; uniform sampler2D image;\n"
        "out vec4 FragColor;\nvoid main() { FragColor = texture(image, TexCoords); }\n",
    }.items():
        (made / name).write_text(text)
    return made


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16)) as made:
        yield made


def run(lab: SceneRunner, folder: Path, passes: Any, *expect: Any, **case: Any) -> Record:
    made = Case(title="t", id="t", file=str(folder / "t.py"), passes=passes, expect=expect, **case)
    return lab.run(made.scene("default"))


def ramp(**changes: Any) -> tuple[Pass, ...]:
    given = {"domain": {"x": across(0.0, 2.0), "y": up(1.0, 3.0)}, "uniforms": {"gain": 0.3}}
    return fullscreen("ramp.frag", **(given | changes))


def flat(color: tuple[float, ...], **draw: Any) -> Draw:
    return Draw(fragment="flat.frag", domain={}, uniforms={"color": color}, **draw)


def test_a_domain_reaches_the_shader_and_the_reference(lab: SceneRunner, folder: Path) -> None:
    record = run(
        lab,
        folder,
        ramp(),
        formula("product", product),
        value("FragColor", at=Pixel(0, 15), equals=(0.0625, 2.9375, 0, 1), digits=4),
        value("product", at={"x": 0.5, "y": 4.0}, equals=0.6, digits=6),
        sweep("product", product, over="x", values=(1.0, 2.0, 3.0), at={"y": 1.5}),
        sweep("product", product, over="gain", values=(1.0, 2.0)),
    )
    assert record.status == "pass", record
    assert record.curves[0].reference == pytest.approx((0.45, 0.9, 1.35))
    # Inputs that a sweep does not give stay at the middle of the screen: x = 1, y = 2.
    assert record.curves[1].measured == (2.0, 4.0)
    assert record.compile == dict.fromkeys(("glsl", "opengl", "vulkan", "driver"), "pass")


def test_a_wrong_formula_fails_with_the_pixel_and_its_inputs(
    lab: SceneRunner, folder: Path
) -> None:
    def wrong(x: Any, y: Any, gain: Any) -> Any:
        return x * y * gain * 1.000001

    outcome = run(lab, folder, ramp(), formula("product", wrong)).expectations[0]
    assert outcome.status == "fail"
    assert outcome.worst is not None and outcome.worst.pixel is not None
    assert set(outcome.worst.inputs) == {"x", "y", "gain"}
    formula_at, shader_at = outcome.sources
    assert formula_at.file.endswith("test_running.py")
    assert (shader_at.file.endswith("ramp.frag"), shader_at.line) == (True, 5)


def test_vertices_and_varyings_are_captured(lab: SceneRunner, folder: Path) -> None:
    def placed(aPos: Any, model: Any) -> Any:
        from shaderlab.glslmath import mul

        return mul(model, vec4(aPos, 1.0))

    mesh = Mesh(attributes={"aPos": SQUARE * 0.5, "aNormal": SQUARE + np.array([0.0, 0.0, 1.0])},
                indices=np.array([0, 1, 2, 0, 2, 3]))  # fmt: skip
    model = np.eye(4)
    model[0, 3] = 0.25  # to the right: rows first, as mathematics writes it
    passes = mesh_pass("point.vert", "shaded.frag", mesh, uniforms={"model": model})
    record = run(
        lab, folder, passes,
        formula("gl_Position", placed),
        formula("unit", unit),
        value("gl_Position", at={"aPos": (1.0, 0.0, 0.0)}, equals=(1.25, 0, 0, 1), digits=4),
        value("unit", at={"Normal": (3.0, 0.0, 4.0), "corner": 0}, equals=(0.6, 0, 0.8), digits=6),
        coverage(64),
    )  # fmt: skip
    assert record.status == "pass", record
    assert record.expectations[0].judged == 16
    assert record.expectations[1].judged == 64 * 3


def test_only_what_is_seen_of_a_draw_is_judged_by_its_inputs(
    lab: SceneRunner, folder: Path
) -> None:
    """A nearer draw hides half of the first one; its pixels are not the first one's any more."""
    hide = Draw(
        vertex="placed.vert",
        fragment="flat.frag",
        mesh=replace(HALF, attributes={"aPos": HALF.attributes["aPos"] - (0, 0, 0.5)}),
        uniforms={"color": (9.0, 9.0, 9.0, 9.0)},
        state=State(depth=Depth()),
    )
    first = replace(ramp()[0].draws[0], state=State(depth=Depth()))
    passes = (Pass(target=Target(depth="depth24"), draws=(first, hide)),)

    def colour(x: Any, y: Any) -> Any:
        return vec4(x, y, 0.0, 1.0)

    record = run(lab, folder, passes, formula("FragColor", colour, draw=0))
    assert record.status == "pass", record
    assert record.expectations[0].judged == 16 * 8 * 4


def test_discarded_pixels_are_not_judged(lab: SceneRunner, folder: Path) -> None:
    (folder / "holes.frag").write_text(
        "#version 330 core\nin float x;\nout float y;\n"
        "void main() { if (x < 0.5) discard; y = x; }\n"
    )
    passes = fullscreen("holes.frag", domain={"x": across(0.0, 1.0)})

    def same(x: Any) -> Any:
        return x

    record = run(lab, folder, passes, formula("y", same, discards=lambda x: x < 0.5))
    assert (record.status, record.expectations[0].judged) == ("pass", 128)


def test_many_inputs_are_captured_in_several_rounds(lab: SceneRunner, folder: Path) -> None:
    names = [f"v{i}" for i in range(11)]
    (folder / "many.frag").write_text(
        "#version 330 core\n" + "".join(f"in vec3 {n};\n" for n in names) + "out vec3 total;\n"
        "void main() { total = " + " + ".join(names) + "; }\n"
    )
    domain = {n: across((i, 0.0, 0.0), (i + 1.0, i, 0.5)) for i, n in enumerate(names)}

    def total(v0, v1, v2, v3, v4, v5, v6, v7, v8, v9, v10):  # type: ignore[no-untyped-def]
        return v0 + v1 + v2 + v3 + v4 + v5 + v6 + v7 + v8 + v9 + v10

    record = run(lab, folder, fullscreen("many.frag", domain=domain), formula("total", total))
    assert record.status == "pass", record


def test_an_earlier_pass_is_a_texture_of_a_later_one(lab: SceneRunner, folder: Path) -> None:
    def copied(image: Any, TexCoords: Any) -> Any:
        return texture(image, TexCoords)

    passes = (
        *ramp(name="first"),
        *fullscreen("copy.frag", textures={"image": Output("first.FragColor")}),
    )
    record = run(
        lab, folder, passes,
        exact("FragColor", Output("first.FragColor")),
        formula("FragColor", copied),
    )  # fmt: skip
    assert record.status == "pass", record
    late = fullscreen("copy.frag", textures={"image": Output("later.FragColor")})
    assert "later.FragColor" in run(lab, folder, late, exact("FragColor", 0.0)).message


@pytest.mark.parametrize("wrap", ["repeat", "mirrored_repeat", "clamp_to_edge", "clamp_to_border"])
def test_every_wrap_mode_reaches_the_driver(lab: SceneRunner, folder: Path, wrap: str) -> None:
    def sampled(image: Any, TexCoords: Any) -> Any:
        return texture(image, TexCoords)

    texels = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
    image = Texture(image=texels, wrap=(wrap, wrap), border=(5.0, 6.0, 7.0, 8.0))
    # Texel edges would fall on pixel centres at a rounder number.
    domain = {"TexCoords": across((-1.53, -0.71), (2.51, 1.37))}
    passes = fullscreen("copy.frag", domain=domain, textures={"image": image})
    assert run(lab, folder, passes, formula("FragColor", sampled)).status == "pass"
    other = replace(image, wrap=("repeat", "clamp_to_edge"))

    def wrong(TexCoords: Any, image: Any) -> Any:
        from shaderlab.glslmath.sampling import Sampler

        return texture(Sampler(replace(image.texels, wrap=other.wrap), image.rules), TexCoords)

    assert run(lab, folder, passes, formula("FragColor", wrong)).status == "fail"


def test_state_is_set_for_one_draw_and_gone_for_the_next(lab: SceneRunner, folder: Path) -> None:
    odd = State(
        depth=Depth(func="never", write=False),
        stencil=Stencil(func="never", write_mask=0),
        blend=Blend(source="zero", destination="zero"),
        cull="front_and_back",
        color_mask=(False, True, False, True),
        cell=Cell(column=0, row=0, columns=4, rows=4),
        srgb=True,
    )
    passes = (
        Pass(
            name="odd",
            target=Target(depth="depth24_stencil8", colors={"FragColor": "rgba32f"}),
            draws=(flat((1, 2, 3, 4), state=odd),),
        ),
        Pass(draws=(flat((1, 2, 3, 4)),), target=Target(depth="depth24_stencil8")),
    )
    record = run(lab, folder, passes, exact("odd.FragColor", 0.0), exact("FragColor", (1, 2, 3, 4)))
    assert record.status == "pass", record


def test_masked_attachments_are_still_cleared(lab: SceneRunner, folder: Path) -> None:
    masked = flat((1, 1, 1, 1), state=State(color_mask=(False,) * 4))
    target = Target(clear=(0.25, 0.5, 0.75, 1.0))
    passes = (Pass(name="a", draws=(masked,)), Pass(target=target, draws=(masked,)))
    record = run(lab, folder, passes, exact("FragColor", (0.25, 0.5, 0.75, 1.0)))
    assert record.status == "pass", record


def test_outputs_may_be_left_without_an_attachment(lab: SceneRunner, folder: Path) -> None:
    passes = ramp(target=Target(colors={"product": "r32f"}))
    assert run(lab, folder, passes, formula("product", product)).status == "pass"


def test_integers_and_halves_are_read_as_they_are(lab: SceneRunner, folder: Path) -> None:
    (folder / "int.frag").write_text(
        "#version 330 core\nout ivec2 y;\nvoid main() { y = ivec2(-7, 2147483647); }\n"
    )
    passes = fullscreen("int.frag", domain={})
    assert run(lab, folder, passes, exact("y", (-7, 2147483647))).status == "pass"
    half = (Pass(target=Target(colors={"FragColor": "rgba16f"}), draws=(flat((0.1, 1, 2, 3)),)),)

    def tenth() -> Any:
        return vec4(0.1, 1.0, 2.0, 3.0)

    def eleventh() -> Any:
        return vec4(0.11, 1.0, 2.0, 3.0)

    assert run(lab, folder, half, formula("FragColor", tenth)).status == "pass"
    assert run(lab, folder, half, formula("FragColor", eleventh)).status == "fail"


def test_multisampled_targets_are_resolved(lab: SceneRunner, folder: Path) -> None:
    edge = Mesh(attributes={"aPos": np.array([[-1, -1, 0], [1, -1, 0], [-1, 1, 0]], np.float32)})
    draw = Draw(vertex="placed.vert", fragment="flat.frag", mesh=edge,
                uniforms={"color": (1.0, 1.0, 1.0, 1.0)})  # fmt: skip
    colors = {"FragColor": "rgba32f"}
    passes = (Pass(target=Target(samples=4, colors=colors), draws=(draw,)),)
    record = run(
        lab, folder, passes,
        value("FragColor", at=Pixel(0, 0), equals=(1, 1, 1, 1), digits=6),
        value("FragColor", at=Pixel(15, 15), equals=(0, 0, 0, 0), digits=6),
        value("FragColor", at=Pixel(8, 7), equals=(0.5, 0.5, 0.5, 0.5), digits=0),
    )  # fmt: skip
    assert record.status == "pass", record
    too_many = (Pass(target=Target(samples=999), draws=(draw,)),)
    refused = run(lab, folder, too_many, exact("FragColor", 0.0))
    assert refused.status == "unsupported"
    assert "999 samples" in refused.message


def test_drawing_without_a_vertex_array_is_the_error_it_should_be(
    lab: SceneRunner, folder: Path
) -> None:
    passes = (Pass(draws=(flat((1, 1, 1, 1), vertex_array=False),)),)
    expected = run(lab, folder, passes, gl_error("invalid_operation"), exact("FragColor", 0.0))
    assert expected.status == "pass", expected
    other = run(lab, folder, passes, gl_error("invalid_enum"))
    assert other.status == "fail"
    nobody = run(lab, folder, passes, exact("FragColor", 0.0))
    assert nobody.status == "error"
    assert "GL_INVALID_OPERATION (0x0502)" in nobody.message
    # The error is this case's alone.
    assert run(lab, folder, ramp(), formula("product", product)).status == "pass"


@pytest.mark.parametrize(
    ("changes", "says", "remedy"),
    [
        ({"uniforms": {"gian": 1.0}}, "there is no uniform 'gian'", "did you mean gain?"),
        ({"uniforms": {}}, "nothing is given for uniform gain (float)", "uniforms"),
        ({"uniforms": {"gain": (1.0, 2.0)}}, "'gain' is float", ""),
        ({"uniforms": {"gain": float("nan")}}, "'gain' holds nan", ""),
        ({"uniforms": {"gain": 1e39}}, "'gain' holds 1e+39", ""),
        ({"domain": {"x": across(0, 1)}}, "nothing is given for input y", "domain"),
        ({"domain": {"x": across(0, 1), "z": up(0, 1)}}, "there is no input 'z'", ""),
        ({"textures": {"gain": Texture(image=np.zeros((1, 1, 4)))}}, "is a uniform", ""),
        ({"target": Target(colors={"prodct": "r32f"})}, "'prodct'", "product"),
    ],
)  # fmt: skip
def test_data_that_does_not_fit_the_shader_is_named(
    lab: SceneRunner, folder: Path, changes: dict[str, Any], says: str, remedy: str
) -> None:
    record = run(lab, folder, ramp(**changes), formula("product", product))
    assert record.status == "error"
    assert says in record.message
    assert remedy in record.message


def test_a_texture_that_is_missing_or_misshapen_is_named(lab: SceneRunner, folder: Path) -> None:
    missing = fullscreen("copy.frag", textures={"image": Texture(image="none.png")})
    record = run(lab, folder, missing, exact("FragColor", 0.0))
    assert record.status == "error" and "none.png" in record.message
    nothing = fullscreen("copy.frag")
    assert (
        "nothing is given for texture image"
        in run(lab, folder, nothing, exact("FragColor", 0.0)).message
    )
    thin = fullscreen("copy.frag", textures={"image": Texture(image=np.zeros((2, 2, 3)))})
    assert "(2, 2, 3)" in run(lab, folder, thin, exact("FragColor", 0.0)).message


def test_a_mesh_must_have_what_the_vertex_shader_reads(lab: SceneRunner, folder: Path) -> None:
    def passes(**attributes: Any) -> tuple[Pass, ...]:
        return mesh_pass(
            "placed.vert", "flat.frag", Mesh(attributes=attributes), uniforms={"color": (1,) * 4}
        )

    check = exact("FragColor", 0.0)
    assert (
        "no attribute 'aNormal'"
        in run(lab, folder, passes(aPos=SQUARE, aNormal=SQUARE), check).message
    )
    assert (
        "nothing is given for attribute aPos"
        in run(lab, folder, passes(aPosition=SQUARE), check).message
        or "no attribute 'aPosition'" in run(lab, folder, passes(aPosition=SQUARE), check).message
    )
    assert "2 components" in run(lab, folder, passes(aPos=SQUARE[:, :2]), check).message


def test_a_broken_shader_is_an_error_at_its_own_line(lab: SceneRunner, folder: Path) -> None:
    (folder / "broken.frag").write_text(
        "#version 330 core\nout vec4 c;\nvoid main() { c = vec4(nope); }\n"
    )
    record = run(lab, folder, fullscreen("broken.frag", domain={}), exact("c", 0.0))
    assert record.status == "error"
    assert "broken.frag:3" in record.message and "nope" in record.message
    assert record.compile["glsl"] == "fail"
    missing = run(lab, folder, fullscreen("brokne.frag", domain={}), exact("c", 0.0))
    assert missing.status == "error" and "broken.frag" in missing.message


def test_a_uniform_without_effect_is_noticed(lab: SceneRunner, folder: Path) -> None:
    (folder / "idle.frag").write_text(
        "#version 330 core\nuniform float idle;\nout float y;\nvoid main() { y = idle * 0.0; }\n"
    )
    (folder / "unused.frag").write_text(
        "#version 330 core\nuniform float idle;\nout float y;\nvoid main() { y = 1.0; }\n"
    )
    passes = fullscreen("unused.frag", domain={}, uniforms={"idle": 2.0})
    record = run(lab, folder, passes, exact("y", 1.0))
    assert record.status == "pass"
    assert any("idle" in notice for notice in record.notices)


def test_pictures_are_written_where_the_record_says(folder: Path, tmp_path: Path) -> None:
    expected = formula("product", product), exact("FragColor", 0.0)
    with SceneRunner(RunOptions(size=16, picture_size=32, folder=tmp_path)) as lab:
        record = run(lab, folder, ramp(), *expected, picture="FragColor")
    passed, failed = record.expectations
    assert (passed.status, list(passed.images)) == ("pass", ["measured"])
    assert (failed.status, list(failed.images)) == ("fail", ["measured", "reference", "distance"])
    for file in (*record.images.values(), *passed.images.values(), *failed.images.values()):
        assert (tmp_path / file).read_bytes().startswith(b"\x89PNG")


def test_a_picture_that_cannot_be_written_changes_no_verdict(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(pixels: Any, palette: Any = None) -> bytes:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("shaderlab.model.pictures.files.encode", full)
    with SceneRunner(RunOptions(size=16, picture_size=32, folder=tmp_path)) as lab:
        record = run(lab, folder, ramp(), formula("product", product))
    assert record.status == "pass"
    assert any("can't write the picture (No space left" in notice for notice in record.notices)


def test_the_same_scene_gives_the_same_bytes(lab: SceneRunner, folder: Path) -> None:
    def once() -> Record:
        return run(lab, folder, ramp(), formula("product", product), exact("FragColor", 0.0))

    first, second = once(), once()
    assert repr(first.expectations) == repr(second.expectations)  # repr: NaN is equal to itself


def test_a_defect_of_the_lab_costs_one_scene_only(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from shaderlab.engine.pictures import PictureWriter

    def broken(self: Any, image: Any) -> Any:
        raise IndexError("no such luck")

    monkeypatch.delenv("SHADERLAB_DEBUG", raising=False)
    with SceneRunner(RunOptions(size=16, folder=folder)) as lab:
        with monkeypatch.context() as patch:
            patch.setattr(PictureWriter, "write_picture", broken)
            record = run(lab, folder, ramp(), formula("product", product))
        assert record.status == "error"
        assert "IndexError: no such luck" in record.message
        assert record.expectations[0].status == "pass", "what was judged before is kept"
        assert run(lab, folder, ramp(), formula("product", product)).status == "pass"


def test_a_driver_that_disagrees_with_the_compiler_is_told_on(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from shaderlab.errors import Diagnostic, Verdict

    said = Diagnostic(file="ramp.frag", line=3, severity="error", message="not on my machine")

    def refusing(backend: Any, sources: Any) -> Verdict:
        return Verdict(target="driver", ok=False, diagnostics=(said,))

    monkeypatch.setattr(OpenGLBackend, "driver_verdict", refusing)
    with SceneRunner(RunOptions(size=16)) as lab:
        record = run(lab, folder, ramp(), formula("product", product))
    assert record.status == "fail"
    assert record.compile["driver"] == "fail"
    verdict = record.programs[0].verdicts[-1]
    assert verdict.status == "disagrees"
    assert "glslang accepts what the driver refuses" in verdict.diagnostics[0].message


@pytest.mark.parametrize(
    ("target", "sizes"), [(Target(size=(20, 20)), [16]), (Target(), [16, 512])]
)
def test_only_a_scene_without_a_size_is_drawn_again_for_its_picture(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, target: Target, sizes: list[int]
) -> None:
    drawn: list[int] = []
    session = OpenGLBackend.session

    def noted(
        backend: OpenGLBackend, scene: Any, programs: Any, size: tuple[int, int], **options: Any
    ) -> Any:
        drawn.append(size[0])
        return session(backend, scene, programs, size, **options)

    monkeypatch.setattr(OpenGLBackend, "session", noted)
    with SceneRunner(RunOptions(size=16, folder=tmp_path)) as lab:
        record = run(lab, folder, ramp(target=target), formula("product", product))
    assert record.status == "pass" and drawn == sizes
    seen = pictures.load(tmp_path / record.images["picture"])
    assert seen.shape[0] == (260 if target.size else 512)  # small ones are enlarged
    assert seen[0, -1, 0] == 1.0 and seen[0, 0, 0] < 0.1


def test_a_formula_that_fails_on_values_only_a_picture_looks_at(
    folder: Path, tmp_path: Path
) -> None:
    """The outcome says so, and the case's other checks are judged."""

    def fails(x: Any, y: Any, gain: Any) -> Any:
        if isinstance(y, np.ndarray) and y.max() > 2.9:  # the upper rows: a later piece
            raise ValueError("too high")
        return x * y * gain

    options = RunOptions(size=16, folder=tmp_path)
    wide = ramp(target=Target(size=(160, 160)))
    with SceneRunner(options) as lab:
        record = run(lab, folder, wide, formula("product", fails), formula("product", product))
    first, second = record.expectations
    assert (first.status, second.status) == ("error", "pass")
    assert "too high" in first.message and not first.images and second.images
