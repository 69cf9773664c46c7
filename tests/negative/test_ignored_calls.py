"""Labs that leave out what a case is about, and draw the same pixels: its calls tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import moderngl
import pytest

from shaderlab.drivers.opengl import (
    buffers,
    calls,
    drawing,
    linking,
    target,
    textures,
)
from shaderlab.drivers.opengl.device import GL, gl_constant
from shaderlab.engine.expectations.gl_call import GlCall
from shaderlab.engine.run import SceneRunner
from shaderlab.model.case import Scene
from shaderlab.model.options import RunOptions
from shaderlab.model.textures import Sampling
from tests.catalogue import judged_only, shipped

Patch = Callable[[pytest.MonkeyPatch], None]
CALLS_ONLY = RunOptions(modules=False)
"""No shader is wrong here, and none has to judge itself."""


def always_static(patch: pytest.MonkeyPatch) -> None:
    """Each buffer gets the same hint."""
    patch.setattr(buffers, "gl_constant", lambda word: gl_constant("static_draw"))


def always_copied(patch: pytest.MonkeyPatch) -> None:
    """Buffers are filled by glBufferData, whatever a mesh asks for."""
    filled = buffers.fill_buffer
    patch.setattr(
        buffers,
        "fill_buffer",
        lambda d, parts, mesh: filled(d, parts, replace(mesh, upload="data")),
    )


def pixels_always_copied(patch: pytest.MonkeyPatch) -> None:
    """Textures are filled from the program's memory, never from a buffer."""
    upload = textures.upload
    patch.setattr(textures, "upload", lambda *given, mapped: upload(*given))


def always_anew(patch: pytest.MonkeyPatch) -> None:
    """Each draw has its mesh uploaded again."""

    def made(self: Any, program: Any, mesh: Any) -> Any:
        self._arrays[len(self._arrays), 0] = found = buffers.make_vertex_array(
            self.device, program, mesh
        )
        return found

    patch.setattr(drawing.Drawing, "_vertex_array", made)


def always_written(patch: pytest.MonkeyPatch) -> None:
    """Each draw has its blocks written to buffers of their own."""
    bind = buffers.UniformBuffers.bind

    def bound(self: Any, *arguments: Any) -> Any:
        self._made = {}
        return bind(self, *arguments)

    patch.setattr(buffers.UniformBuffers, "bind", bound)


def depth_in_textures(patch: pytest.MonkeyPatch) -> None:
    """No depth is kept in a renderbuffer."""
    begin = target.RenderTarget.__init__

    def begun(self: Any, device: Any, wanted: Any, *rest: Any) -> None:
        begin(self, device, replace(wanted, depth_storage="texture"), *rest)

    patch.setattr(target.RenderTarget, "__init__", begun)


def nothing_without_a_location(patch: pytest.MonkeyPatch) -> None:
    """A uniform without a location is not set."""
    patch.setattr(linking, "set_unlocated", lambda program, array: None)


def as_many_buffers_as_frames(patch: pytest.MonkeyPatch) -> None:
    """Each frame of the two buffers is begun in memory of its own."""
    run = drawing.Drawing.run_pass

    def anew(self: Any, description: Any) -> None:
        halfway = description.name.startswith("two") and description.name.endswith("half")
        run(self, replace(description, onto="") if halfway else description)

    patch.setattr(drawing.Drawing, "run_pass", anew)


@pytest.mark.parametrize(
    ("case_id", "patched"),
    [
        ("buffer-usage", always_static),
        ("buffer-subdata", always_copied),
        ("buffer-map", always_copied),
        ("buffer-map", pixels_always_copied),
        ("mesh-class", always_anew),
        ("uniform-buffer", always_written),
        ("framebuffer-renderbuffer", depth_in_textures),
        ("double-buffer", as_many_buffers_as_frames),
        ("inactive-uniform", nothing_without_a_location),
    ],
)
def test_a_call_that_is_left_out_is_noticed(
    monkeypatch: pytest.MonkeyPatch, case_id: str, patched: Patch
) -> None:
    patched(monkeypatch)
    scene = next(shipped()[case_id].scenes())
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(scene)
    failed = {o.kind for o in record.expectations if o.status != "pass"}
    assert record.status == "fail" and failed == {"GL calls"}, (record.message, failed)


@pytest.mark.parametrize(
    ("case_id", "function"),
    [
        ("image-file", "glPixelStorei"),
        ("compile-and-link", "glDeleteShader"),
        ("points-and-elements", "glBegin"),
        ("framebuffer-renderbuffer", "glDrawBuffer"),
        ("depth-precision", "glClearDepth"),
    ],
)
def test_a_call_that_opengl_ignores_is_noticed(
    monkeypatch: pytest.MonkeyPatch, case_id: str, function: str
) -> None:
    """A driver that takes a call and does nothing."""
    scene = next(shipped()[case_id].scenes())
    asked = tuple(e for e in scene.expect if isinstance(e, GlCall))
    invoke = calls._Maker._invoke

    def ignored(self: Any, call: Any, *given: Any) -> Any:
        return None if call.function == function else invoke(self, call, *given)

    monkeypatch.setattr(calls._Maker, "_invoke", ignored)
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(replace(scene, expect=asked))
    assert record.status == "fail", record.message


def test_each_function_that_checks_call_is_missed_somewhere_if_it_does_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scenes: dict[str, list[Scene]] = {}
    for case in shipped().values():
        scene = next(case.scenes())
        asked = tuple(e for e in scene.expect if isinstance(e, GlCall))
        drawn = tuple(p for p in scene.passes if all(d.vertex_array for d in p.draws))
        for function in {step.function for e in asked for step in (*e.before, e.call)}:
            scenes.setdefault(function, []).append(replace(scene, expect=asked, passes=drawn))
    invoke, ignored = calls._Maker._invoke, ""

    def invoked(self: Any, call: Any, *given: Any) -> Any:
        return None if call.function == ignored else invoke(self, call, *given)

    monkeypatch.setattr(calls._Maker, "_invoke", invoked)
    unmissed = []
    with SceneRunner(CALLS_ONLY) as lab:
        for ignored, users in scenes.items():
            if not any(lab.run(scene).status == "fail" for scene in users):
                unmissed.append(ignored)
    assert len(scenes) > 60 and unmissed == []


def test_a_framebuffer_that_is_not_the_targets_is_no_lack_of_the_driver(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What OpenGL says of that one would pass as "unsupported"."""
    use = moderngl.Framebuffer.use

    def used(framebuffer: moderngl.Framebuffer) -> None:
        use(framebuffer)
        GL.glBindFramebuffer(GL.GL_FRAMEBUFFER, 1)

    monkeypatch.setattr(moderngl.Framebuffer, "use", used)
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(next(judged_only("framebuffer-renderbuffer").scenes()))
    assert record.status == "error" and "another framebuffer" in record.message


def test_one_sample_in_place_of_four_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some drivers give four then, and draw the same pixels."""
    begin = target.RenderTarget.__init__

    def begun(self: Any, device: Any, wanted: Any, *rest: Any) -> None:
        begin(self, device, replace(wanted, samples=min(wanted.samples, 1)), *rest)

    monkeypatch.setattr(target.RenderTarget, "__init__", begun)
    assert_noticed("msaa", "four", "four asked")


def test_an_offset_that_is_not_switched_on_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the driver takes the switch of lines for that of filled polygons."""
    enabled = target.GL.glEnable
    fill = target.GL.GL_POLYGON_OFFSET_FILL
    monkeypatch.setattr(target.GL, "glEnable", lambda cap: None if cap == fill else enabled(cap))
    assert_noticed("z-fighting", "picture", "orange in the picture")


def assert_noticed(case_id: str, drawn: str, check: str) -> None:
    """Run one pass of a case, which one check has to fail."""
    scene = next(shipped()[case_id].scenes())
    passes = tuple(p for p in scene.passes if p.name == drawn)
    asked = tuple(e for e in scene.expect if e.name == check)
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(replace(scene, passes=passes, expect=asked))
    assert record.status == "fail" and asked, record.message


@pytest.mark.parametrize("kept", [0, 1])
@pytest.mark.parametrize("case_id", ["texture-filter", "mipmap-filters"])
def test_one_filter_in_place_of_two_is_noticed(
    monkeypatch: pytest.MonkeyPatch, case_id: str, kept: int
) -> None:
    """Textures are minified and magnified alike."""
    made = textures.make_sampler

    def sampler(sampling: Any) -> int:
        word = sampling.filter[kept]
        magnifying = word.partition("_mipmap_")[0]
        return made(replace(sampling, filter=(word, magnifying)))

    monkeypatch.setattr(textures, "make_sampler", sampler)
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(next(judged_only(case_id).scenes()))
    assert record.status == "fail", record.message


@pytest.mark.parametrize(
    ("axis", "told"), [("r", ("three dim", "the wood")), ("t", ("LINEAR towards a border",))]
)
def test_a_wrap_mode_that_is_not_set_along_one_axis_is_noticed(
    monkeypatch: pytest.MonkeyPatch, axis: str, told: tuple[str, ...]
) -> None:
    """Along r there is the default one then, along t that of s."""
    made = textures.make_sampler

    def sampler(sampling: Any) -> int:
        plane = {f.name: getattr(sampling, f.name) for f in fields(Sampling)}
        s, t, *r = sampling.wrap
        if axis == "r":
            return made(Sampling(**plane | {"wrap": (s, t)}))
        return made(sampling if r else Sampling(**plane | {"wrap": (s, s)}))

    monkeypatch.setattr(textures, "make_sampler", sampler)
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(next(judged_only("texture-wrap").scenes()))
    failed = {o.name for o in record.expectations if o.status != "pass"}
    assert failed and all(name.startswith(told) for name in failed), failed


@pytest.mark.parametrize(
    ("case_id", "function", "buffer"),
    [
        ("orange-triangle", "glClearBufferfv", GL.GL_COLOR),
        ("depth-mask", "glClearBufferfv", GL.GL_DEPTH),
        ("stencil-functions", "glClearBufferiv", GL.GL_STENCIL),
    ],
)
def test_a_clear_that_does_nothing_is_noticed(
    monkeypatch: pytest.MonkeyPatch, case_id: str, function: str, buffer: int
) -> None:
    """Also where memory happens to hold zeros."""
    clear = getattr(GL, function)
    monkeypatch.setattr(
        GL, function, lambda what, *rest: None if what == buffer else clear(what, *rest)
    )
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(next(judged_only(case_id).scenes()))
    assert record.status == "fail", record.message


@pytest.mark.parametrize("case_id", ["cubemap", "environment-map", "texture-wrap", "image-file"])
def test_an_upload_of_other_texels_is_noticed(
    monkeypatch: pytest.MonkeyPatch, case_id: str
) -> None:
    """Of six faces, of layers, and of a plane: each is mirrored on its way to the driver."""
    upload = textures.upload

    def mirrored(device: Any, kind: str, format: str, images: Any, **how: Any) -> Any:
        layers = [image[:, ::-1] for image in images.layers]
        return upload(device, kind, format, replace(images, layers=layers), **how)

    monkeypatch.setattr(textures, "upload", mirrored)
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(next(judged_only(case_id).scenes()))
    assert record.status == "fail", record.message


def test_a_mark_of_what_is_hidden_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the lesson's scene all that hides a box has a mark of its own."""
    apply = drawing.apply_state

    def marking(state: Any, *rest: Any) -> Any:
        stencil = state.stencil
        marked = stencil and replace(stencil, depth_fail=stencil.depth_pass)
        return apply(replace(state, stencil=marked), *rest)

    monkeypatch.setattr(drawing, "apply_state", marking)
    with SceneRunner(CALLS_ONLY) as lab:
        record = lab.run(next(judged_only("stencil-outline").scenes()))
    failed = [o.name for o in record.expectations if o.status != "pass"]
    assert failed == ["what is hidden has no mark"]
