"""Cases on Vulkan's software drivers, with Khronos' validation layer where it is installed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shaderlab import Mesh, Target, exact, formula
from shaderlab.drivers.vulkan.__init__ import manifest_of
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import DriverError
from shaderlab.model.options import RunOptions
from tests.catalogue import judged_only
from tests.gpu.scenes import (
    ONE,
    RIGHT,
    image,
    meshes,
    points_off_screen_are_dropped,
    require_driver,
    wave,
)

LAYER = "VK_LAYER_KHRONOS_validation"
# Textures, meshes, depth and stencil, blending, several passes, samples, lines and points.
SHIPPED = (
    "texture-wrap", "mvp", "stencil-outline", "transparency-order", "hdr",
    "multisample-coverage", "cubemap", "window-origin", "point-cloud",
)  # fmt: skip


def installed() -> bool:
    folders = ("/usr/share/vulkan/explicit_layer.d", "/etc/vulkan/explicit_layer.d")
    return any(Path(folder, "VkLayer_khronos_validation.json").exists() for folder in folders)


@pytest.fixture(scope="module", params=["lavapipe", "swiftshader"])
def lab(request: pytest.FixtureRequest) -> Iterator[SceneRunner]:
    patch = pytest.MonkeyPatch()
    patch.setenv("VK_INSTANCE_LAYERS", LAYER)  # the loader goes on without it where it is not there
    with SceneRunner(RunOptions(size=16, driver=request.param, modules=False)) as lab:
        require_driver(lab)
        assert lab.backend.info["renderer"]
        yield lab
    patch.undo()


@pytest.fixture
def unasked(capfd: pytest.CaptureFixture[str]) -> Iterator[list[str]]:
    """What the layer says, which is nothing."""
    said: list[str] = []
    yield said
    said += [line for line in capfd.readouterr().out.splitlines() if "Validation" in line]
    assert said == []


@pytest.mark.usefixtures("unasked")
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


@pytest.mark.usefixtures("unasked")
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_cases_pass(lab: SceneRunner, name: str) -> None:
    record = lab.run(next(judged_only(name).scenes()))
    assert (record.status, record.message) == ("pass", "")


def test_nothing_is_left_on_a_device_that_is_closed(
    lab: SceneRunner, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The layer tells of each object that a device is destroyed with."""
    assert wave(lab, tmp_path, RIGHT).status == "pass"
    lab.close()
    assert "Validation" not in capfd.readouterr().out
    from shaderlab.drivers.vulkan.device import Resources

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Resources, "callback", lambda *_: None)
        wave(lab, tmp_path, RIGHT)
        lab.close()
    assert "has not been destroyed" in capfd.readouterr().out or not installed()


def test_the_layer_is_on(
    lab: SceneRunner, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """An image in the wrong layout is told."""
    from shaderlab.drivers.vulkan.device import Commands

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Commands, "make_usable", lambda *_: None)
        assert wave(lab, tmp_path, RIGHT).status == "pass"
    said = capfd.readouterr().out
    if not installed():
        pytest.skip("the validation layer is not installed")
    assert "InvalidImageLayout" in said


def test_a_driver_that_is_not_there_is_an_error_with_its_remedy(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("XDG_DATA_DIRS", "XDG_CONFIG_DIRS", "PATH"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setattr("shaderlab.drivers.vulkan.__init__.MANIFEST_FOLDERS", ())
    for driver, package in (("lavapipe", "mesa-vulkan-drivers"), ("swiftshader", "chromium")):
        with pytest.raises(DriverError, match=f"(?s)no manifest.*{driver}.*{package}"):
            manifest_of(driver)
    assert manifest_of("vulkan") is None
    (tmp_path / "vulkan" / "icd.d").mkdir(parents=True)
    (tmp_path / "vulkan" / "icd.d" / "lvp_icd.json").write_text("{}")
    assert manifest_of("lavapipe") == tmp_path / "vulkan" / "icd.d" / "lvp_icd.json"


def test_what_a_device_lacks_is_unsupported_by_name(lab: SceneRunner) -> None:
    record = lab.run(next(judged_only("geometry-explode").scenes()))
    if "geometryShader" in lab.backend.device.features:  # type: ignore[attr-defined]
        assert (record.status, record.message) == ("pass", "")
    else:
        assert record.status == "unsupported"
        assert record.message == "the geometry stage takes geometryShader: this device has none"
    record = lab.run(next(judged_only("buffer-usage").scenes()))
    assert record.status == "pass" and "STREAM_DRAW is what the driver is told" in record.not_asked
    assert {o.status for o in record.expectations} == {"pass"}  # all the others


class Losing:
    """Vulkan's functions, with a device that is lost as soon as it works."""

    def __init__(self, lib: object) -> None:
        self._lib = lib

    def __getattr__(self, name: str) -> object:
        lost = -4
        return (lambda *_: lost) if name == "vkQueueWaitIdle" else getattr(self._lib, name)


def test_a_lost_device_is_a_crash_and_the_next_scene_gets_another(
    lab: SceneRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from shaderlab.drivers.vulkan import device

    lost = lab.backend
    with monkeypatch.context() as patch:
        patch.setattr(device, "lib", Losing(device.lib))
        record = wave(lab, tmp_path, RIGHT)
    assert record.status == "crash"
    assert record.message.startswith(f"{lab.options.driver}: the device was lost: running commands")
    assert wave(lab, tmp_path, RIGHT).status == "pass"
    assert lab.backend is not lost


def test_the_page_on_vulkan_says_what_the_devices_have(lab: SceneRunner, repository: Path) -> None:
    page = (repository / "docs" / "guide" / "vulkan.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| (yes|no) \| (yes|no) \|", page, re.MULTILINE)
    assert len(rows) > 5
    column = 1 if lab.options.driver == "lavapipe" else 2
    features = lab.backend.device.features  # type: ignore[attr-defined]
    for row in rows:
        assert (row[0] in features) == (row[column] == "yes"), row[0]
    bits = lab.backend.device.limits.subPixelPrecisionBits  # type: ignore[attr-defined]
    assert bits == {"lavapipe": 8, "swiftshader": 4}[str(lab.options.driver)]


def test_points_off_screen_are_dropped_by_the_lab(lab: SceneRunner, tmp_path: Path) -> None:
    """Neither driver does what it reports: without the lab's ending the point is seen."""
    points_off_screen_are_dropped(lab, tmp_path)


def test_attributes_lie_where_each_layout_has_them(lab: SceneRunner, tmp_path: Path) -> None:
    """Of one buffer two attributes have strides of their own."""
    texts = (
        "#version 330 core\nin vec3 place;\nin vec2 tint;\nout vec2 mixed;\n"
        "void main() { mixed = tint; gl_Position = vec4(place, 1.0); }\n",
        "#version 330 core\nin vec2 mixed;\nout vec2 color;\nvoid main() { color = mixed; }\n",
    )
    drawn = []
    for layout in ("separate", "interleaved", "batched"):
        mesh = Mesh(
            attributes={
                "place": np.array([(-1.0, -1.0, 0.0), (3.0, -1.0, 0.0), (-1.0, 3.0, 0.0)]),
                "tint": np.array([(0.0, 1.0), (2.0, 1.0), (0.0, 3.0)]),
            },
            layout=layout,
        )
        scene = meshes(tmp_path, texts, mesh, formula("color", lambda mixed: mixed))
        drawn.append(image(lab, scene, "color"))
    assert drawn[0].max() > 0.9
    assert np.array_equal(drawn[0], drawn[1]) and np.array_equal(drawn[0], drawn[2])


def test_swiftshader_puts_corners_on_a_coarser_grid(lab: SceneRunner, tmp_path: Path) -> None:
    """An edge 1/40 of a pixel right of a centre: on a grid of 1/16 it goes through the centre."""
    vertex = "#version 330 core\nin vec2 at;\nvoid main() { gl_Position = vec4(at, 0.0, 1.0); }\n"
    x = (8.5 + 1 / 40) / 8 - 1
    corners = np.array([(x, -1.0), (1.0, -1.0), (x, 1.0), (1.0, 1.0)])
    mesh = Mesh(attributes={"at": corners}, primitive="triangle_strip")
    scene = meshes(tmp_path, (vertex, ONE), mesh, exact("level", 1.0))
    row = image(lab, scene, "level")[4, :, 0]
    assert row.sum() == {"lavapipe": 7, "swiftshader": 8}[str(lab.options.driver)]


def test_swiftshader_shifts_what_reaches_behind_the_eye(lab: SceneRunner, tmp_path: Path) -> None:
    """A floor seen from 1 above it, 256 pixels for 90 degrees: where each pixel's place is on the
    screen, less the pixel's own centre. Corners on a grid of 1/16 pixel shift it by 1/32."""
    texts = (
        "#version 330 core\nin vec3 at;\nout vec3 place;\n"
        "void main() { place = at; gl_Position = vec4(at.xy, 1.01 * at.z - 0.2, at.z); }\n",
        "#version 330 core\nin vec3 place;\nout vec4 seen;\n"
        "void main() { seen = vec4(place, 1); }\n",
    )

    def shift(nearest: float) -> float:
        corners = [(x, -1.0, z) for z in (nearest, 9.0) for x in (-8.0, 8.0)]
        mesh = Mesh(attributes={"at": np.array(corners)}, primitive="triangle_strip")
        target = Target(size=(256, 256))
        scene = meshes(tmp_path, texts, mesh, exact("seen", 0.0), target)
        seen = image(lab, scene, "seen").astype(np.float64)
        rows, columns = np.nonzero(seen[..., 3])
        places = seen[rows, columns]
        found = places[:, 1] / places[:, 2] * 128.0 - (rows + 0.5 - 128.0)
        return float(np.abs(found).max())

    own = str(lab.options.driver) == "swiftshader"
    assert shift(1.2) < (1 / 32 if own else 0.001)
    assert shift(-9.0) > 3 / 16 if own else shift(-9.0) < 0.001
