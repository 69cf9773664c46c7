"""Evaluating a call in a worker: arguments laid out over a grid, the kernel run, results taken."""

from __future__ import annotations

import atexit
import functools
import keyword
import math
import mmap
import os
import re
import threading
from collections import namedtuple
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.compiler.compile_cache import cached_compiler
from shaderlab.compiler.glslang import preprocess
from shaderlab.compiler.shader_files import strip_comments, version_of
from shaderlab.compiler.sources import LineMap, Source
from shaderlab.drivers import Evaluation
from shaderlab.engine.jobs import Executor, InProcessExecutor, ProcessExecutor
from shaderlab.engine.settings import load_settings
from shaderlab.errors import CallError, ShaderError
from shaderlab.functions.call import Argument, Call, Textures, build_result, collect_opaque
from shaderlab.functions.signatures import PREFIX, Input, Signature, Type, declare, rename
from shaderlab.model.frame import Array
from shaderlab.model.options import CALL_LIMITS, RunOptions

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker


MAX_WORDS = 8
"""Attachments that every driver has; what is more goes into another pass."""
_UNROLLED = 8
_INPUT, _SHARED = f"{PREFIX}input", f"{PREFIX}shared"
_READS = {
    "float": "uintBitsToFloat({})", "int": "int({})", "uint": "{}", "bool": "(({}) != 0u)",
}  # fmt: skip
_WRITES = {
    "float": "floatBitsToUint({})", "int": "uint({})", "uint": "{}", "bool": "({} ? 1u : 0u)",
}  # fmt: skip


@dataclass(frozen=True)
class Kernel:
    """A function's shader for one way to give its arguments: `varying` ones differ from element to
    element, `shared` ones are the same for all, `opaque` ones (with samplers) stay uniforms."""

    signature: Signature
    varying: tuple[Input, ...]
    shared: tuple[Input, ...]
    opaque: tuple[Input, ...]

    @property
    def planes(self) -> int:
        return sum(i.type.words for i in self.varying)

    @property
    def shared_words(self) -> int:
        return sum(i.type.words for i in self.shared)

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
            lines.append(f"uniform uvec4 {_SHARED}[{-(-self.shared_words // 4)}];")
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
            lines.append(f"  uint {PREFIX}words[{self.planes}];")
            lines.append(f"  ivec2 {PREFIX}place = min(ivec2(gl_FragCoord.xy), {size});")
            lines.append(f"  for (int n = 0; n < {self.planes}; n++)")
            fetch = f"texelFetch({_INPUT}, ivec3({PREFIX}place, n), 0).x"
            lines.append(f"    {PREFIX}words[n] = {fetch};")
        lines += self._reading()
        for parameter in signature.parameters:
            if parameter.direction == "out":
                lines.append(f"  {declare(parameter.type, local_name(parameter.name))};")
        call = f"{signature.name}({', '.join(local_name(p.name) for p in signature.parameters)})"
        values = [local_name(p.name) for p in signature.parameters if p.direction != "in"]
        if signature.result.name != "void":
            dims = "".join(f"[{n}]" for n in signature.result.dims)
            call = f"{signature.result.name}{dims} {PREFIX}result = {call}"
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
        for inputs, word in ((self.varying, _varying_word), (self.shared, _shared_word)):
            at = 0
            for given in inputs:
                name = rename(given.name)
                if given.name in parameters:
                    name = local_name(given.name)
                    yield f"  {declare(given.type, name)};"
                yield from _assign(name, given.type, word, str(at))
                at += given.type.words
        for name, default in self.signature.state:
            yield f"  {name} = {' '.join(default.split())};"


def local_name(name: str) -> str:
    """The wrapper's variable for a parameter."""
    return f"{PREFIX}p_{name}"


def _varying_word(index: str) -> str:
    return f"{PREFIX}words[{index}]"


def _shared_word(index: str) -> str:
    if index.isdecimal():
        return f"{_SHARED}[{int(index) // 4}].{'xyzw'[int(index) % 4]}"
    return f"{_SHARED}[({index}) >> 2][({index}) & 3]"


def _assign(
    target: str, kind: Type, word: Callable[[str], str], at: str, depth: int = 0
) -> Iterator[str]:
    """Statements that read a value from its words, the first of which is `at`."""
    if kind.dims:
        inner, count = kind.element, kind.dims[0]
        if count <= _UNROLLED:
            for n in range(count):
                yield from _assign(f"{target}[{n}]", inner, word, _plus(at, n * inner.words), depth)
            return
        i = f"i{depth}"
        yield f"  for (int {i} = 0; {i} < {count}; {i}++) {{"
        where = f"{at} + {i} * {inner.words}"
        yield from _assign(f"{target}[{i}]", inner, word, where, depth + 1)
        yield "  }"
    elif kind.members:
        for name, member in kind.members:
            yield from _assign(f"{target}.{name}", member, word, at, depth)
            at = _plus(at, member.words)
    else:
        read = [_READS[kind.kind].format(word(_plus(at, n))) for n in _constructor_order(kind)]
        yield f"  {target} = {kind.name}({', '.join(read)});"


def _plus(at: str, n: int) -> str:
    return str(int(at) + n) if at.isdecimal() else f"{at} + {n}"


def _constructor_order(kind: Type) -> list[int]:
    """The words of one element in the order of GLSL's constructor; a matrix's words are row by row,
    as in NumPy."""
    if len(kind.base_shape) == 2:
        rows, columns = kind.base_shape
        return [r * columns + c for c in range(columns) for r in range(rows)]
    return list(range(kind.words))


def _write_words(value: str, kind: Type) -> Iterator[str]:
    """The words of a value, as expressions."""
    if kind.dims:
        for n in range(kind.dims[0]):
            yield from _write_words(f"{value}[{n}]", kind.element)
    elif kind.members:
        for name, member in kind.members:
            yield from _write_words(f"{value}.{name}", member)
    elif len(kind.base_shape) == 2:
        rows, columns = kind.base_shape
        for r in range(rows):
            for c in range(columns):
                yield _WRITES[kind.kind].format(f"{value}[{c}][{r}]")
    elif kind.base_shape:
        for n in range(kind.words):
            yield _WRITES[kind.kind].format(f"{value}[{n}]")
    else:
        yield _WRITES[kind.kind].format(value)


_VERSION = re.compile(r"#version \d+")


@dataclass(frozen=True)
class Region:
    """Shared memory as another process sees it: a path that opens it, and its size in bytes."""

    path: str
    size: int

    def open(self) -> mmap.mmap:
        descriptor = os.open(self.path, os.O_RDWR)
        try:
            return mmap.mmap(descriptor, self.size)
        finally:
            os.close(descriptor)


class SharedMemory:
    """Memory that the calling process and a worker share, so that arrays are not sent. It has no
    name and no size limit: the worker opens this process's file descriptor. It grows as
    needed; what was in it is lost then."""

    def __init__(self) -> None:
        self._file = os.fdopen(os.memfd_create("shaderlab"), "r+b")
        self._map: mmap.mmap | None = None
        self._size = 0

    def words(self, count: int) -> Array:
        if 4 * count > self._size or self._map is None:
            self._size = max(4 * count, 2 * self._size, mmap.PAGESIZE)
            os.ftruncate(self._file.fileno(), self._size)
            self._map = mmap.mmap(self._file.fileno(), self._size)
        return np.frombuffer(self._map, np.uint32, count)

    @property
    def region(self) -> Region:
        return Region(f"/proc/{os.getpid()}/fd/{self._file.fileno()}", self._size)


@dataclass(frozen=True)
class Preprocess:
    """Asks for a text after the preprocessor, line for line. Raises ShaderError."""

    source: Source

    def perform(self, worker: Worker) -> str:
        worker.note("preprocessing")
        text = preprocess(self.source)
        if text is None:
            cached_compiler()((self.source,), ("glsl",)).require()
            raise ShaderError("the preprocessor fails", file=self.source.path)
        return text


@dataclass(frozen=True)
class Evaluate:
    """Asks for an evaluation; inputs are at the start of the memory, outputs behind them.
    The `versions` of GLSL are tried in turn; one later than the driver's becomes that."""

    evaluation: Evaluation
    versions: tuple[int, ...]
    layers: int
    words: int
    region: Region
    note: str
    driver: str | None

    def perform(self, worker: Worker) -> None:
        worker.note(self.note)
        lab = worker.lab(RunOptions(driver=self.driver))
        memory = worker.keep("memory", self.region, self.region.open)
        width, height = self.evaluation.size
        count = self.layers + self.words
        whole = np.frombuffer(memory, np.uint32, count * height * width)
        layers = whole.reshape(count, height, width)
        newest = int(lab.backend.info["glsl"].replace(".", "")[:3])
        refused: ShaderError | None = None
        for version in self.versions:
            passes = tuple(
                (as_version(s, min(version, newest)), n) for s, n in self.evaluation.passes
            )
            evaluation = replace(self.evaluation, passes=passes)
            try:
                lab.backend.evaluate(evaluation, layers[: self.layers], layers[self.layers :])
            except ShaderError as error:
                refused = refused or error
            else:
                return
        assert refused is not None
        for source, _ in self.evaluation.passes:  # glslang's words are the better ones
            cached_compiler()((source,), ("glsl",)).require()
        raise refused


def as_version(source: Source, version: int) -> Source:
    """The source with another `#version` of GLSL."""
    text = _VERSION.sub(f"#version {version}", source.text, count=1)
    return source if text == source.text else replace(source, text=text, stripped=None)


class Caller:
    """A worker that stays warm, and the memory shared with it. One call at a time."""

    def __init__(self, executor: Executor, driver: str | None = None) -> None:
        self._driver = driver
        self._executor = executor
        self._lock = threading.Lock()
        self._memory = SharedMemory()

    def preprocess(self, source: Source) -> str:
        """A source's text after the preprocessor. Raises ShaderError, CallError."""
        with self._lock:
            text: str = self._perform(Preprocess(source), f"preprocessing {source.path}")
        return text

    def evaluate(
        self,
        evaluation: Evaluation,
        versions: tuple[int, ...],
        arguments: Sequence[Argument],
        batch: tuple[int, ...],
        results: Array,
        what: str,
    ) -> None:
        """Evaluate arguments, broadcast to `batch`, into `results`, (words, count) of uint32.
        `versions` are those of GLSL to try, `what` names the evaluation in messages.

        Raises:
            ShaderError, CaseError, CallError: as `shaderlab.drivers.Backend.evaluate`; it hangs,
                or takes its process down.
        """
        width, height = evaluation.size
        layers, words = sum(argument.type.words for argument in arguments), len(results)
        with self._lock:
            memory = self._memory.words((layers + words) * width * height)
            whole = memory.reshape(-1, height, width)
            at = 0
            for argument in arguments:
                argument.fill(whole[at:], batch)
                at += argument.type.words
            request = Evaluate(
                evaluation, versions, layers, words, self._memory.region, what, self._driver
            )
            self._perform(request, what)
            np.copyto(results, whole[layers:].reshape(words, -1)[:, : results.shape[1]])

    def close(self) -> None:
        self._executor.close()

    def _perform(self, request: Any, what: str) -> Any:
        (result,) = self._executor.perform([request])
        if result.status == "done":
            return result.value
        if result.status == "error":
            raise result.value
        raise CallError(f"{what}: {result.message}")


_CALLER: ContextVar[Caller | None] = ContextVar("_CALLER", default=None)


@contextmanager
def use_worker(worker: Worker) -> Iterator[None]:
    """Inside a worker: calls are made in this process, on its own device."""
    driver = load_settings(Path.cwd()).driver
    made = worker.keep("caller", driver, lambda: Caller(InProcessExecutor(driver, worker), driver))
    token = _CALLER.set(made)
    try:
        yield
    finally:
        _CALLER.reset(token)


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
_WORDS = 1 << 25
"""Words of inputs and outputs that are evaluated at a time: more would only take more memory."""
_NEWEST, _OLDEST = 450, 330


def evaluate(source: Source, folder: str, call: Call) -> Any:
    """The results of a call of one of a file's functions.

    Raises:
        ShaderError, CaseError, CallError: as `Caller.evaluate`.
    """
    signature, count = call.signature, math.prod(call.batch)
    inputs = (*signature.given, *signature.globals)
    numbers = [i for i in inputs if i.name in call.values]
    kernel = Kernel(
        signature,
        tuple(i for i in numbers if call.values[i.name].varies),
        tuple(i for i in numbers if not call.values[i.name].varies),
        tuple(i for i in inputs if i.name in call.opaque),
    )
    results = np.zeros((kernel.result_words, count), np.uint32)
    varying = [call.values[i.name] for i in kernel.varying]
    evaluation = _evaluation(source, folder, call, kernel)

    def run(arguments: Sequence[Argument], batch: tuple[int, ...], part: Array) -> None:
        what = f"{signature.name} of {source.path}"
        sized = replace(evaluation, size=_grid(batch) or _fold(math.prod(batch)))
        get_caller().evaluate(sized, glsl_versions(source), arguments, batch, part, what)

    chunk = max(_WORDS // (kernel.planes + kernel.result_words), 1)
    if count and (count <= chunk or (signature.per_pixel and _grid(call.batch))):
        run(varying, call.batch, results)
    elif count:
        flat = [_flatten(argument, call.batch) for argument in varying]
        for start in range(0, count, chunk):
            some = slice(start, min(start + chunk, count))
            parts = [_part(argument, some) for argument in flat]
            run(parts, (some.stop - start,), results[:, some])
    return _results(call, results)


def _evaluation(source: Source, folder: str, call: Call, kernel: Kernel) -> Evaluation:
    """The kernel with what is the same for all elements; its size is still open."""
    shared = np.zeros((-(-kernel.shared_words // 4), 4), np.uint32)
    words = [call.values[i.name].shared_words() for i in kernel.shared]
    if words:
        shared.reshape(-1)[: kernel.shared_words] = np.concatenate(words)
    uniforms: dict[str, Array] = {}
    textures: Textures = {}
    parameters = {p.name for p in kernel.signature.parameters}
    for one in kernel.opaque:
        name = local_name(one.name) if one.name in parameters else rename(one.name)
        label = f"{kernel.signature.name}: {one.name}"
        found = collect_opaque(name, call.opaque[one.name], one.type, label)
        uniforms |= found[0]
        textures |= found[1]
    return Evaluation(
        passes=build_passes(source, kernel),
        size=(0, 0),
        shared=shared,
        uniforms=uniforms,
        textures=textures,
        folder=folder,
    )


def glsl_versions(source: Source) -> tuple[int, ...]:
    """The versions of GLSL that a file may be compiled as: its own if that is a desktop version,
    else a late one, or an early one where it has names that later ones took."""
    number, profile = source.version
    if profile == "es":
        return (_NEWEST,)
    has_own = any(version_of(strip_comments(text)) for _, text in source.parts)
    return (max(number, _OLDEST),) if has_own else (_NEWEST, _OLDEST)


@lru_cache(maxsize=256)
def build_passes(source: Source, kernel: Kernel) -> tuple[tuple[Source, int], ...]:
    """The kernel's shaders, each with how many words it writes; their lines are the file's."""
    version = glsl_versions(source)[0]
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


def _grid(batch: tuple[int, ...]) -> tuple[int, int] | None:
    """The (width, height) of a grid with a pixel for each element, neighbours beside each other;
    None where it would be too large."""
    width = batch[-1] if batch else 1
    height = math.prod(batch[:-1])
    return (width, height) if 0 < max(width, height) <= _MAX_SIDE else None


def _fold(count: int) -> tuple[int, int]:
    """The (width, height) of a grid with a pixel for each element, neighbours anywhere."""
    width = min(_WIDTH, count)
    return width, -(-count // width)


def _flatten(given: Argument, batch: tuple[int, ...]) -> Argument:
    count = math.prod(batch)
    leaves = tuple(
        np.broadcast_to(leaf, (*batch, leaf.shape[-1])).reshape(count, leaf.shape[-1])
        for leaf in given.leaves
    )
    return Argument(given.type, (count,), leaves)


def _part(given: Argument, some: slice) -> Argument:
    leaves = tuple(leaf[some] for leaf in given.leaves)
    return Argument(given.type, (some.stop - some.start,), leaves)
