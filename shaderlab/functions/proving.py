"""Proofs of functions, and refutations run on a driver."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab.analysis.answer import format_inputs
from shaderlab.analysis.audit import Audit, Hazard
from shaderlab.analysis.batches import InputBatch, asks_for_neighbours
from shaderlab.analysis.boxes import ARITHMETIC, ends_of
from shaderlab.analysis.inputs import domains_of, inputs_of, sample_inputs
from shaderlab.analysis.interpreter import Program, load
from shaderlab.analysis.interpreter.interpret import interface_name
from shaderlab.analysis.proof import BOXES, Condition, Proof
from shaderlab.analysis.requests import AuditFile
from shaderlab.analysis.undefined import outputs_at
from shaderlab.bands import Band
from shaderlab.bands.exact import DECIDING
from shaderlab.compiler.shader_files import MAIN
from shaderlab.compiler.spirv import StorageClass, type_name
from shaderlab.engine.judging.laws import Bounded, Law, Monotone, fit_shape
from shaderlab.errors import CallError, FormulaError, ShaderlabError
from shaderlab.functions.checks import call_other
from shaderlab.functions.evaluation import keeping, use_worker
from shaderlab.functions.interpreting import audit_functions, find_entry_points
from shaderlab.functions.library import Function, Library
from shaderlab.functions.signatures import PREFIX, Type
from shaderlab.model.frame import Bindings
from shaderlab.model.records import Outcome, SourceText

if TYPE_CHECKING:
    from shaderlab.engine.worker import Worker

_BOXES = 1024  # of a test, which is called for each
_STEPS = 64  # of the range of an argument
_MOST_INPUTS = 200  # llvmpipe compiles so many in 5 s, 500 in 30 s
_NUMBERS = re.compile(r"(float|int|uint|[iu]?vec[234])")


def prove_law(function: Function, law: Any, ranges: Mapping[str, Any]) -> Outcome:
    """Whether a law or a condition of a function's results holds; see `Function.prove`."""
    asked = function
    holds = partial(_keeps, law) if isinstance(law, Law) else partial(call_other, law)
    if isinstance(law, Law):
        asked, ranges = _compare(function, law, ranges)
    program, proof = find_proof(
        asked, lambda outputs, _: {"the law holds": holds(*outputs.values())}, ranges
    )
    signature, inputs = function.signatures[0], proof.space.inputs
    message = "; ".join(str(one) for one in proof.claims() if one.status == "open")
    for batch, row, _ in proof.points.values():
        example = batch.example(row, inputs)
        shown = outputs_at(program, batch, row)
        del shown["discard"]
        found = Hazard(file="", line=0, kind="", message="", inputs=example, outputs=shown)
        message = f"{signature} breaks the law with {format_inputs(example)}\n"
        message += f"    {format_inputs(shown)}\n    {_confirm(program, found).driver}"
    file, line = function.place_of(signature)
    text = SourceText(file=file, line=line, language="glsl", text=signature.definition)
    return Outcome(
        name=function.__name__,
        kind="proof",
        status="fail" if message else "pass",
        message=message,
        judged=proof.tried,
        sources=(text,),
    )


def _compare(function: Function, law: Law, ranges: Mapping[str, Any]) -> tuple[Function, Any]:
    """A function of two results of which a law says something, and its ranges. A monotone one's are
    of arguments one to two steps apart: such steps lead to any larger one."""
    signature, step = function.signatures[0], f"{PREFIX}step"
    kinds = {one.name: str(one.type) for one in signature.given}
    if any(kinds.get(n) != "float" for n in law.inputs) or len(signature.outputs) > 1:
        raise CallError(f"{law.title} is proved of one result, and floats of {', '.join(kinds)}")
    if isinstance(law, Bounded):
        for end in law.ends:
            fit_shape(end, signature.outputs[0][1].shape or (1,), "a bound")
        return function, ranges
    changed = {name: name for name in kinds}
    if isinstance(law, Monotone):
        ends: Any = ranges.get(law.over)
        if not isinstance(ends, tuple | list) or len(ends) != 2:
            raise CallError(f"{function.__name__}: {law.over} has no range")
        low, high = ends
        size = (high - low) / _STEPS
        ranges = {**ranges, law.over: (low, high - size), step: (0.99 * size, 2.0 * size)}
        changed[law.over], kinds[step] = f"min({law.over} + {step}, {float(high)!r})", "float"
    else:
        signed = "-" if len(law.inputs) == 1 else ""
        changed |= {a: signed + b for a, b in zip(law.inputs, law.inputs[::-1], strict=True)}
    others = ", ".join(f"{kind} {name}" for name, kind in kinds.items())
    text = f"""{function.source.text}
        {signature.result} {PREFIX}law({others}, out {signature.result} changed) {{
            changed = {signature.name}({", ".join(changed.values())});
            return {signature.name}({", ".join(changed)});
        }}"""
    source = replace(function.source, text=text, stripped=None)
    return Library(source, function.folder, {})[f"{PREFIX}law"], ranges


@np.errstate(all="ignore")
def _keeps(law: Any, y: Any, z: Any = None) -> Any:
    """Whether a law holds of one result, or two."""
    if isinstance(law, Bounded):
        low, high = law.ends
        return (y >= low) & (y <= high)
    if isinstance(law, Monotone):
        least, most = (y, z) if law.direction == "increasing" else (z, y)
        return least < most if law.strict else least <= most
    low, high = ends_of(z) if isinstance(z, Band) else (z, z)
    last = np.spacing(np.abs(np.clip(0.0, low, high)).astype(np.float32))
    return abs(y - z if law.sign > 0 else y + z) <= np.fmax(law.ulp * last, law.within)


def find_proof(
    function: Function, condition: Condition, ranges: Mapping[str, Any], boxes: int = BOXES
) -> tuple[Program, Proof]:
    """A function's program, and the search for a condition of its results in ranges of its
    arguments. Raises CallError, UsageError, NotInterpretedError: it can't be asked about, or has
    other arguments."""
    entries = {str(one): stage for one, stage in find_entry_points(function.source)}
    signature = function.signatures[0]
    if len(function.signatures) > 1 or str(signature) not in entries:
        raise CallError(f"{function.__name__} is overloaded, or of an included file")
    program = load(entries[str(signature)])
    inputs = inputs_of(program)
    pairs = (tuple, list, np.ndarray)
    words = {
        n: ":".join(map(str, r)) if isinstance(r, pairs) else str(r) for n, r in ranges.items()
    }
    domains = domains_of(inputs, [program], words)
    for name, domain in domains.items():
        if domain.source == "assumed" and domain.kind != "texture":
            raise CallError(f"{function.__name__}: {name} has no range", remedy=f"{name}=(0, 1)")
    samples = [sample_inputs(inputs, domains, 1024, 0)]
    return program, Proof(
        program, inputs, domains, condition=condition, tried=samples, hazards=False, boxes=boxes
    )


def prove_test(
    function: Function, test: Callable[..., Any], ranges: Mapping[str, Any], results: Sequence[str]
) -> Proof:
    """The search for arguments for which a test of them and of the `results` fails, called with
    bands of each box, and in float32. Raises as the test and `find_proof`."""
    names = inspect.signature(test).parameters
    floats = {one.name for one in function.signatures[0].given if one.type.kind == "float"}

    def hold(outputs: Mapping[str, Any], batch: InputBatch) -> Mapping[str, Any]:
        given = {
            name: Band.between(v.real, v.imag, ARITHMETIC.rules) if np.iscomplexobj(v) else v
            for name, v in batch.each.items()
            if name in floats
        } | dict(outputs)
        if len(results) == len(outputs) == 1:
            given[results[0]] = next(iter(outputs.values()))

        def holds(rows: slice) -> bool:
            try:
                found = test(**{name: given[name][rows] for name in names})
                return found is None or bool(
                    found.all() if isinstance(found, np.ndarray) else found
                )
            except (AssertionError, FormulaError, ValueError):  # or it is undecided
                return False

        whole = holds(slice(None))
        each = [whole or holds(slice(row, row + 1)) for row in range(batch.count)]
        return {"the test holds": np.array(each)}

    with keeping(DECIDING, True):
        return find_proof(function, hold, ranges, _BOXES)[1]


def prove_file(request: AuditFile, functions: bool, worker: Worker) -> list[Audit]:
    """The audits that are asked for, or those of a file's functions, with each refutation run on
    the driver."""
    shader, plan = request.shader, replace(request.plan, confirm=_confirm)
    with use_worker(worker):
        if functions:
            return audit_functions(shader, plan, worker)
        return replace(request, plan=plan).perform(worker)


def _confirm(program: Program, hazard: Hazard) -> Hazard:
    """The hazard with what the driver writes for its inputs."""
    try:
        found = run_on_driver(program, hazard.inputs)
    except ShaderlabError as error:
        return replace(hazard, driver=f"not run on the driver: {error.message}")
    shown = {name: found[name] for name in hazard.outputs if name in found} or found
    return replace(hazard, driver=f"on the driver {format_inputs(shown)}")


def run_on_driver(
    program: Program, inputs: Mapping[str, tuple[float, ...]]
) -> dict[str, tuple[float, ...]]:
    """What the driver writes to each output that is a number or a vector, for one invocation.
    Raises ShaderlabError: the stage takes more than numbers, or does not run."""
    source, module = program.source, program.module
    assert source is not None
    outputs = {
        interface_name(program, id_): type_name(module, pointee)
        for id_, (pointee, storage) in module.variables.items()
        if storage == StorageClass.Output
    }
    outputs = {name: kind for name, kind in outputs.items() if _NUMBERS.fullmatch(kind)}
    alone = not asks_for_neighbours(program, Bindings())
    if not outputs or not alone or any(name.startswith("gl_") for name in inputs):
        raise CallError("it depends on more than its inputs")
    if len(inputs) > _MOST_INPUTS:
        raise CallError(f"it reads more than {_MOST_INPUTS} numbers, vectors and matrices")
    parameters = ", ".join(f"out {kind} {PREFIX}{name}" for name, kind in outputs.items())
    body = " ".join(f"{PREFIX}{name} = {name};" for name in outputs)
    text = MAIN.sub(f"void {PREFIX}main(", source.text)
    text += f"\nvoid {PREFIX}run({parameters}) {{ {PREFIX}main(); {body} }}\n"
    function = Library(replace(source, text=text, stripped=None), "", {})[f"{PREFIX}run"]
    given = function.signatures[0].globals
    result = function(**{one.name: _assemble(one.type, one.name, inputs) for one in given})
    values = result if isinstance(result, tuple) else (result,)
    return {
        name: tuple(np.ravel(np.ma.filled(value, np.nan)).astype(float).tolist())
        for name, value in zip(outputs, values, strict=True)
    }


def _assemble(kind: Type, name: str, inputs: Mapping[str, tuple[float, ...]]) -> Any:
    """An input's value, of those of its parts by name."""
    if kind.dims:
        return [_assemble(kind.element, f"{name}[{i}]", inputs) for i in range(kind.dims[0])]
    if kind.members:
        return {part: _assemble(its, f"{name}.{part}", inputs) for part, its in kind.members}
    if name not in inputs:
        raise CallError(f"{name} is no number, or is not read")
    whole = kind.kind in ("int", "uint", "bool")
    values = np.array(inputs[name], np.int64 if whole else np.float32).reshape(kind.shape)
    return values.astype(np.bool_) if kind.kind == "bool" else values
