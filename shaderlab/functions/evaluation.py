"""Evaluating a call in a worker: arguments laid out over a grid, the kernel run, results taken."""

from __future__ import annotations

import atexit
import functools
import keyword
import math
import os
import re
import threading
from collections import namedtuple
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.dialects import find_own_names
from shaderlab.compiler.glslang import preprocess
from shaderlab.compiler.shader_files import rename_words, strip_comments, version_of
from shaderlab.compiler.sources import LineMap, Source
from shaderlab.drivers import Evaluation
from shaderlab.engine.jobs import BareWorker, Executor, InProcessExecutor, ProcessExecutor
from shaderlab.engine.settings import load_settings
from shaderlab.errors import CallError, ShaderError
from shaderlab.functions.call import Call, build_result, collect_opaque
from shaderlab.functions.signatures import PREFIX, Input, Signature, Type, declare, rename
from shaderlab.model.frame import Array
from shaderlab.model.options import CALL_LIMITS, RunOptions

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker


MAX_WORDS = 8
"""Attachments that every driver has; what is more goes into another pass."""
_INPUT, _SHARED = f"{PREFIX}input", f"{PREFIX}shared"
_READS = {
    "float": "uintBitsToFloat({})", "int": "int({})", "uint": "{}", "bool": "(({}) != 0u)",
}  # fmt: skip
_WRITES = {
    "float": "floatBitsToUint({})", "int": "uint({})", "uint": "{}", "bool": "({} ? 1u : 0u)",
}  # fmt: skip


def _words(inputs: tuple[Input, ...]) -> int:
    return sum(one.type.words for one in inputs)


@dataclass(frozen=True)
class Kernel:
    """A function's shader for one way to give its arguments: `varying` ones differ from element to
    element, `shared` ones are the same for all, `opaque` ones (with samplers) stay uniforms."""

    signature: Signature
    varying: tuple[Input, ...]
    shared: tuple[Input, ...]
    opaque: tuple[Input, ...]

    @property
    def result_words(self) -> int:
        """How many words a call returns; one more than its outputs' where it may discard."""
        words = sum(kind.words for _, kind in self.signature.outputs)
        return words + self.signature.discards

    def head(self, version: int, words: int) -> str:
        """What comes before the function's own text, for a pass that writes so many words."""
        lines = [f"#version {version} core"]
        lines += [e.replace("require", "enable") for e in self.signature.extensions]
        if self.varying:
            lines.append(f"uniform usampler2DArray {_INPUT};")
        if self.shared:
            lines.append(f"uniform uvec4 {_SHARED}[{-(-_words(self.shared) // 4)}];")
        for n in range(words):
            lines.append(f"layout(location = {n}) out uint {PREFIX}out{n};")
        return "\n".join(lines) + "\n"

    def main(self, first: int, words: int) -> str:
        """What comes after it: `main`, writing `words` words of the results from the first on."""
        signature = self.signature
        parameters = {p.name for p in signature.parameters}
        opaque = [i for i in self.opaque if i.name in parameters]
        lines = [f"uniform {declare(i.type, local_name(i.name))};" for i in opaque]
        lines.append("void main() {")
        if self.varying:
            size = f"textureSize({_INPUT}, 0).xy - 1"
            lines.append(f"  uint {PREFIX}words[{_words(self.varying)}];")
            lines.append(f"  ivec2 {PREFIX}place = min(ivec2(gl_FragCoord.xy), {size});")
            lines.append(f"  for (int n = 0; n < {_words(self.varying)}; n++)")
            fetch = f"texelFetch({_INPUT}, ivec3({PREFIX}place, n), 0).x"
            lines.append(f"    {PREFIX}words[n] = {fetch};")
        lines += self._reading()
        for parameter in signature.parameters:
            if parameter.direction == "out":
                lines.append(f"  {declare(parameter.type, local_name(parameter.name))};")
        call = f"{signature.name}({', '.join(local_name(p.name) for p in signature.parameters)})"
        values = [local_name(p.name) for p in signature.parameters if p.direction != "in"]
        if signature.result.name != "void":
            call = f"{signature.result} {PREFIX}result = {call}"
            values.insert(0, f"{PREFIX}result")
        lines.append(f"  {call};")
        outputs = zip(values, signature.outputs, strict=True)
        written = [word for value, (_, kind) in outputs for word in _write_words(value, kind)]
        if signature.discards:
            written.append("1u")
        for n, text in enumerate(written[first : first + words]):
            lines.append(f"  {PREFIX}out{n} = {text};")
        return "\n".join([*lines, "}"]) + "\n"

    def _reading(self) -> Iterator[str]:
        """Declares arguments and reads them; sets the globals."""
        parameters = {p.name for p in self.signature.parameters}
        ways: tuple[tuple[tuple[Input, ...], Callable[[int], str]], ...] = (
            (self.varying, lambda n: f"{PREFIX}words[{n}]"),
            (self.shared, lambda n: f"{_SHARED}[{n // 4}].{'xyzw'[n % 4]}"),
        )
        for inputs, word in ways:
            at = 0
            for given in inputs:
                name = rename(given.name)
                if given.name in parameters:
                    name = local_name(given.name)
                    yield f"  {declare(given.type, name)};"
                yield from _assign(name, given.type, word, at)
                at += given.type.words
        for name, default in self.signature.state:
            yield f"  {name} = {' '.join(default.split())};"


def local_name(name: str) -> str:
    """The wrapper's variable for a parameter."""
    return f"{PREFIX}p_{name}"


def _assign(target: str, kind: Type, word: Callable[[int], str], at: int) -> Iterator[str]:
    """Statements that read a value from its words, the first of which is `at`."""
    for name, leaf in kind.leaves(target):
        size = math.prod(leaf.base_shape)
        for place in np.ndindex(leaf.dims):
            # A matrix's words are row by row, as in NumPy; GLSL's constructor takes columns.
            words = np.arange(at, at + size).reshape(leaf.base_shape).T.ravel()
            read = ", ".join(_READS[leaf.kind].format(word(int(n))) for n in words)
            yield f"  {name}{_subscripts(place)} = {leaf.name}({read});"
            at += size


def _write_words(value: str, kind: Type) -> Iterator[str]:
    """The words of a value, as expressions."""
    for name, leaf in kind.leaves(value):
        for place in np.ndindex(leaf.shape):
            if len(leaf.base_shape) == 2:
                place = (*place[:-2], place[-1], place[-2])
            yield _WRITES[leaf.kind].format(f"{name}{_subscripts(place)}")


def _subscripts(place: tuple[int, ...]) -> str:
    return "".join(f"[{n}]" for n in place)


_VERSION = re.compile(r"#version \d+")


@dataclass(frozen=True)
class Preprocess:
    """Asks for a text after the preprocessor, line for line. Raises ShaderError."""

    source: Source

    def perform(self, worker: BareWorker) -> str:
        worker.note("preprocessing")
        text = preprocess(self.source)
        if text is None:
            cached_compiler()((self.source,), ("glsl",)).require()
            raise ShaderError("the preprocessor fails", file=self.source.path)
        return text


def find_refusal(source: Source, signature: Signature, worker: BareWorker) -> str:
    """Where and why one of a file's functions does not compile; "" if it does."""
    inputs = (*signature.given, *signature.globals)
    numbers, opaque = (tuple(i for i in inputs if i.type.opaque is one) for one in (False, True))
    ((kernel, _), *_) = build_passes(source, Kernel(signature, (), numbers, opaque))
    try:
        cached_compiler()((kernel,), ("glsl",)).require()
    except ShaderError as error:
        return f"{error.file}: {error.message}"
    return ""


@dataclass(frozen=True)
class Evaluate:
    """Asks for an evaluation's results, (words, height, width), of inputs (words, height, width).
    A version of GLSL that is later than the driver's becomes that."""

    evaluation: Evaluation
    inputs: Array
    words: int
    note: str
    driver: str | None

    def perform(self, worker: Worker) -> Array:
        worker.note(self.note)
        lab = worker.lab(RunOptions(driver=self.driver))
        results = np.zeros((self.words, *self.inputs.shape[1:]), np.uint32)
        newest = int(lab.backend.info["glsl"].replace(".", "")[:3])
        passes = tuple(
            (as_version(s, min(s.version[0], newest)), n) for s, n in self.evaluation.passes
        )

        def run(passes: tuple[tuple[Source, int], ...], results: Array) -> None:
            lab.backend.evaluate(replace(self.evaluation, passes=passes), self.inputs, results)

        try:
            run(passes, results)
        except ShaderError:
            for source, _ in passes:  # glslang's words are the better ones
                cached_compiler()((source,), ("glsl",)).require()
            raise
        if lab.cuts_loops(source for source, _ in passes):
            from shaderlab.engine.loops import require_passes_to_end  # few functions have loops

            require_passes_to_end(lab, passes, lambda counted: run(counted, results.copy()))
        return results


def as_version(source: Source, version: int) -> Source:
    """The source with another `#version` of GLSL."""
    text = _VERSION.sub(f"#version {version}", source.text, count=1)
    return source if text == source.text else replace(source, text=text, stripped=None)


class Caller:
    """A worker that stays warm. One call at a time."""

    def __init__(self, executor: Executor, driver: str | None = None) -> None:
        self.driver = driver
        self.close = executor.close
        self._executor = executor
        self._lock = threading.Lock()

    def perform(self, request: Any, what: str) -> Any:
        """Return what a request gives; `what` names it in messages. Raises ShaderError, CaseError,
        CallError: as the request; it hangs, or takes its process down."""
        with self._lock:
            (result,) = self._executor.perform([request])
        if result.status == "done":
            return result.value
        if result.status == "error":
            raise result.value
        raise CallError(f"{what}: {result.message}")


_CALLER: ContextVar[Caller | None] = ContextVar("_CALLER", default=None)
Kept = TypeVar("Kept")


@contextmanager
def keeping(variable: ContextVar[Any], value: Kept) -> Iterator[Kept]:
    """Give a variable of the context another value."""
    token = variable.set(value)
    try:
        yield value
    finally:
        variable.reset(token)


@contextmanager
def use_worker(worker: Worker) -> Iterator[None]:
    """Inside a worker: calls are made in this process, on its own device."""
    driver = load_settings(Path.cwd()).driver
    made = worker.keep("caller", driver, lambda: Caller(InProcessExecutor(driver, worker), driver))
    with keeping(_CALLER, made):
        yield


def get_caller() -> Caller:
    """What makes calls: inside `use_worker` its worker, else this process's own."""
    return _CALLER.get() or _process_caller()


@functools.cache
def _process_caller() -> Caller:
    """This process's own, started at the first call; SHADERLAB_JOBS=0 calls in this process."""
    executor: Executor
    settings = load_settings(Path.cwd())
    if os.environ.get("SHADERLAB_JOBS") == "0":
        executor = InProcessExecutor(settings.driver)
    else:
        limits = CALL_LIMITS.get(settings.limits)
        executor = ProcessExecutor(settings.driver, limits, early=False)
    made = Caller(executor, settings.driver)
    atexit.register(made.close)
    return made


_MAX_SIDE = 16384
_WIDTH = 4096
_NEWEST, _OLDEST = 450, 330
# Names that became words of the language in between, where they are no qualifiers.
_TAKEN_LATER = re.compile(
    r"\b(?:buffer|coherent|patch|precise|readonly|resource|restrict|sample|shared|writeonly)\b"
    r"(?!\s*\w)"
)


def evaluate(source: Source, folder: str, call: Call) -> Any:
    """The results of a call of one of a file's functions. Raises ShaderError, CaseError, CallError:
    as `Caller.perform` and `shaderlab.drivers.Backend`."""
    signature, count = call.signature, math.prod(call.batch)
    if count > _WIDTH * _MAX_SIDE:
        raise CallError(f"{signature.name}: {count} elements are too many for one call")
    inputs = (*signature.given, *signature.globals)
    numbers = [i for i in inputs if i.name in call.values]
    kernel = Kernel(
        signature,
        tuple(i for i in numbers if call.values[i.name].varies),
        tuple(i for i in numbers if not call.values[i.name].varies),
        tuple(i for i in inputs if i.name in call.opaque),
    )
    results = np.zeros((kernel.result_words, 0), np.uint32)
    if count:
        width, height = _grid(call.batch)
        layers, at = np.zeros((_words(kernel.varying), height, width), np.uint32), 0
        for one in kernel.varying:
            call.values[one.name].fill(layers[at:], call.batch)
            at += one.type.words
        caller, what = get_caller(), f"{signature.name} of {source.path}"
        evaluation = replace(_evaluation(source, folder, call, kernel), size=(width, height))
        request = Evaluate(evaluation, layers, kernel.result_words, what, caller.driver)
        made: Array = caller.perform(request, what)
        results = made.reshape(kernel.result_words, -1)[:, :count]
    return _results(call, results)


def _evaluation(source: Source, folder: str, call: Call, kernel: Kernel) -> Evaluation:
    """The kernel with what is the same for all elements; its size is still open."""
    shared, at = np.zeros((-(-_words(kernel.shared) // 4), 4), np.uint32), 0
    for one in kernel.shared:
        argument = call.values[one.name]
        argument.fill(shared.reshape(-1, 1)[at:], argument.batch)
        at += one.type.words
    parameters = {p.name for p in kernel.signature.parameters}
    own = find_own_names(kernel.signature.code)
    uniforms, textures = collect_opaque(
        call,
        lambda name: local_name(name) if name in parameters else rename_words(rename(name), own),
    )
    return Evaluation(
        passes=build_passes(source, kernel),
        size=(0, 0),
        shared=shared,
        uniforms=uniforms,
        textures=textures,
        folder=folder,
    )


def has_version(source: Source) -> bool:
    return any(version_of(strip_comments(text)) for _, text in source.parts)


def glsl_version(source: Source, code: str) -> int:
    """The version of GLSL that code of a file is compiled as: the file's own if that is a desktop
    version, else a late one, or an early one where it has names that later ones took."""
    number, profile = source.version
    if profile != "es" and has_version(source):
        return max(number, _OLDEST)
    return _OLDEST if profile != "es" and _TAKEN_LATER.search(code) else _NEWEST


@lru_cache(maxsize=256)
def build_passes(source: Source, kernel: Kernel) -> tuple[tuple[Source, int], ...]:
    """The kernel's shaders, each with how many words it writes; their lines are the file's."""
    version = glsl_version(source, kernel.signature.code)
    code, here = kernel.signature.code, source.place(kernel.signature.line)
    own, found = find_own_names(code), []
    for first in range(0, max(kernel.result_words, 1), MAX_WORDS):
        words = min(MAX_WORDS, kernel.result_words - first)
        head, main = kernel.head(version, words), kernel.main(first, words)
        spans = [(*here, 1)] * head.count("\n")
        spans += [(*source.place(line + 1), 1) for line in range(code.count("\n") + 1)]
        spans += [(*here, 1)] * (main.count("\n") + 1)
        text = f"{head}{code}\n{rename_words(main, own)}"
        made = Source(source.name, source.path, "fragment", text, LineMap.of(spans), ())
        found.append((made, words))
    return tuple(found)


def _results(call: Call, words: Array) -> Any:
    """A call's results from their words: one value, or a named tuple of several."""
    signature, at = call.signature, 0
    kept = words[-1].reshape(call.batch) != 0 if signature.discards else None
    found = {}
    for name, kind in signature.outputs:
        value = build_result(words[at : at + kind.words], kind, call.batch)
        found[name] = value if kept is None else _mask(value, kept)
        at += kind.words
    if len(found) == 1:
        return next(iter(found.values()))
    name = signature.name + "_" * keyword.iskeyword(signature.name)
    return namedtuple(name, list(found), rename=True)(*found.values())


def _mask(value: Any, kept: Array) -> Any:
    if isinstance(value, dict):
        return {name: _mask(v, kept) for name, v in value.items()}
    if isinstance(value, list):
        return [_mask(v, kept) for v in value]
    array = np.asarray(value)
    mask = ~kept.reshape((*kept.shape, *[1] * (array.ndim - kept.ndim)))
    return np.ma.array(array, mask=np.broadcast_to(mask, array.shape))


def _grid(batch: tuple[int, ...]) -> tuple[int, int]:
    """The (width, height) of a grid with a pixel for each element: neighbours beside each other, or
    anywhere where it would be too large."""
    count, width = math.prod(batch), batch[-1] if batch else 1
    if max(width, count // width) > _MAX_SIDE:
        width = _WIDTH
    return width, -(-count // width)
