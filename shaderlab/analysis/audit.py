"""Audit a program: what may go wrong in it, on the inputs that it may get.

    audit = audit_program(load(source), Plan(ranges={"distance": "0..50"}))
    audit.clean                                             # no hazard was shown
    print(*audit.lines(), sep="; ")

A hazard is shown by an invocation: in float32 an instruction's operands are ones for which GLSL
defines no result there, and an output depends on its result.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from shaderlab.model.frame import Array

from .answer import format_inputs
from .batches import (
    InputBatch,
    asks_for_neighbours,
    merge_batches,
    mix_batches,
    run_batch,
    run_ending,
)
from .checks import INDEX, LEVEL, OVERFLOW, SIZES, TEXEL, Place, WatchedInstruction, Watcher
from .hazards import Audit as Audit, Claim, Hazard as Hazard, Plan as Plan
from .inputs import (
    Domains,
    Inputs,
    add_constants,
    add_mipmaps,
    coarsen_textures,
    domains_of,
    enclose_inputs,
    inputs_of,
    is_place,
    sample_inputs,
)
from .interpreter import Program
from .interpreter.running import MAX_BLOCKS
from .portability import find_spreads, widest_spreads
from .proof import BOXES, Point, Proof
from .undefined import (
    conflicts,
    divergent,
    find_dependence,
    find_dependents,
    hazard_at,
    outputs_at,
    sine_hashes,
    undefined_values,
)

RANDOM, ZERO, EQUAL = range(3)
"""What is special about an invocation: nothing; a place that is 0; two places that are equal."""
_NEAR_0 = 1e-5
_MAX_PAIRS = 120
_BOXES = 4096
_DRAWN_BOXES = 1536


def first_batch(program: Program, inputs: Inputs, domains: Domains, count: int) -> InputBatch:
    """Random invocations. Textures hold 0 and 1 here and there."""
    together = program.local_size if program.group > 1 else None
    batch = sample_inputs(inputs, domains, count, 0, together)
    return replace(batch, bindings=coarsen_textures(batch.bindings, domains))


def find_origins(batch: InputBatch, inputs: Inputs, domains: Domains) -> Array:
    """What is special about each invocation, (count,), where the author has not said that it may
    be: a place is 0, or its w is, or two places are equal."""
    places = [
        name
        for name, one in inputs.items()
        if one.type.startswith("vec") and name != "gl_FragCoord" and is_place(name)
        if domains[name].source == "assumed" and domains[name].kind == "number"
    ]
    found = np.full(batch.count, RANDOM)
    for name in places:
        found[(batch.each[name] == 0.0).all(axis=1)] = ZERO
        if inputs[name].type == "vec4":  # its w, by which perspective divides
            found[np.abs(batch.each[name][:, 3]) < _NEAR_0] = ZERO
    for a, b in itertools.islice(itertools.combinations(places, 2), _MAX_PAIRS):
        if inputs[a].type == inputs[b].type:
            found[(batch.each[a] == batch.each[b]).all(axis=1)] = EQUAL
    return found


def find_failing(
    program: Program, batch: InputBatch, *, most: int = MAX_BLOCKS, **kind: bool
) -> dict[Place, WatchedInstruction]:
    """The instructions that go wrong in a batch, in so many blocks; `kind` as of `Watcher`."""
    watcher = Watcher(batch.count, **kind)
    run_batch(program, batch, watch=watcher, max_blocks=most)
    return {place: one for place, one in watcher.found.items() if one.bad.any()}


def search_inputs(
    program: Program, inputs: Inputs, domains: Domains, plan: Plan
) -> tuple[dict[Place, Point], InputBatch, InputBatch, Proof]:
    """Try to make every instruction of a program go wrong: on random invocations and special ones,
    then in boxes in which it may. The counterexamples, those invocations, ones with the program's
    own numbers, and the boxes."""
    batch = first_batch(program, inputs, domains, plan.count)
    boxes = 0 if program.group > 1 else _BOXES  # whose points are no whole workgroups
    proof = Proof(
        program,
        inputs,
        domains,
        tried=[batch],
        boxes=BOXES if plan.prove else boxes,
        counts=None if plan.prove else lambda some: find_origins(some, inputs, domains) == RANDOM,
    )
    found = {place: one for place, one in proof.points.items() if one.watched is not None}
    find = partial(find_failing, program, most=_SHORT, made_up=True)
    # What goes wrong with inputs that are the program's own numbers, such as `id == 12345`: behind
    # conditions that nothing else meets, and where 0 is wrong. An index is not taken beyond its
    # range.
    tried, domains = batch, {} if plan.prove else add_constants(domains, inputs, [program])
    if any(domain.constants for domain in domains.values()):
        other = first_batch(program, inputs, domains, plan.count)
        failing, own = run_ending([program], find, other)
        tried = batch if failing is None else own
        for place, one in (failing or {}).items():
            if place not in proof.reached or "0" in place.kind:
                found.setdefault(place, Point(tried, int(one.bad.argmax()), one))
    if SIZES & {one.op for one in program.definitions.values()}:
        failing, own = run_ending([program], partial(find, enlarged=True), batch)
        for place, one in (failing or {}).items():
            if place.kind in (TEXEL.kind, LEVEL.kind):
                found.setdefault(place, Point(own, int(one.bad.argmax()), one))
    return found, batch, tried, proof


_SHORT = 10_000  # blocks
_EACH, _RANKED = 8, 2**23  # values that an input is given instead, and numbers in all
_MAX_CAPTURED = 16_384  # invocations of a case's draws with the same textures


def audit_program(
    program: Program, plan: Plan | None = None, captured: Sequence[InputBatch] = ()
) -> Audit:
    """Find what may go wrong in a program, on what a scene's draws give it (`captured`); without
    any, inputs are searched. Raises NotInterpretedError: it does what the interpreter does not
    know, or does not end; FormulaError: it reads what is not given; UsageError: a range is
    wrong."""
    plan = plan or Plan()
    inputs, domains = inputs_of(program), None
    if captured:
        batches = merge_batches(captured, program, _MAX_CAPTURED)
        failing = [(batch, find_failing(program, batch)) for batch in batches]
        examples = [(p, Point(batch, 0, one)) for batch, own in failing for p, one in own.items()]
        tried, others, with_constants = sum(batch.count for batch in batches), batches[0], []
        words = dict.fromkeys(inputs, "as in the case")
        if plan.prove:
            proof = prove_between_draws(program, inputs, captured)
            tried += proof.tried
            words = {n: f"{word} (in the case)" for n, word in proof.space.in_words().items()}
    else:
        domains = domains_of(inputs, [program], plan.ranges)
        found, first, others, proof = search_inputs(program, inputs, domains, plan)
        examples, tried = list(found.items()), proof.tried
        has_whole = any(one.whole for one in inputs.values())
        batches, with_constants = [first], [others] if has_whole and others is not first else []
        words = {name: f"{domain} ({domain.source})" for name, domain in domains.items()}
    hazards = [h for pair in examples for h in _hazards(program, *pair, inputs, domains, others)]
    claims: list[Claim] = []
    if plan.prove and captured:
        claims = [*proof.claims(), *proof.refuted_claims()]
    elif plan.prove:
        claims = list(_claims(program, found, proof, hazards))
    spreads = [s for b in batches if plan.precision for s in find_spreads(program, b, inputs)]
    for batch in (*batches, *with_constants):
        hazards += undefined_values(program, batch, inputs)
        hazards += sine_hashes(program, batch, inputs)
        hazards += divergent(program, batch, inputs, domains)
        hazards += conflicts(program, batch, inputs)
    if plan.confirm is not None:
        hazards = [plan.confirm(program, hazard) for hazard in hazards]
    return Audit(
        file=program.path,
        hazards=tuple(_deduplicate(hazards)),
        tried=tried,
        inputs=words,
        spreads=tuple(widest_spreads(spreads)),
        claims=tuple(claims),
    )


def prove_between_draws(
    program: Program, inputs: Inputs, captured: Sequence[InputBatch], *, at_once: bool = False
) -> Proof:
    """The boxes between the least and the greatest of what draws give a program, or, `at_once`, one
    box of a short run. Raises NotInterpretedError: they give it what is no number."""
    domains, drawn = enclose_inputs(inputs, captured)
    boxes, blocks = (1, 200) if at_once else (_DRAWN_BOXES, 2000)
    return Proof(program, inputs, domains, boxes=boxes, max_blocks=blocks, drawn=drawn)


def _claims(
    program: Program, found: Mapping[Place, Point], proof: Proof, hazards: list[Hazard]
) -> Iterator[Claim]:
    """What holds for all inputs, or is open; adds an output to the hazards that is no number for no
    reason that is there."""
    yield from proof.claims()
    shown = {(hazard.line, hazard.kind) for hazard in hazards}
    for place, (batch, row, watched) in found.items():
        file, line = program.place(watched.at.line if watched else 0)
        if (line, place.kind) not in shown and place.kind != OVERFLOW.kind:
            note = "no output depends on it with "
            note += format_inputs(batch.example(row, batch.each))
            yield Claim(file=file, line=line, what=f"no {place.kind}", status="open", note=note)
    for place, (batch, row, watched) in proof.points.items():
        if watched is None and not hazards:
            values = outputs_at(program, batch, row)
            own = {n: v for n, v in values.items() if not np.isfinite(v).all()}
            inputs, words = batch.example(row, batch.each), f"refuted: {place.kind}"
            hazards.append(
                Hazard(
                    file=program.path,
                    line=0,
                    kind=OVERFLOW.kind,
                    message=words,
                    inputs=inputs,
                    outputs=own,
                )
            )


def _hazards(
    program: Program,
    place: Place,
    point: Point,
    inputs: Inputs,
    domains: Domains | None,
    others: InputBatch,
) -> Iterator[Hazard]:
    """The hazard about an instruction; none where no output depends on its result. Of inputs that
    were searched, with the `domains`, it says what is special about them."""
    for batch, one in _alternatives(program, place, point, domains, others):
        origins = find_origins(batch, inputs, domains) if domains else np.full(batch.count, RANDOM)
        rows = np.flatnonzero(one.bad)
        rows = rows[np.argsort(origins[rows], kind="stable")]
        row, outputs = find_dependents(program, batch, rows, place)
        if outputs or place.kind == INDEX.kind:
            break
    else:
        return
    some, own = batch.alone(row, program)
    one = find_failing(program, some, made_up=domains is not None).get(place, one)
    words = one.check.words(*(one.operands.get(own) or next(iter(one.operands.values()))))
    if origins[row] != RANDOM:
        words += f"; only if {'two inputs are equal' if origins[row] == EQUAL else 'an input is 0'}"
    words = words if words.startswith(place.kind) else f"{place.kind}: {words}"
    found, evident = (place, one.at, batch, row), bool(origins[row] == RANDOM)
    names = inputs if domains is None else _rank(program, place, (batch, row), inputs, others)
    yield hazard_at(program, names, found, outputs, words, evident=evident)


def _rank(
    program: Program,
    place: Place,
    at: tuple[InputBatch, int],
    inputs: Iterable[str],
    others: InputBatch,
) -> list[str]:
    """The inputs that have values of their own, those first without which no output goes wrong."""
    names = [name for name in inputs if len(at[0].each.get(name, ())) == at[0].count]
    if len(names) < 2 or program.group > 1:
        return names
    numbers = len(names) * sum(at[0].each[name][0].size for name in names)
    turns = np.arange(min(_EACH, max(_RANKED // numbers, 1))) % others.count
    some = at[0].part(np.full(len(turns) * len(names), at[1]))
    for k, name in enumerate(names):
        some.each[name][k * len(turns) : (k + 1) * len(turns)] = others.each[name][turns]
    failing = find_failing(program, some, made_up=True).get(place)
    bad = np.zeros(some.count, np.bool_) if failing is None else failing.bad
    bad = bad & np.any(list(find_dependence(program, some, place).values()), axis=0)
    return [names[k] for k in np.argsort(bad.reshape(-1, len(turns)).all(axis=1), kind="stable")]


def _alternatives(
    program: Program, place: Place, point: Point, domains: Domains | None, others: InputBatch
) -> Iterator[tuple[InputBatch, WatchedInstruction]]:
    """Invocations at which an instruction goes wrong; of made-up inputs also with mipmaps, and such
    whose inputs are the point's or those of others."""
    batch, row, one = point
    assert one is not None
    yield batch, one
    if domains is None:
        return
    texels = {name: add_mipmaps(own) for name, own in batch.bindings.textures.items()}
    alternatives = [replace(batch, bindings=replace(batch.bindings, textures=texels))]
    if not asks_for_neighbours(program, others.bindings):
        alternatives.append(mix_batches(batch, row, others))
    for some in alternatives:
        found = find_failing(program, some, made_up=True).get(place)
        if found is not None:
            yield some, found


def _deduplicate(hazards: Sequence[Hazard]) -> list[Hazard]:
    """One of each line and kind, evident ones before others; by line."""
    found: dict[tuple[str, int, str], Hazard] = {}
    for hazard in sorted(hazards, key=lambda f: not f.evident):
        found.setdefault((hazard.file, hazard.line, hazard.kind), hazard)
    explained = {(file, line) for file, line, kind in found if kind != OVERFLOW.kind}
    for key in [key for key in found if key[2] == OVERFLOW.kind and key[:2] in explained]:
        del found[key]
    return sorted(found.values(), key=lambda f: (f.file, f.line, f.kind))
