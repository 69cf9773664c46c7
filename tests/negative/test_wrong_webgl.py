"""Mistakes planted on the way to WebGL2: the matrix finds each, and blames that path."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import pytest

from shaderlab.cli.compare_drivers import find_disagreements
from shaderlab.engine.run import SceneRunner
from shaderlab.model.options import RunOptions
from shaderlab.model.records import Disagreement, Record
from tests.gpu.scenes import require_driver
from tests.negative.test_wrong_paths import scene

PATHS = ("llvmpipe", "webgl2")
Plant = Callable[[pytest.MonkeyPatch], None]


@pytest.fixture(scope="module")
def labs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[SceneRunner, ...]]:
    """A lab for each path, open for all tests: a browser takes a second to start."""
    frames = tmp_path_factory.mktemp("frames")
    both = tuple(
        SceneRunner(RunOptions(driver=path, size=32, pictures=False, frames=frames / path))
        for path in PATHS
    )
    with both[0], both[1]:
        require_driver(both[1])
        yield both


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return next(iter(scene(tmp_path_factory.mktemp("paths")).scenes()))


@pytest.fixture(scope="module")
def right(labs: tuple[SceneRunner, ...], made: Any) -> Record:
    """The record of the first path, in which nothing is planted, and its frames."""
    return replace(labs[0].run(made), driver_name=PATHS[0])


def matrix(
    labs: tuple[SceneRunner, ...], made: Any, right: Record, plant: Plant | None
) -> dict[str, Disagreement]:
    """Each output on both paths, something planted in the second."""
    frames = labs[0].options.frames
    assert frames is not None
    with pytest.MonkeyPatch.context() as patch:
        records = [right]
        if plant is not None:
            plant(patch)
            labs[1].backend.linker.release()  # type: ignore[attr-defined]
        records.append(replace(labs[1].run(made), driver_name=PATHS[1]))
        assert [r.message for r in records] == ["", ""]
    labs[1].backend.linker.release()  # type: ignore[attr-defined]
    return {d.output: d for d in find_disagreements(records, frames.parent)}


def function(owner: str, name: str, make: Callable[[Any], Any]) -> Plant:
    """A function of the backend does something else."""

    def plant(patch: pytest.MonkeyPatch) -> None:
        import importlib

        module, _, inner = owner.partition(":")
        found = importlib.import_module(f"shaderlab.drivers.webgl.{module}")
        found = getattr(found, inner) if inner else found
        patch.setattr(found, name, make(getattr(found, name)))

    return plant


def call(name: str, change: Callable[..., tuple[Any, ...]]) -> Plant:
    """A call of WebGL2 is made with other arguments."""
    return function("device:Calls", "add", lambda before: (
        lambda self, called, where, *given:
        before(self, called, where, *(change(*given) if called == name else given))
    ))  # fmt: skip


def essl(stage: str, old: str, new: str) -> Plant:
    """The translation of a stage writes something else."""
    return function("program", "_essl", lambda before: (
        lambda named, *rest: before(named, *rest).replace(old, new)
        if named == stage else before(named, *rest)
    ))  # fmt: skip


FAULTS: Mapping[str, tuple[Plant, str, bool]] = {
    "rows read upside down": (
        function("target:RenderTarget", "read", lambda before: (
            lambda self, name: replace(i := before(self, name), values=i.values[::-1].copy())
        )), "sheet.color", False),
    "a matrix transposed": (
        call("uniformMatrix4fv", lambda at, turned, v: (
            at, turned, v.reshape(4, 4).T.copy())), "sheet.color", False),
    "nearest for linear": (
        call("samplerParameteri", lambda made, what, word: (
            made, what, 0x2600 if word == 0x2601 else word)), "sheet.color", True),
    "the winding flipped": (
        call("frontFace", lambda face: (0x0900 + (face == 0x0900),)), "sheet.color", False),
    "a subtraction translated for an addition": (
        essl("fragment", "+ vec4(0.125)", "- vec4(0.125)"), "sheet.color", True),
    "a stage's output taken for another": (
        essl("vertex", "number + shift", "number - shift"), "sheet.marks", False),
    "another factor of blending": (
        call("blendFuncSeparate", lambda *given: (given[0], 0, given[2], 0)),
        "blended.color", True),
}  # fmt: skip


def test_without_a_mistake_nothing_is_outside(
    labs: tuple[SceneRunner, ...], made: Any, right: Record
) -> None:
    found = matrix(labs, made, right, None)
    assert len(found) == 5
    assert {d.verdict for d in found.values()} <= {"equal", "within"}, [
        f"{d.output} {d.verdict}" for d in found.values()
    ]


@pytest.mark.parametrize("fault", FAULTS)
def test_a_mistake_is_found_and_webgl2_blamed(
    labs: tuple[SceneRunner, ...], made: Any, right: Record, fault: str
) -> None:
    plant, output, blamed = FAULTS[fault]
    found = matrix(labs, made, right, plant)[output]
    assert found.differing, found
    assert found.outside == ((PATHS[1],) if blamed else ()), found
