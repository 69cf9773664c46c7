"""What functions of a file lack, and where their library defines it."""

from __future__ import annotations

import contextlib
import functools
import itertools
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from shaderlab.compiler.shader_files import (
    MAIN,
    MOST_FILES,
    File,
    OutsideError,
    Roots,
    strip_comments,
)
from shaderlab.compiler.sources import Expansion, LineMap, Source, with_version
from shaderlab.engine.jobs import Call
from shaderlab.errors import ShaderError, ShaderlabError
from shaderlab.files import display_path
from shaderlab.functions.evaluation import Preprocess
from shaderlab.functions.signatures import (
    Declarations,
    Signature,
    find_signatures,
    read_declarations,
)

_LACKED = re.compile(
    r"(\w+)(?:' : (?:undeclared|no matching)|, which nothing defines|\] is not known)"
)
_BODILESS = re.compile(r"No function definition \(body\) found:\s*(\w+)")
_HEAD = re.compile(r"\s*(?:#\s*(?:version|extension|define)\b.*(?<!\\)|precision\s[^;]*;\s*)?")
_TOKEN = re.compile(r"\w+|[^\w\s]")
_BLOCK = r"\{(?:[^{}]|%s)*+\}"
_BODY = functools.reduce(lambda inner, _: _BLOCK % inner, range(8), r"\{[^{}]*\}")


def _definitions(name: str) -> re.Pattern[str]:
    """Finds a macro, a constant or uniform, a structure or a function of this name."""
    return re.compile(
        rf"^[ \t]*(?:#[ \t]*define[ \t]+{name}\b(?:\\\n|.)*+"
        rf"|(?:const|uniform)\b[^;=(){{}}]*[ \t]{name}\b[^;]*;|struct\s+{name}\s*{_BODY}"
        rf"|(?!return\b|else\b)\w[\w \t]*[ \t]{name}[ \t]*\([^;{{}}]*{_BODY})",
        re.M,
    )


def insert_first(source: Source, added: Sequence[Expansion], *notes: str) -> Source:
    """The source with other texts before its own, but after what has to come first."""
    rows, codes = source.text.split("\n"), source.code.split("\n")
    at = next((n for n, row in enumerate(codes) if not _HEAD.fullmatch(row)), 0)
    spans = [(*source.place(n + 1), 1) for n in range(len(rows))]
    rows[at:at] = [row for one in added for row in one.rows]
    spans[at:at] = [span for one in added for span in one.spans]
    parts = dict(source.parts) | {path: text for one in added for path, text in one.parts.items()}
    new = replace(source, text="\n".join(rows), parts=tuple(parts.items()), stripped=None)
    return replace(new, lines=LineMap.of(spans), notes=(*source.notes, *notes))


class Definers:
    """The files in shader folders, by what they define."""

    def __init__(self, folders: Sequence[Path]) -> None:
        self._roots = Roots(folders, {})

    @functools.cached_property
    def _files(self) -> list[tuple[str, File, str]]:
        """Each file as an include names it, and its text without comments."""
        found = []
        for name in self._roots.names(MOST_FILES):
            with contextlib.suppress(ShaderError, OutsideError):
                if file := self._roots.find(name):
                    found.append((name, file, strip_comments(file.text)))
        return found

    def find(self, name: str) -> tuple[dict[str, File], bool]:
        """The files that define a name, and whether it means the same in all of them."""
        found, texts, pattern = dict[str, File](), set[str](), _definitions(name)
        for known, file, code in self._files:
            if name in code and (own := pattern.findall(code)):
                found[known] = file
                texts.add(" ".join(" ".join(own).split()))
        shaders = any(MAIN.search(strip_comments(file.text)) for file in found.values())
        return found, len(texts) == 1 and not shaders

    def include(self, message: str, source: Source) -> tuple[Expansion, str] | None:
        """The text of the file that defines the name that a source lacks, and what that is in
        words; None where no file does, or several differ."""
        lacked = _LACKED.search(message)
        files, same = self.find(lacked[1]) if lacked else ({}, False)
        if lacked is None or not same or _definitions(lacked[1]).search(source.code):
            return None
        (known, file), *_ = files.items()
        made = Expansion(self._roots, {}, source.version[0], source.stage)
        made.append(file, strip_comments(file.text), ((File(source.name, source.path, ""), 1),))
        user = display_path(source.path)
        return made, f"{user} lacks {lacked[1]}: {known}, which defines it, is included"

    def explain(self, error: ShaderlabError, source: Source, lacks: frozenset[str]) -> None:
        """Add to an error about what functions lack where that is, or who has to define it."""
        if bodiless := _BODILESS.search(error.message):
            error.message = f"{bodiless[1]} is declared, but has no body here"
            error.remedy = "define it in a file, or a text for glsl.load, that includes this one"
        lacked = _LACKED.search(error.message)
        if error.remedy or lacked is None or (name := lacked[1]) not in lacks:
            return
        if left_out := _definitions(name).search(source.code):
            place = display_path(*source.place(source.code.count("\n", 0, left_out.start()) + 1))
            error.remedy = f"an #if leaves out {name} at {place}: define the macro that it asks for"
        elif found := list(self.find(name)[0])[:3]:
            error.remedy = f"{name} is defined in {' or '.join(found)}: include it first"
        else:
            text = "in a file or a text that includes this one, or by defines= of glsl.load"
            error.remedy = f"define {name} first, {text}"


Ask = Callable[[Any], Any]
"""Performs a request, here or in a worker."""


@dataclass(frozen=True)
class Contents:
    """A file of functions as it is `written`, as it is `read`, and what it has."""

    written: Source
    read: Source
    declared: Declarations
    functions: Mapping[str, Sequence[Signature]]

    @classmethod
    def of(cls, written: Source, ask: Ask) -> Contents:
        """Raises ShaderError: it can't be preprocessed, or its brackets do not match."""
        read = with_version(written)
        try:
            declared = read_declarations(ask(Preprocess(read)))
        except ShaderError as error:
            if error.file is None:
                error.file, error.line = read.place(error.line or 1)
            raise
        return cls(written, read, declared, find_signatures(declared))

    @functools.cached_property
    def by_place(self) -> dict[tuple[Any, ...], Signature]:
        """The functions by name, file and line, which others before them do not change."""
        every = itertools.chain.from_iterable(self.functions.values())
        return {(one.name, *self.read.place(one.line)): one for one in every}

    @functools.cached_property
    def texts(self) -> frozenset[tuple[tuple[Any, ...], str]]:
        """What is declared: names, file and line, and the text's words."""
        text, place = self.declared.text, self.read.place
        return frozenset(
            ((*d.declares, *place(d.line)), " ".join(_TOKEN.findall(text[d.start : d.end])))
            for d in self.declared.all
        )

    def refusal(self, key: tuple[Any, ...], ask: Ask) -> str:
        """Why a function does not compile; "" if it does."""
        if (one := self.by_place.get(key)) is None:
            return "it is gone"
        work = "shaderlab.functions.evaluation:find_refusal"
        return one.obstacle or ask(Call(work, (self.read, one)))

    def keeps(self, old: Contents, but: Collection[tuple[Any, ...]]) -> bool:
        """Whether all but some functions are what they were, and so is what they name."""
        kept = [(key, text) for key, text in old.texts if key not in but]
        added = [key[:-2] for key, _ in self.texts - old.texts if key not in but]
        words = {word for _, text in kept for word in text.split()}
        return self.texts.issuperset(kept) and words.isdisjoint(itertools.chain(*added))


def complete(source: Source, folders: Sequence[Path], ask: Ask) -> Contents:
    """A file with what its functions lack, where one definition in the shader folders can be meant.
    A function that compiles as it is keeps its text."""
    found, definers, added = Contents.of(source, ask), Definers(folders), list[Expansion]()
    lacking = [k for k, one in found.by_place.items() if one.lacks and found.refusal(k, ask)]
    for key in lacking:
        with contextlib.suppress(ShaderError):
            tried, texts, notes = found, [*added], found.written.notes
            while (said := tried.refusal(key, ask)) and (
                more := definers.include(said, tried.written)
            ):
                # What lacks it comes after it: another text that was added, or the file itself.
                users = (n for n, one in enumerate(texts) if said.startswith(tuple(one.parts)))
                texts.insert(next(users, len(texts)), more[0])
                notes = (*notes, more[1])
                tried = Contents.of(insert_first(source, texts, *notes), ask)
            if tried.keeps(found, lacking) and (not said or _BODILESS.search(said)):
                found, added = tried, texts
    return found
