"""A GLSL file's functions as Python callables, NumPy in, NumPy out; and what tests of them find."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from shaderlab.compiler.shader_files import EXTENSIONS
from shaderlab.compiler.sources import Shaders, Source
from shaderlab.engine.judging.laws import Law
from shaderlab.engine.settings import load_settings
from shaderlab.errors import (
    ArgumentsError,
    CallError,
    NoFunctionError,
    ShaderError,
    ShaderlabError,
    suggest,
)
from shaderlab.files import display_path
from shaderlab.functions import checks
from shaderlab.functions.call import Call, bind_arguments, find_ranges
from shaderlab.functions.checks import CallLaw
from shaderlab.functions.evaluation import evaluate, get_caller
from shaderlab.functions.lacking import Contents, Definers, complete
from shaderlab.functions.signatures import Signature, find_names_to_give
from shaderlab.model.checked import check_arguments
from shaderlab.model.records import Curve, Outcome, ProgramRecord, Record, SourceText, Status


@dataclass
class Notes:
    """What one test did: the outcomes of its checks, and the functions that it called."""

    outcomes: list[Outcome] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    called: dict[tuple[str, int], SourceText] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.outcomes or self.called)


NOTES: ContextVar[Notes | None] = ContextVar("NOTES", default=None)
"""The notes of the test that runs; None if none are taken."""


def record_of_test(
    file: str,
    name: str,
    line: int,
    *,
    status: Status,
    message: str = "",
    seconds: float = 0.0,
    lesson: str = "",
    notes: Notes | None = None,
) -> Record:
    """A test's record: its file is the case, the test a variant, each check an expectation. A test
    that asserts of itself what functions give is one expectation."""
    shown = display_path(file)
    stem = shown.rpartition("/")[2].removesuffix(".py")
    found = notes or Notes()
    outcomes = tuple(_merge_outcomes(found.outcomes))
    if not outcomes and found.called and status in ("pass", "fail"):
        calls = tuple(found.called.values())
        outcomes = (
            Outcome(
                name=name, kind="test", status=status, message=message, sources=calls, line=line
            ),
        )
    is_explained = any(outcome.status != "pass" for outcome in outcomes)
    return Record(
        id=stem,
        variant=name,
        title=lesson.partition("\n")[0].strip() or stem,
        section="",
        lesson=lesson,
        formula="",
        file=shown,
        status=status,
        message="" if is_explained else message,
        seconds=seconds,
        programs=tuple(map(_program_of, found.sources.values())),
        curves=tuple(found.curves),
        expectations=tuple(
            replace(o, sources=tuple(replace(s, file=display_path(s.file)) for s in o.sources))
            for o in outcomes
        ),
    )


def _merge_outcomes(outcomes: list[Outcome]) -> Iterator[Outcome]:
    """The outcomes, those of one property as one: its batches were judged one by one."""
    together: dict[tuple[str, int], Outcome] = {}
    for number, outcome in enumerate(outcomes):
        is_batch = outcome.kind in ("given", "proof")
        key = (outcome.name, outcome.line if is_batch else -1 - number)
        judged = outcome.judged + (together[key].judged if key in together else 0)
        together[key] = replace(outcome, judged=judged)
    names: Counter[str] = Counter()
    for outcome in together.values():
        names[outcome.name] += 1
        number = names[outcome.name]
        yield outcome if number == 1 else replace(outcome, name=f"{outcome.name} ({number})")


def _program_of(source: Source) -> ProgramRecord:
    texts = tuple(
        SourceText(file=display_path(path), line=1, language="glsl", text=text)
        for path, text in source.parts
    )
    return ProgramRecord(files=tuple(t.file for t in texts), sources=texts, verdicts=())


@dataclass
class Loads:
    """What was loaded: the sources as their authors wrote them and the names of the functions that
    were looked up, both by the text with includes. `texts` are taken in place of others."""

    texts: Mapping[str, str] = field(default_factory=dict)
    sources: dict[str, Source] = field(default_factory=dict)
    used: dict[str, set[str]] = field(default_factory=dict)
    called_outside: set[str] = field(default_factory=set)

    def take(self, source: Source) -> Source:
        self.sources.setdefault(source.text, source)
        text = self.texts.get(source.text)
        return source if text is None else replace(source, text=text, stripped=None)

    def use(self, source: Source, name: str) -> None:
        self.used.setdefault(source.text, set()).add(name)


LOADS: ContextVar[Loads | None] = ContextVar("LOADS", default=None)


class Function:
    """A GLSL function.

    Called with arrays, it is called for each of their elements: arguments broadcast as NumPy's do,
    and scalars give scalars. Floats are rounded to float32. Struct parameters take mappings,
    samplers a `shaderlab.Texture` or an array (height, width[, channels]), matrices arrays
    (…, rows, columns). Uniforms and other globals that it reads are given by their names. With
    `out` parameters it returns a named tuple of all that it writes.

    Where it uses derivatives (`dFdx`), a pixel's neighbours are its neighbours along the arguments'
    last two axes. What it discards is masked."""

    def __init__(
        self, source: Source, overloads: Sequence[Signature], folder: str, given: Mapping[str, Any]
    ) -> None:
        self.signatures = tuple(overloads)
        self.folder = folder  # what paths of textures are relative to
        self.source = source
        self._given = given
        self.__name__ = overloads[0].name
        self.__doc__ = "\n".join(map(str, overloads))

    @property
    def place(self) -> tuple[str, int]:
        return self.place_of(self.signatures[0])

    def __getitem__(self, types: str) -> Function:
        """The overload with parameters of these types, such as `f["vec3, float"]`."""
        check_arguments(Function.__getitem__, types=types)
        wanted = [word.strip() for word in types.split(",") if word.strip()]
        for one in self.signatures:
            if [str(p.type) for p in one.parameters] == wanted:
                return Function(self.source, [one], self.folder, self._given)
        raise CallError(
            f"{self.__name__} has no overload ({types})",
            remedy=f"there is {', '.join(map(str, self.signatures))}",
        )

    def __repr__(self) -> str:
        file, line = self.place
        return f"<{'; '.join(map(str, self.signatures))} of {file}:{line}>"

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """The function's results for its arguments; see the class. Raises CallError: the arguments
        fit no overload, or the call hangs or crashes; ShaderError: it does not compile."""
        __tracebackhide__ = True
        try:
            call = self.bind(*arguments, **named)
            self._note(call)
            return self.evaluate(call) if call.signature.outputs else None
        except ShaderlabError as error:
            raise self._explain(error) from error.__cause__

    def check(
        self,
        law: Law | CallLaw | Callable[..., Any],
        /,
        *arguments: Any,
        every: bool | int = False,
        **named: Any,
    ) -> None:
        """Check the function at these arguments.

        Args:
            law: a reference, a formula written with `shaderlab.glslmath`, in whose band every value
                has to lie; or a law, such as `glsl.monotone("d")`. A reference's parameters are
                found by the names of the function's (`light.constant` is light_constant) or, if it
                has other names, stand in their order. For a structure, or with `out` parameters,
                it returns a mapping, a named tuple or a tuple of all parts; for an array a list.
            arguments, named: as in a call; but a pair for one number, such as `distance=(0, 50)`,
                is a range, as in `prove`, and needs `every`.
            every: whether to check all numbers of ranges, each float32 from 0 to 50: of one float
                or integer, or several with at most 2³³ combinations; between two `np.float16`, the
                floats of 16 bits. 16 checks each 16th.

        Raises AssertionError: it does not hold, and where; CallError, ShaderError: as in a call; or
        the reference takes other arguments."""
        __tracebackhide__ = True
        curves: list[Curve] = []
        try:
            check_arguments(Function.check, law=law, every=every)
            if every:
                from shaderlab.functions.exhaustive import judge_every

                call, outcomes = judge_every(self, law, int(every), arguments, named)
            else:
                call = self.bind(*arguments, **named)
                for one, ends in find_ranges(call.signature, arguments, named):
                    raise CallError(
                        f"{self.__name__}: {one.name}={ends} is a range, and every= is not set",
                        remedy=f"every=True checks each number of it, np.linspace{(*ends, 1001)} "
                        f"some, {list(ends)} both ends",
                    )
                outcomes = checks.judge_function(self, law, call, curves)
        except ShaderlabError as error:
            raise self._explain(error) from error.__cause__
        found = self._note(call)
        if found is not None:
            found.curves += curves
            line = sys._getframe(1).f_lineno
            found.outcomes += [replace(outcome, line=line) for outcome in outcomes]
        if any(outcome.status != "pass" for outcome in outcomes):
            raise AssertionError(checks.format_failures(call, outcomes))

    def prove(self, law: Law | Callable[..., Any], /, **ranges: tuple[float, float] | str) -> None:
        """Prove that something holds of the results for all arguments of some ranges, on every
        conforming device.

        Args:
            law: a condition of the results, with the functions of `shaderlab.glslmath`, such as
                `lambda y: (y >= 0.0) & (y <= 1.0)`; or a law: `glsl.bounded`, `glsl.monotone` (of
                any two arguments that are 1/64 of the range apart, or more), `glsl.even`,
                `glsl.odd`, `glsl.symmetric`. NaN meets none.
            ranges: both ends for each argument by its name (`light_reach` is light.reach), or
                "unit" for vectors of length 1; of a texture's texels 0 to 1 by default.

        Raises AssertionError: an input for which it does not hold, or what is left open; CallError:
        a range is missing, or the function can't be interpreted alone."""
        __tracebackhide__ = True
        from shaderlab.functions.proving import prove_law

        try:
            check_arguments(Function.prove, law=law)
            outcome = prove_law(self, law, ranges)
        except ShaderlabError as error:
            raise self._explain(error) from error.__cause__
        if (found := NOTES.get()) is not None:
            found.outcomes.append(replace(outcome, line=sys._getframe(1).f_lineno))
        if outcome.status != "pass":
            raise AssertionError(outcome.message)

    def _note(self, call: Call) -> Notes | None:
        """Note a call for the test that runs, or that no test makes it."""
        found = NOTES.get()
        if found is not None:
            definition = checks.function_source(self, call)
            found.called.setdefault((definition.file, definition.line), definition)
            found.sources.setdefault(self.source.path, self.source)
        elif (known := LOADS.get()) is not None:
            known.called_outside.add(self.source.path)
        return found

    def _explain(self, error: ShaderlabError) -> ShaderlabError:
        """The error without the way that it took through the lab, which is no matter of a test's;
        about what the file lacks, with the files that have it."""
        if error.remedy is None:
            lacks = frozenset[str]().union(*(one.lacks for one in self.signatures))
            folders = _shader_folders(Path(self.folder))
            Definers(folders).explain(error, self.source, lacks)
        traceback = error.__traceback__ if os.environ.get("SHADERLAB_DEBUG") else None
        return error.with_traceback(traceback)

    def place_of(self, signature: Signature) -> tuple[str, int]:
        return self.source.place(signature.line)

    def bind(self, *arguments: Any, **named: Any) -> Call:
        """The overload that arguments fit, with them. Raises CallError."""
        return bind_arguments(self.signatures, arguments, named, self._given)

    def evaluate(self, call: Call) -> Any:
        return evaluate(self.source, self.folder, call)


def load(
    shader: str | os.PathLike[str], *, defines: Mapping[str, str] | None = None, **given: Any
) -> Library:
    """The functions of a GLSL file, of any dialect, or of a text, which has a brace or several
    lines. A path is found where the calling file's shaders are
    (`shaderlab.engine.settings.Settings.shader_folders`), or in the working folder. `defines` are
    macros to put after its `#version`, `given` values of uniforms and other globals, where a call
    has none. Raises ShaderError: there is no such file, or it or one of its includes can't be read;
    ArgumentsError: a name of `given` is none of the file's globals; CallError: the file does not
    read one of the macros. Warns of what the file lacks and was included."""
    check_arguments(load, shader=shader, defines=defines)
    if isinstance(shader, str) and re.search("[{\n]", shader):
        folders = _folders(sys._getframe(1).f_globals)
        source, folder = Shaders(folders, defines=defines).from_text(shader, "fragment", "text"), ""
    else:
        path = _find(Path(shader), _folders(sys._getframe(1).f_globals))
        source, folder = _source(path, defines), str(path.parent)
    _require_macros_read(source, defines or ())
    return Library(source, folder, given)


class Library:
    """The functions of one GLSL file, as attributes; `dir()` lists them."""

    def __init__(self, source: Source, folder: str, given: Mapping[str, Any]) -> None:
        self._written = source
        self._source = source if (known := LOADS.get()) is None else known.take(source)
        self._folder = folder
        self._given = dict(given)
        names = set(find_names_to_give(self._contents.declared)) if given else set()
        for name in given:
            if name not in names:
                raise ArgumentsError(
                    f"has no uniform or other global {name!r} to give",
                    file=source.path,
                    remedy=suggest(name, names),
                )

    def __getattr__(self, name: str) -> Function:
        if name.startswith("__"):
            raise AttributeError(name)
        return self[name]

    def __getitem__(self, name: str) -> Function:
        """The function of this name, also where Python has another use for it. Raises
        NoFunctionError, which is a KeyError, too: the file has none."""
        check_arguments(Library.__getitem__, name=name)
        found = self._functions.get(name)
        if found is None:
            raise NoFunctionError(
                f"has no function {name!r}",
                file=self._source.path,
                remedy=suggest(name, self._functions),
            )
        if (known := LOADS.get()) is not None:
            known.use(self._written, name)
        return Function(self._read, found, self._folder, self._given)

    def __contains__(self, name: object) -> bool:
        return name in self._functions

    def __iter__(self) -> Iterator[Function]:
        return (self[name] for name in self._functions)

    def __dir__(self) -> list[str]:
        own = (name for name in super().__dir__() if name.startswith("__"))
        return [*own, *self._functions]

    def __repr__(self) -> str:
        return f"<{self._source.path}: {', '.join(self._functions)}>"

    @property
    def _read(self) -> Source:
        return self._contents.read

    @property
    def _functions(self) -> Mapping[str, Sequence[Signature]]:
        return self._contents.functions

    @cached_property
    def _contents(self) -> Contents:
        """What the file has, with what it lacks."""
        ask = partial(get_caller().perform, what=f"reading {self._source.path}")
        found = complete(self._source, _shader_folders(Path(self._folder)), ask)
        for note in found.written.notes:
            warnings.warn(note, stacklevel=6)
        return found


def _folders(calling: Mapping[str, Any]) -> list[Path]:
    """Where shaders are that a module with these globals names."""
    beside = Path(calling["__file__"]).parent if calling.get("__file__") else None
    return [*(_shader_folders(beside) if beside else ()), Path.cwd()]


def _shader_folders(folder: Path) -> Sequence[Path]:
    return load_settings(folder).shader_folders(folder)


def _find(path: Path, tried: Sequence[Path]) -> Path:
    for folder in tried:
        if (folder / path).is_file():
            return Path(os.path.abspath(folder / path))
    where = ", ".join(map(str, dict.fromkeys(tried)))
    raise ShaderError(f"no such shader file in {where}", file=path)


def _require_macros_read(source: Source, names: Iterable[str]) -> None:
    """Raise CallError for a macro whose name a source has only where it is defined."""
    words = re.findall(r"\w+", source.code)
    for name in (name.partition("(")[0] for name in names):
        if words.count(name) == 1:
            asked = re.findall(r"#\s*(?:el)?if\w*\s+!?(?:defined)?\W*(\w+)", source.code)
            message = f"{source.name} does not read the macro {name!r}"
            raise CallError(message, remedy=suggest(name, asked))


def _source(path: Path, defines: Mapping[str, str] | None) -> Source:
    """The file with its includes, which are searched for as a case's are."""
    folders = _shader_folders(path.parent)
    outermost = min((f for f in folders if path.is_relative_to(f)), key=lambda f: len(f.parts))
    shaders = Shaders([outermost, *folders], defines=defines)
    stage = EXTENSIONS.get(path.suffix, "fragment")
    return shaders.load(path.relative_to(outermost).as_posix(), stage)
