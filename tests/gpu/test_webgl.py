"""Cases in a headless browser, by WebGL2."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shaderlab import (
    Blend,
    Case,
    Ramp,
    State,
    Stencil,
    Texture,
    exact,
    formula,
    fullscreen,
)
from shaderlab.compiler.sources import Shaders
from shaderlab.drivers import probe
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import DeviceLostError, DriverError, UnsupportedError
from shaderlab.model.options import RunOptions
from tests.catalogue import judged_only
from tests.gpu.scenes import RIGHT, WAVE, points_off_screen_are_dropped, require_driver, wave

# Textures, meshes and their vertices, discarding, blending, depth and stencil, several passes.
SHIPPED = ("stencil-outline", "transparency-order")


@pytest.fixture(scope="module")
def lab() -> Iterator[SceneRunner]:
    with SceneRunner(RunOptions(size=16, driver="webgl2", modules=False)) as lab:
        require_driver(lab)
        assert lab.backend.info["version"].startswith("WebGL 2")
        yield lab


def test_a_browser_without_an_answer_skips_no_test() -> None:
    class Silent:
        @property
        def backend(self) -> Any:
            raise DeviceLostError("the browser gave no answer in 60 s")

    with pytest.raises((DeviceLostError, pytest.skip.Exception)) as caught:
        require_driver(Silent())
    assert caught.type is DeviceLostError


def test_a_screen_that_is_not_there_is_not_asked_for(
    lab: SceneRunner, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DISPLAY", ":987")
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-987")
    assert probe("webgl2")["version"].startswith("WebGL 2")


def test_a_formula_is_judged_at_each_pixel(lab: SceneRunner, tmp_path: Path) -> None:
    options = lab.options
    lab.configure(replace(options, modules=None))  # the shader judges itself as well
    record = wave(lab, tmp_path, RIGHT)
    lab.configure(options)
    assert (record.status, record.message) == ("pass", "")
    assert record.modules is not None and record.modules.judged > 0
    assert record.expectations[0].judged == 256
    wrong = formula("level", lambda height, place: height * place.x * place.x)
    assert wave(lab, tmp_path, wrong).status == "fail"


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_cases_pass(lab: SceneRunner, name: str) -> None:
    case = judged_only(name)
    record = lab.run(next(case.scenes()))
    assert (record.status, record.message) == ("pass", "")
    asked = [e.name for e in case.expect if e.kind.startswith("GL ")]
    assert list(record.not_asked) == asked


@pytest.mark.parametrize(
    ("name", "lacks"),
    [
        ("geometry-explode", "the geometry stage: WebGL2 has none"),
        ("texture-wrap", "clamp_to_border: textures have no border in WebGL2"),
        ("primitives", "the fragment stage in WebGL2: 'gl_PrimitiveID' : undeclared identifier"),
        ("vertex-array", "vertex_array=False: WebGL2 always has a vertex array"),
    ],
)
def test_what_webgl2_lacks_is_unsupported_by_name(lab: SceneRunner, name: str, lacks: str) -> None:
    record = lab.run(next(judged_only(name).scenes()))
    assert (record.status, record.message) == ("unsupported", lacks)


def test_an_extension_that_is_not_there_is_named(lab: SceneRunner, tmp_path: Path) -> None:
    """Without it the texture would be incomplete, and black."""
    (tmp_path / "seen.frag").write_text(
        "#version 330 core\nuniform sampler2D image;\nin vec2 at;\nout vec4 color;\n"
        "void main() { color = texture(image, at); }\n"
    )
    texels = Texture(image=np.ones((4, 4, 4)), filter=("linear", "linear"))
    case = Case(
        title="seen", file=str(tmp_path / "seen.py"), expect=[exact("color", 1.0)],
        passes=fullscreen(
            "seen.frag", textures={"image": texels}, domain={"at": Ramp((0.0, 0.0), (1.0, 0.0))}
        ),
    )  # fmt: skip
    assert lab.run(case.scene("default")).status == "pass"
    device = lab.backend.device  # type: ignore[attr-defined]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(device), "extensions", frozenset(), raising=False)
        object.__setattr__(device, "extensions", device.extensions - {"OES_texture_float_linear"})
        record = lab.run(case.scene("default"))
    assert record.status == "unsupported"
    assert record.message == "filtering rgba32f: this browser has no OES_texture_float_linear"


def test_words_that_essl_reserves_may_name_a_uniform(lab: SceneRunner, tmp_path: Path) -> None:
    """SPIRV-Cross calls it otherwise."""
    text = WAVE.replace("uniform float height", "uniform float sample, height")
    text = text.replace("= height", "= (sample + 0.0 * height)")
    (tmp_path / "named.frag").write_text(text)
    case = Case(
        title="named", file=str(tmp_path / "named.py"),
        expect=[formula("level", lambda sample, place: sample * place.x * place.y)],
        passes=fullscreen(
            "named.frag", uniforms={"height": 0.3, "sample": 0.7},
            domain={"place": Ramp((1.0, 2.0), (3.0, 0.0), (0.0, 5.0))},
        ),
    )  # fmt: skip
    assert lab.run(case.scene("default")).status == "pass"


def test_the_verdict_is_the_browser_s_own(lab: SceneRunner) -> None:
    read = Shaders(()).from_text
    assert lab.backend.driver_verdict([read(WAVE, "fragment", "wave.frag")]).ok
    text = WAVE.replace("place.y;", "place.y + float(gl_PrimitiveID);")
    verdict = lab.backend.driver_verdict([read(text, "fragment", "wave.frag")])
    assert not verdict.ok and "gl_PrimitiveID" in verdict.diagnostics[0].message
    text = WAVE.replace("place.y;", "place.y * float(sin(double(height)));")
    with pytest.raises(DriverError):
        lab.backend.driver_verdict([read(text, "fragment", "wave.frag")])
    text = text.replace("330 core", "400 core").replace("sin(double(height))", "double(height)")
    with pytest.raises(UnsupportedError, match="FP64 not supported"):
        lab.backend.driver_verdict([read(text, "fragment", "wave.frag")])


def test_a_browser_that_is_gone_is_a_crash_and_one_that_hangs_is_given_up(
    lab: SceneRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from shaderlab.drivers.webgl import device

    gone = lab.backend
    running = gone.device._browser  # type: ignore[attr-defined]
    with monkeypatch.context() as patch:
        patch.setattr(device, "PATIENCE", 0.3)
        with pytest.raises(DeviceLostError, match=r"gave no answer in 0\.3 s"):
            running._wait(running._page.evaluate("() => { for (;;); }"))
    running._guard.stdin.close()
    running._guard.wait()  # it has killed the browser, whose page is still busy
    record = wave(lab, tmp_path, RIGHT)
    assert (record.status, record.message) == ("crash", "webgl2: the browser is gone")
    assert wave(lab, tmp_path, RIGHT).status == "pass"
    assert lab.backend is not gone


def test_what_is_not_there_is_an_error_with_its_remedy(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from shaderlab.drivers.webgl import device

    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("SHADERLAB_CHROMIUM", raising=False)
    with pytest.raises(DriverError, match=r"(?s)no spirv-cross.*apt-get install spirv-cross"):
        device.find_cross_compiler()
    with pytest.raises(DriverError, match=r"(?s)no Chromium.*apt-get install chromium"):
        device.Browser()
    monkeypatch.setenv("SHADERLAB_CHROMIUM", str(tmp_path / "none"))
    with pytest.raises(DriverError, match="none does not start"):
        device.Browser()
    monkeypatch.setenv("PLAYWRIGHT_NODEJS_PATH", "/bin/false")
    with pytest.raises(DriverError, match="Playwright does not start"):
        device.Browser()


def test_a_lost_context_is_told() -> None:
    from shaderlab.drivers.webgl.device import Calls

    class Answering:
        lost = False

        def play(self, text: str) -> str:
            calls, _ = json.loads(text)
            reply = [
                {"constants": {"RED": 6403}} if name == "about" else len(calls)
                for name, where, _ in calls
                if where < 0
            ]
            return json.dumps({"reply": reply, "lost": self.lost})

    browser = Answering()
    gl = Calls(browser)  # type: ignore[arg-type]
    gl.clear(gl.RED)
    earlier: list[int] = []
    gl.ask_later(earlier.append, "errors")
    assert gl.ask("getError") == 3 and earlier == [3]
    browser.lost = True
    with pytest.raises(DeviceLostError, match="context"):
        gl.ask("getError")


def test_points_off_screen_are_dropped(lab: SceneRunner, tmp_path: Path) -> None:
    """OpenGL ES draws them."""
    points_off_screen_are_dropped(lab, tmp_path)


@pytest.mark.parametrize(
    ("state", "says"),
    [
        (State(sample_shading=1.0), "sample_shading"),
        (State(multisample=False), "multisample=False"),
        (State(srgb=True, depth_range=(1.0, 0.0)), "from far to near"),
        (State(srgb=True, stencil=Stencil(), stencil_back=Stencil(mask=3)), "stencil_back"),
        (State(), "srgb=False"),
        (
            State(srgb=True, blend=Blend(source="constant_color", destination="constant_alpha")),
            "constant alpha",
        ),
    ],
)
def test_states_that_webgl2_lacks_are_named(state: State, says: str) -> None:
    from shaderlab.drivers.webgl.program import check_state

    with pytest.raises(UnsupportedError, match=says):
        check_state(state, samples=4, encodes=True)
    plain = State(srgb=True, blend=Blend(destination="one_minus_constant_color"))
    check_state(plain, samples=4, encodes=True)


def test_depths_are_the_codes_that_were_handed_over() -> None:
    from shaderlab.drivers.webgl.textures import encode_texels, round_depths

    given = np.array([[[0.0], [0.3], [1.0], [1.7]]], np.float32)
    for word, most in (("depth16", 0xFFFF), ("depth24", 0xFFFFFF)):
        codes = np.rint(np.minimum(given, 1.0).astype(np.float64) * most)
        assert np.array_equal(round_depths(word, given), (codes / most).astype(np.float32))
    assert encode_texels("depth24", given).ravel().tolist()[2:] == [0xFFFFFFFF] * 2
    assert np.array_equal(round_depths("depth32f", given), given)
