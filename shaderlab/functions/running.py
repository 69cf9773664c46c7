"""Running a call: its kernel made, its arguments laid out over a grid, its results taken."""

from __future__ import annotations

import keyword
import math
from collections import namedtuple
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from shaderlab.compiler.sources import LineMap, Source
from shaderlab.compiler.text import version_of, without_comments
from shaderlab.drivers import Evaluation
from shaderlab.functions.arguments import Argument, result
from shaderlab.functions.binding import Call
from shaderlab.functions.calling import caller
from shaderlab.functions.kernels import LANES, MAX_WORDS, Kernel, own
from shaderlab.functions.opaque import spread
from shaderlab.functions.signatures import variable
from shaderlab.model.frame import Array

_MAX_SIDE = 16384
_WIDTH = 4096
_WORDS = 1 << 25
"""Words of inputs and outputs that are evaluated at a time: more would only take more memory."""
_FEW = 1 << 14
"""Up to so many elements a pixel each: compiling for four costs more than it saves."""
_NEWEST, _OLDEST = 450, 330


def evaluate(source: Source, folder: str, call: Call) -> Any:
    """The results of a call of one of a file's functions.

    Args:
        source: the file.
        folder: what paths of textures are relative to.
        call: the function and its arguments.

    Raises:
        ShaderError, CaseError, CallError: as `shaderlab.functions.calling.Caller.evaluate`.
    """
    signature, count = call.signature, math.prod(call.batch)
    one_each = signature.per_pixel or count <= _FEW
    inputs = (*signature.given, *signature.globals)
    numbers = [i for i in inputs if i.name in call.values]
    kernel = Kernel(
        signature,
        tuple(i for i in numbers if call.values[i.name].varies),
        tuple(i for i in numbers if not call.values[i.name].varies),
        tuple(i for i in inputs if i.name in call.opaque),
        1 if one_each else LANES,
    )
    words = kernel.result_words
    varying = [call.values[i.name] for i in kernel.varying]
    run = _Run(source, folder, call, kernel)
    if not count:
        return _results(call, np.zeros((words, 0), np.uint32))
    grid = _grid(call.batch)
    chunk = max(_WORDS // (kernel.planes + words), 1)
    if count <= chunk or (grid is not None and signature.per_pixel):
        return _results(call, run(varying, call.batch, np.copy))
    found = np.empty((words, count), np.uint32)
    flat = [_flattened(argument, call.batch) for argument in varying]
    for start in range(0, count, chunk):
        some = slice(start, min(start + chunk, count))
        part = found[:, some]
        run(
            [_part(argument, some) for argument in flat],
            (some.stop - start,),
            lambda taken, part=part: np.copyto(part, taken),  # type: ignore[misc]
        )
    return _results(call, found)


class _Run:
    """Runs a kernel over some of a call's elements."""

    def __init__(self, source: Source, folder: str, call: Call, kernel: Kernel) -> None:
        self._kernel = kernel
        self._what = f"{kernel.signature.name} of {source.path}"
        self._folder = folder
        self._passes = passes(source, kernel)
        self._versions = versions(source)
        self._shared = np.zeros((-(-kernel.shared_words // 4), 4), np.uint32)
        words = [call.values[i.name].shared_words() for i in kernel.shared]
        if words:
            self._shared.reshape(-1)[: kernel.shared_words] = np.concatenate(words)
        self._uniforms: dict[str, Array] = {}
        self._textures: dict[str, tuple[str, Any]] = {}
        parameters = {p.name for p in kernel.signature.parameters}
        for one in kernel.opaque:
            name = own(one.name) if one.name in parameters else variable(one.name)
            label = f"{kernel.signature.name}: {one.name}"
            value = call.opaque[one.name]
            spread(name, value, one.type, label, self._uniforms, self._textures)

    def __call__(
        self, varying: Sequence[Argument], batch: tuple[int, ...], take: Callable[[Array], Any]
    ) -> Any:
        """What `take` makes of the results' words, (words, count)."""
        kernel, count = self._kernel, math.prod(batch)
        size = _grid(batch) if kernel.lanes == 1 else None
        if size is None:
            pixels = -(-count // kernel.lanes)
            width = min(_WIDTH, pixels)
            size = (width, -(-pixels // width))
        evaluation = Evaluation(
            passes=self._passes,
            size=size,
            lanes=kernel.lanes,
            shared=self._shared,
            uniforms=self._uniforms,
            textures=self._textures,
            folder=self._folder,
        )

        def fill(layers: Array) -> None:
            at = 0
            for given in varying:
                given.fill(layers[at:], batch)
                at += given.type.words

        return caller().evaluate(
            evaluation,
            self._versions,
            kernel.planes,
            kernel.result_words,
            self._what,
            fill,
            lambda outputs: take(outputs.reshape(len(outputs), -1)[:, :count]),
        )


def versions(source: Source) -> tuple[int, ...]:
    """The versions of GLSL that a file may be compiled as: its own if it says one of the desktop's,
    else a late one, or an early one where it has names that later ones took."""
    number, profile = source.version
    if profile == "es":
        return (_NEWEST,)
    says = any(version_of(without_comments(text)) for _, text in source.parts)
    return (max(number, _OLDEST),) if says else (_NEWEST, _OLDEST)


@lru_cache(maxsize=256)
def passes(source: Source, kernel: Kernel) -> tuple[tuple[Source, int], ...]:
    """The kernel's shaders, each with how many words it writes; their lines are the file's."""
    version = versions(source)[0]
    code, here = kernel.signature.code, source.place(kernel.signature.line)
    found = []
    for first in range(0, max(kernel.result_words, 1), MAX_WORDS):
        words = min(MAX_WORDS, kernel.result_words - first)
        head, main = kernel.head(version, words), kernel.main(first, words)
        spans = [(*here, 1)] * head.count("\n")
        spans += [(*source.place(line + 1), 1) for line in range(code.count("\n") + 1)]
        spans += [(*here, 1)] * (main.count("\n") + 1)
        text = f"{head}{code}\n{main}"
        made = Source(source.name, source.path, "fragment", text, LineMap.of(spans), ())
        found.append((made, words))
    return tuple(found)


def _results(call: Call, words: Array) -> Any:
    """A call's results from their words: one value, or a named tuple of several."""
    signature, at = call.signature, 0
    kept = words[-1].reshape(call.batch) != 0 if signature.discards else None
    found = {}
    for name, kind in signature.outputs:
        value = result(words[at : at + kind.words], kind, call.batch)
        found[name] = value if kept is None else _masked(value, kept)
        at += kind.words
    if len(found) == 1:
        return next(iter(found.values()))
    name = signature.name + "_" * keyword.iskeyword(signature.name)
    return namedtuple(name, list(found), rename=True)(*found.values())


def _masked(value: Any, kept: Array) -> Any:
    if isinstance(value, dict):
        return {name: _masked(v, kept) for name, v in value.items()}
    if isinstance(value, list):
        return [_masked(v, kept) for v in value]
    array = np.asarray(value)
    mask = ~kept.reshape((*kept.shape, *[1] * (array.ndim - kept.ndim)))
    return np.ma.array(array, mask=np.broadcast_to(mask, array.shape))


def _grid(batch: tuple[int, ...]) -> tuple[int, int] | None:
    """The (width, height) of a grid with a pixel for each element, neighbours beside each other;
    None where it would be too large."""
    width = batch[-1] if batch else 1
    height = math.prod(batch[:-1])
    return (width, height) if 0 < max(width, height) <= _MAX_SIDE else None


def _flattened(given: Argument, batch: tuple[int, ...]) -> Argument:
    count = math.prod(batch)
    leaves = tuple(
        np.broadcast_to(leaf, (*batch, leaf.shape[-1])).reshape(count, leaf.shape[-1])
        for leaf in given.leaves
    )
    return Argument(given.type, (count,), leaves)


def _part(given: Argument, some: slice) -> Argument:
    leaves = tuple(leaf[some] for leaf in given.leaves)
    return Argument(given.type, (some.stop - some.start,), leaves)
