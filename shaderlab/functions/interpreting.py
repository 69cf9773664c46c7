"""Files of functions, each of them audited or compared by itself."""

from __future__ import annotations

import contextlib
import itertools
import re
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from shaderlab.analysis.answer import Answer, OutputAnswer
from shaderlab.analysis.audit import Audit, Plan as AuditPlan, audit_program
from shaderlab.analysis.comparison import Plan as ComparisonPlan, compare_programs
from shaderlab.analysis.inputs import inputs_of, unknown_names
from shaderlab.analysis.interpreter import Program, adopt_names, load, read_file
from shaderlab.analysis.requests import ShaderOfFile, assume
from shaderlab.compiler.dialects import raise_version
from shaderlab.compiler.shader_files import HOST_INPUTS, OWN, Roots
from shaderlab.compiler.sources import Expansion, LineMap, Source
from shaderlab.compiler.translation import find_compiler
from shaderlab.engine.jobs import BareWorker
from shaderlab.errors import ShaderError, ShaderlabError, UsageError, suggest
from shaderlab.functions.evaluation import (
    Preprocess,
    as_version,
    get_caller,
    glsl_version,
    has_version,
    local_name,
)
from shaderlab.functions.lacking import Definers, complete, insert_first
from shaderlab.functions.signatures import (
    PREFIX,
    Signature,
    Type,
    declare,
    find_signatures,
    read_declarations,
)

_START = re.compile(r"[ \t]*#[ \t]*(?:version|extension)\b")
_WORDS = re.compile(r"(?<![.\w])[A-Za-z_]\w*+(?!\s*\()")  # that are no functions

_KINDS = {"vec": "float", "bvec": "bool", "ivec": "int", "uvec": "uint"}
_GLSL_NAMES = " ".join(f"typedef {k}{n} {v}{n};" for v, k in _KINDS.items() for n in (2, 3, 4))

EntryPoint = tuple[Signature, Source]
"""A function, and its file with a `main` that calls it once."""


def find_entry_points(
    written: Source,
    worker: BareWorker | None = None,
    like: Sequence[EntryPoint] = (),
    folders: Sequence[Path] = (),
) -> list[EntryPoint]:
    """The functions that a file defines itself, or all of what it includes if there is none, in
    order; preprocessed by a worker, or where calls are made. Those `like` another one, by name and
    types, have its names of parameters. What they lack comes from shader folders. Raises
    ShaderError: brackets do not match, no function."""
    named = {_key(one): one.parameters for one, _ in like}
    source = raise_version(written, "" if has_version(written) else "#version 330 core")

    def ask(request: Any) -> Any:
        return get_caller().perform(request, "") if worker is None else request.perform(worker)

    known = read_declarations(ask(Preprocess(source)))
    signatures = list(itertools.chain.from_iterable(find_signatures(known).values()))
    inputs = {one.name: one.type for each in signatures for one in each.globals}
    hosts = HOST_INPUTS.keys() & inputs.keys() - known.names
    if hosts:
        uniforms = Expansion(Roots([], {}), {}, source.version[0], source.stage)
        rows = [f"uniform {declare(inputs[name], name)};" for name in sorted(hosts)]
        uniforms.add(source.place(1), *rows)
        return find_entry_points(insert_first(written, [uniforms]), worker, like, folders)
    if folders and any(one.lacks for one in signatures):
        return find_entry_points(complete(written, folders, ask).written, worker, like)
    own_file = source.parts[0][0] if source.parts else source.path
    places = [(*source.place(n + 1), 1) for n in range(source.text.count("\n") + 1)]
    found = []
    own = [one for one in signatures if source.place(one.line)[0] == own_file]
    whole = False
    with contextlib.suppress(ShaderlabError):
        text = f"{source.text}\nvoid main() {{}}\n"
        whole = bool(load(replace(source, stage="fragment", text=text, stripped=None)))
    for signature in own or signatures:
        place = source.place(signature.line)
        signature = replace(signature, parameters=named.get(_key(signature), signature.parameters))
        added = "\n".join(_main_lines(signature, known.names)) + "\n"
        lines = LineMap.of(places + [(*place, 1)] * added.count("\n"))
        rows = source.text.split("\n")
        if not whole and not signature.globals:  # what it needs, of a file that does not compile
            code = itertools.chain(signature.code.split("\n"), itertools.repeat(""))
            rows = [row if _START.match(row) else new for row, new in zip(rows, code, strict=False)]
        text = "\n".join([*rows, added])
        made = replace(source, stage="fragment", text=text, lines=lines, stripped=None)
        if not has_version(written):
            made = as_version(made, glsl_version(written, made.code))
        found.append((replace(signature, name=signature.name.removeprefix(OWN)), made))
    if not found:
        raise ShaderError("there is no function in it, and no main", file=own_file)
    return sorted(found, key=lambda one: one[0].line)


def _key(one: Signature) -> tuple[str, ...]:
    """A function's name and types, by which another one is found that is like it."""
    types = (f"{p.direction} {p.type}" for p in one.parameters)
    return one.name.removeprefix(OWN), str(one.result), *types


def _main_lines(signature: Signature, taken: Collection[str]) -> Iterator[str]:
    """A `main` that calls the function, and what it reads and writes."""
    body, arguments, written = [], [], []

    def free(name: str) -> str:
        while name in taken:
            name += "_"
        return name

    for parameter in signature.parameters:
        name = local_name(parameter.name)
        if parameter.type.opaque:
            arguments.append(free(parameter.name))
            yield f"uniform {declare(parameter.type, arguments[-1])};"
            continue
        arguments.append(name)
        body.append(f"{declare(parameter.type, name)};")
        if parameter.direction != "out":
            for target, label, kind in _leaves(name, parameter.name, parameter.type):
                given = free(label)
                flat = "" if kind.kind == "float" else "flat "
                range_ = " // range: 0..1" if kind.kind == "bool" else ""
                yield f"{flat}in {_carrier_type(kind)} {given};{range_}"
                body.append(f"{target} = {kind.name}({given});")
        if parameter.direction != "in":
            after = "_after" if parameter.direction == "inout" else ""
            written.append((name, parameter.name + after, parameter.type))
    call = f"{signature.name}({', '.join(arguments)})"
    if signature.result.name != "void":
        call = f"{signature.result} {PREFIX}result = {call}"
        written.insert(0, (f"{PREFIX}result", signature.outputs[0][0], signature.result))
    body.append(f"{call};")
    for value, name, kind in written:
        for target, label, leaf in _leaves(value, name, kind):
            columns = [("", "", _carrier_type(leaf))]
            if len(leaf.base_shape) == 2:  # matrices are written column by column
                rows, count = leaf.base_shape
                columns = [(f"[{n}]", f"_{n}", f"vec{rows}") for n in range(count)]
            for place, suffix, held in columns:
                out = free(label + suffix)
                yield f"out {held} {out};"
                body.append(f"{out} = {held}({target}{place});")
    yield "void main() {"
    yield from body
    yield "}"


def _leaves(target: str, label: str, kind: Type) -> Iterator[tuple[str, str, Type]]:
    """The numbers, vectors and matrices of a value, each with its name."""
    for name, leaf in kind.leaves(""):
        for place in np.ndindex(leaf.dims):
            whole = name + "".join(f"[{n}]" for n in place)
            element = Type(leaf.name)
            yield target + whole, label + re.sub(r"\[(\d+)\]|\.(\w+)", r"_\1\2", whole), element


def _carrier_type(kind: Type) -> str:
    """The type that carries such a value between stages, which have no conditions."""
    return re.sub(r"^bool$", "int", re.sub(r"^bvec", "ivec", kind.name))


Plan = TypeVar("Plan", AuditPlan, ComparisonPlan)


def audit_functions(shader: ShaderOfFile, plan: AuditPlan, worker: BareWorker) -> list[Audit]:
    """The `Audit` of a file's functions as one, and one of each that is refused."""
    found, refused, definers = [], [], Definers(shader.folders)
    functions = find_entry_points(shader.source("fragment"), worker, folders=shader.folders)
    _check_ranges(plan.ranges, functions)
    for signature, source in functions:
        name = signature.name
        worker.note(f"interpreting {name}")
        try:
            program = load(source)
            known = {word.partition(".")[0].partition("[")[0] for word in inputs_of(program)}
            met = [one for one in plan.assume if set(_WORDS.findall(one)) <= known]
            program = load(assume(source, met)) if met else program
            audit = audit_program(program, _plan_of(plan, program))
        except UsageError:
            raise
        except ShaderlabError as error:
            if "nothing defines" in signature.obstacle:  # which is a syntax error to compilers
                error.message = signature.obstacle
            definers.explain(error, source, signature.lacks)
            why = f"{shader.file.path}: {name}: {error}"
            refused.append(Audit(file=shader.file.path, hazards=(), tried=0, refused=why))
            continue
        inputs = {f"{name}: {word}": role for word, role in audit.inputs.items()}
        spreads = tuple(replace(s, output=f"{name}: {s.output}") for s in audit.spreads)
        claims = tuple(replace(c, what=f"{c.what} in {name}") for c in audit.claims)
        found.append(replace(audit, inputs=inputs, spreads=spreads, claims=claims))
    merged = _merge_audits(shader.file.path, found)
    return [*(replace(audit, notes=functions[0][1].notes) for audit in merged), *refused]


def compare_functions(
    old: ShaderOfFile, new: ShaderOfFile, plan: ComparisonPlan, worker: BareWorker
) -> list[Answer]:
    """The `Answer` on the functions of two files, each an output of it."""
    ours, others = (new, old) if old.is_module else (old, new)
    functions = find_entry_points(ours.source("fragment"), worker, folders=ours.folders)
    ported = Path(others.file.path)
    ported_text = ported.read_text(errors="replace") if others.is_module else ""
    if ported_text:
        find_compiler(ported, "name two shaders in GLSL")
    text = None if ported_text else others.source("fragment")
    theirs = [] if text is None else find_entry_points(text, worker, functions, others.folders)
    _check_ranges(plan.ranges, [*functions, *theirs])
    left = {_key(signature): (signature, source) for signature, source in theirs}
    outputs: list[OutputAnswer] = []
    inputs: dict[str, str] = {}
    notes = [note for each in (functions[:1], theirs[:1]) for _, one in each for note in one.notes]
    for signature, source in functions:
        name, other = signature.name, left.pop(_key(signature), None)
        # A text without a brace only includes others, which its compiler reads.
        if other is None and not re.search(rf"\b{name}\s*\(|\A[^{{]+\Z", ported_text):
            outputs.append(OutputAnswer(name=str(signature), why="missing"))
            continue
        worker.note(f"interpreting {name}")
        try:
            mine = load(source)
            its = load(other[1]) if other else adopt_names(load_ported(signature, ported), mine)
            pair = (its, mine) if ours is new else (mine, its)
            answer = compare_programs(*pair, _plan_of(plan, *pair))
        except UsageError:
            raise
        except ShaderlabError as error:
            outputs.append(OutputAnswer(name=name, why="refused"))
            notes.append(f"undetermined for {name}: {error}")
            continue
        alone = len(answer.outputs) == 1
        outputs += [replace(o, name=name if alone else f"{name}: {o.name}") for o in answer.outputs]
        notes += [f"{name}: {note}" for note in answer.notes]
        inputs |= {f"{name}: {word}": role for word, role in answer.inputs.items()}
    notes += [f"only {others.file.path} has {signature}" for signature, _ in left.values()]
    names, said = {"old": old.file.path, "new": new.file.path}, tuple(dict.fromkeys(notes))
    return [Answer(**names, outputs=tuple(outputs), notes=said, inputs=inputs)]


def load_ported(signature: Signature, file: Path) -> Program:
    """A function of HLSL or Slang with a GLSL function's name and types, called as `main` calls
    that one. Raises ShaderError: it takes or gives others than numbers and vectors, or its compiler
    refuses the call."""
    types = [parameter.type for parameter in signature.parameters]
    plain = all(kind.kind and len(kind.shape) < 2 for kind in (*types, signature.result))
    if not plain or any(parameter.direction != "in" for parameter in signature.parameters):
        raise ShaderError("between languages only functions of numbers and vectors are compared")
    given = [f"nointerpolation {_carrier_type(kind)} x{n} : X{n}" for n, kind in enumerate(types)]
    held = _carrier_type(signature.result)
    arguments = ", ".join(f"{kind}(x{n})" for n, kind in enumerate(types))
    text = (
        f'#include "{file.resolve()}"\n{_GLSL_NAMES}\n[shader("fragment")]\n'
        f"void main({', '.join([*given, f'out {held} result : SV_Target'])})\n"
        f"{{ result = {held}({signature.name}({arguments})); }}\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        caller = Path(folder, f"caller{file.suffix}")
        caller.write_text(text)
        try:
            program = read_file(caller, "fragment")
        except ShaderError as error:
            raise ShaderError(error.message, file=file) from None
    assert program.source is not None
    return replace(program, source=replace(program.source, path=str(file)))


def _check_ranges(ranges: Mapping[str, str], functions: Sequence[EntryPoint]) -> None:
    """Raise UsageError where a range is of an input that no function has."""
    known: set[str] = set()
    for _, source in functions if ranges else ():
        with contextlib.suppress(ShaderlabError):
            known |= inputs_of(load(source)).keys()
    for name in unknown_names(list(ranges), known):
        raise UsageError(f"no function takes {name!r}", remedy=suggest(name, known))


def _plan_of(plan: Plan, *programs: Program) -> Plan:
    """The plan with the ranges of what these programs read."""
    known = [name for program in programs for name in inputs_of(program)]
    unknown = unknown_names(list(plan.ranges), known)
    return replace(plan, ranges={n: r for n, r in plan.ranges.items() if n not in unknown})


def _merge_audits(file: str, audits: Sequence[Audit]) -> Iterator[Audit]:
    """What was found in any of the functions, with the inputs of those that have a hazard. What two
    of them call was found in both."""
    hazards = {(h.line, h.file, h.kind): h for audit in audits[::-1] for h in audit.hazards}
    shown = [audit for audit in audits if audit.claims or not audit.clean] or audits
    if audits:
        yield Audit(
            file=file,
            hazards=tuple(hazards[key] for key in sorted(hazards)),
            tried=sum(audit.tried for audit in audits),
            inputs={name: role for audit in shown for name, role in audit.inputs.items()},
            spreads=tuple(spread for audit in audits for spread in audit.spreads),
            claims=tuple(claim for audit in audits for claim in audit.claims),
        )
