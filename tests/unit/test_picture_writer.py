"""The pictures of a scene, each encoded once and read back as what was judged; its SPIR-V."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.engine.pictures import PictureWriter
from shaderlab.model import pictures
from shaderlab.model.frame import Image

FRAGMENT = "#version 330 core\nout vec4 color;\nvoid main() { color = vec4(0.25); }\n"


def compared(measured: np.ndarray, reference: np.ndarray) -> dict[str, Any]:
    same = (measured == reference).all(axis=2)
    return {
        "measured": measured,
        "reference": reference,
        "distance": np.where(same, 0.0, np.inf),
    }


@pytest.fixture
def encoded(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of files that went through the encoder."""
    names: list[str] = []
    save = pictures.save_png

    def noted(path: Any, *arguments: Any, **named: Any) -> None:
        names.append(Path(path).name)
        save(path, *arguments, **named)

    monkeypatch.setattr(pictures, "save_png", noted)
    return names


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).random((16, 16, 3)).astype(np.float32)


def test_equal_pictures_of_a_scene_are_encoded_once(tmp_path: Path, encoded: list[str]) -> None:
    writer = PictureWriter(tmp_path, "case", "v")
    values = noise(1)
    first = writer.write_comparison("0-a", compared(values, values))
    again = writer.write_comparison("1-b", compared(values, values))
    picture = writer.write_picture(Image(values, "rgba32f"))
    assert encoded == [
        "case--v--0-a-measured.png",
        "case--v--0-a-distance.png",
        "case--v--picture.png",  # enlarged: other bytes
    ]
    for what in ("measured", "reference", "distance"):
        assert first.files[what] == again.files[what]
    assert (tmp_path / picture.files["picture"]).is_file()


def test_a_judged_picture_that_is_large_enough_is_the_case_s_as_well(
    tmp_path: Path, encoded: list[str]
) -> None:
    writer = PictureWriter(tmp_path, "case", "v")
    values = noise(1).repeat(16, axis=0).repeat(16, axis=1)
    shown = writer.write_comparison("0-a", compared(values, values), passed=True)
    assert (
        writer.write_picture(Image(values, "rgba32f")).files["picture"] == shown.files["measured"]
    )
    assert encoded == ["case--v--0-a-measured.png"]


def test_checks_of_the_case_s_picture_have_its_file(tmp_path: Path, encoded: list[str]) -> None:
    writer = PictureWriter(tmp_path, "case", "v")
    values = noise(1).repeat(16, axis=0).repeat(16, axis=1)
    picture = writer.write_picture(Image(values, "rgba32f"))
    shown = writer.write_comparison("2-c", compared(values, values), passed=True)
    assert shown.files == {"measured": picture.files["picture"]}
    assert len(encoded) == 1


def test_a_pixel_makes_another_picture(tmp_path: Path, encoded: list[str]) -> None:
    writer = PictureWriter(tmp_path, "case", "v")
    values, other = noise(1), noise(1)
    other[3, 5] = 1.0 - other[3, 5]
    writer.write_comparison("0-a", compared(values, values))
    shown = writer.write_comparison("1-b", compared(other, values))
    assert {"case--v--1-b-measured.png", "case--v--1-b-distance.png"} <= set(encoded)
    seen = pictures.load(tmp_path / shown.files["measured"])
    assert np.abs(seen - other).max() <= 0.5 / 255 + 1e-6
    assert shown.files["reference"] != shown.files["measured"]


def test_pixels_that_nothing_covers_are_grey_and_stay_as_they_were(tmp_path: Path) -> None:
    values = (noise(2) * 255).astype(np.uint8)
    before = values.copy()
    covered = np.ones((16, 16), bool)
    covered[2] = False
    arrays = {
        **compared(values, values),
        "covered": covered,
        "exact": values.astype(float),
        "low": values.astype(float),
        "high": values.astype(float),
        "outside": np.zeros(values.shape, bool),
        "unit": np.asarray(1.0),
    }
    shown = PictureWriter(tmp_path, "case", "v").write_comparison("0-a", arrays)
    seen = np.rint(pictures.load(tmp_path / shown.files["measured"]) * 255)
    assert (seen[2] == pictures.UNCOVERED).all() and (seen[3] == values[3]).all()
    assert np.array_equal(values, before)


def test_of_what_passes_only_the_measured_values_are_a_picture(tmp_path: Path) -> None:
    values = noise(3)
    shown = PictureWriter(tmp_path, "case", "v").write_comparison(
        "0-a", compared(values, values), passed=True
    )
    assert list(shown.files) == list(shown.captions) == ["measured"]
    written = {path.name for path in (tmp_path / "images").iterdir()}
    assert written == {"case--v--0-a-measured.png", "case--v--0-a.values"}


def scene(*passes: str) -> Any:
    return SimpleNamespace(
        passes=[SimpleNamespace(name=name, draws=()) for name in passes],
    )


def test_an_attachment_is_small_and_the_picture_is_no_other_file(tmp_path: Path) -> None:
    writer = PictureWriter(tmp_path, "case", "v")
    large = np.zeros((512, 256, 4), np.float32)
    large[:256, :, 0] = 1.0
    images = {
        ("a", "color"): Image(large, "rgba32f"),
        ("a", "depth"): Image(large[..., :1], "depth32f"),
        ("b", "color"): Image(large, "rgba32f"),
    }
    picture = writer.write_picture(images["b", "color"])
    first, last = writer.write_passes(scene("a", "b"), images)
    assert last.attachments[0].image == picture.files["picture"]
    color, depth = (pictures.load(tmp_path / each.image) for each in first.attachments)
    assert color.shape == depth.shape == (171, 86, 3)
    assert (color[:86] == [1, 0, 0]).all() and (color[86:] == 0).all()
    assert first.size == (256, 512)


def modules(text: str) -> dict[str, bytes]:
    source = Shaders([]).from_text(text, "fragment", "a.frag")
    return dict(compile_program([source]).spirv["opengl"])


def test_equal_modules_are_one_file_and_others_are_another(tmp_path: Path) -> None:
    quarter, half = modules(FRAGMENT), modules(FRAGMENT.replace("0.25", "0.5"))
    writers = [PictureWriter(tmp_path, "case", variant) for variant in "abc"]
    given = [{"opengl": quarter}, {"opengl": quarter}, {"opengl": quarter, "vulkan": half}]
    names = [a.write_assembly(spirv) for a, spirv in zip(writers, given, strict=True)]
    assert names[0] == names[1] != names[2]
    text, both = ((tmp_path / name).read_text() for name in (names[0], names[2]))
    assert text.startswith("; opengl fragment\n") and "OpConstant %float 0.25" in text
    first, _, second = both.partition("\n; vulkan fragment\n")
    assert first == text and "OpConstant %float 0.5" in second
    assert sorted(p.suffix for p in (tmp_path / "spirv").iterdir()) == [".spvasm"] * 2


def test_nothing_is_written_without_a_folder_or_modules(tmp_path: Path) -> None:
    assert PictureWriter(None, "case", "v").write_assembly({"opengl": modules(FRAGMENT)}) == ""
    assert PictureWriter(tmp_path, "case", "v").write_assembly({}) == ""
    assert not list(tmp_path.iterdir())


def test_the_front_page_s_picture_is_the_mean_of_light_not_of_codes(tmp_path: Path) -> None:
    """Black and white in equal parts are as bright as code 188; plain colours stay as they are."""
    codes = np.arange(256, dtype=np.uint8)[:, None].repeat(3, axis=1)
    for factor in range(2, 8):
        flat = codes.reshape(1, -1, 3).repeat(factor, axis=0).repeat(factor, axis=1)
        assert abs(pictures.shrink(flat, factor)[0].astype(int) - codes).max() <= 1
    checks = (np.indices((360, 340)).sum(axis=0) % 2)[:, :, None].repeat(3, axis=2)
    image = Image(checks.astype(np.float32), "rgba32f")
    written = PictureWriter(tmp_path, "case", "v").write_picture(image)
    small = pictures.load(tmp_path / written.files["small"])
    assert small.shape == (180, 170, 3) and (np.rint(255 * small) == 188).all()
