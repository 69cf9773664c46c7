"""A backend that is not OpenGL: the lab runs cases on it, and asks it for no more than it has."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from shaderlab import (
    Case,
    Ramp,
    drivers as backends,
    exact,
    formula,
    fullscreen,
    gl_call,
    gl_error,
    query,
)
from shaderlab.compiler import Source
from shaderlab.drivers import Backend, Drawn, Session, Size
from shaderlab.drivers.programs import bind
from shaderlab.drivers.programs.prepare import Programs, pass_colors
from shaderlab.drivers.programs.textures import COLOR
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import UnsupportedError, UsageError, Verdict
from shaderlab.model.case import Scene
from shaderlab.model.expectation import Expectation
from shaderlab.model.frame import Image
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Record

GRAY = 0.25


class ConstantSession(Session):
    """Draws every output in one gray."""

    def __init__(self, scene: Scene, programs: Programs, size: Size) -> None:
        super().__init__(scene, programs)
        self.size = size

    def draw(self, only: Container[str] | None = None) -> Drawn:
        images, bindings = {}, {}
        for description in self.scene.passes:
            if only is not None and description.name not in only:
                continue
            draws = self.programs[description.name]
            for index, draw in enumerate(draws):
                bindings[description.name, index] = bind.bind(draw.draw, draw.interface, no_texels)
            width, height = description.target.size or self.size
            for name, word in pass_colors(description, draws).items():
                kind = COLOR[word]
                values = np.full((height, width, kind.components), GRAY, kind.numpy)
                images[description.name, name] = Image(values, word)
        return Drawn(images=images, bindings=bindings)


class ConstantBackend(Backend):
    def __init__(self) -> None:
        self.info = {"renderer": "constant", "vendor": "tests", "version": "1", "glsl": "3.30"}

    @contextmanager
    def session(self, scene: Scene, programs: Programs, size: Size) -> Iterator[ConstantSession]:
        yield ConstantSession(scene, programs, size)

    def driver_verdict(self, sources: Sequence[Source]) -> Verdict:
        return Verdict(target="driver", ok=True)

    def close(self) -> None:
        pass


def no_texels(*_: object) -> None:
    raise UnsupportedError("textures: this backend has none")


def open_backend(driver: str) -> Backend:
    """What the registry calls."""
    assert driver == "constant"
    return ConstantBackend()


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(backends, "MODULES", {**backends.MODULES, "constant": __name__})


def run(folder: Path, *expect: Expectation) -> Record:
    (folder / "gray.frag").write_text(
        "#version 330 core\nuniform float gray;\nin vec2 p;\nout vec4 color;\n"
        "void main() { color = vec4(gray + 0.0 * p.x); }\n"
    )
    case = Case(
        title="gray", file=str(folder / "gray.py"),
        passes=fullscreen("gray.frag", uniforms={"gray": GRAY}, domain={"p": Ramp((0.0, 0.0))}),
        expect=expect,
    )  # fmt: skip
    with SceneRunner(RunOptions(size=8, driver="constant")) as lab:
        return lab.run(case.scene("default"))


def test_a_case_is_judged_on_another_backend(tmp_path: Path) -> None:
    record = run(tmp_path, exact("color", GRAY))
    assert (record.status, record.message) == ("pass", "")
    assert record.driver.startswith("constant")
    assert run(tmp_path, exact("color", 0.5)).status == "fail"


@pytest.mark.parametrize(
    ("expected", "what"),
    [
        (formula("color", lambda gray: gray), "capturing fragments"),
        (query("samples_passed", equals=64), "counting samples_passed"),
        (gl_call("glFinish"), "calls of OpenGL"),
    ],
)
def test_what_a_backend_lacks_is_unsupported_by_name(
    tmp_path: Path, expected: Expectation, what: str
) -> None:
    record = run(tmp_path, expected)
    assert record.status == "unsupported"
    assert record.message.startswith(what) and not record.expectations


def test_what_a_backend_can_answer_is_judged_beside_what_it_cannot(tmp_path: Path) -> None:
    calls = gl_call("glFinish", name="finish")
    count = query("samples_passed", equals=64, name="count")
    record = run(tmp_path, exact("color", GRAY), calls, count)
    assert record.status == "unsupported" and record.message.startswith("counting")
    assert [(o.kind, o.status) for o in record.expectations] == [("exact", "pass")]
    assert record.notices == ("not judged on this driver: 'count'",)
    assert run(tmp_path, exact("color", 0.5), calls, count).status == "fail"


def test_a_case_passes_without_what_asks_for_opengls_own_calls_and_says_so(tmp_path: Path) -> None:
    asked = gl_call("glFinish", name="finish"), gl_error("no_error", name="none")
    record = run(tmp_path, exact("color", GRAY), *asked)
    assert (record.status, record.not_asked) == ("pass", ("finish", "none"))
    assert run(tmp_path, exact("color", 0.5), *asked).status == "fail"
    alone = run(tmp_path, *asked)
    assert (alone.status, alone.not_asked) == ("unsupported", ("finish", "none"))


def test_an_unknown_driver_is_an_error_that_names_the_known() -> None:
    with pytest.raises(UsageError, match=r"unknown driver 'lavapip'\n.*lavapipe"):
        backends.open_backend("lavapip")


def test_names_come_from_the_environment_where_none_is_given(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("SHADERLAB_DRIVER", "constant")
    assert backends.probe()["renderer"] == "constant"
