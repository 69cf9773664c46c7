"""Does the first line at which a driver leaves a shader's band name the statement that is wrong?

`python -m benchmarks.locating [CASE…] --each 25` makes mistakes in fragment shaders, as `shaderlab
mutate` does, and has the driver draw them while the interpreter reads the shader as it was: a
driver that computes something else than the text. Where an output leaves the band of the
right shader, the first stored value outside of its band is taken. It prints how often that is the
mistake's own statement, or one that calls it, and how often nothing was found.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from shaderlab.analysis.instrument import find_watch_points
from shaderlab.engine.catalogue import load_cases, shipped_cases
from shaderlab.engine.evaluation import Evaluation
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError
from shaderlab.model.case import Case
from shaderlab.model.options import RunOptions
from shaderlab.mutation import mutate_case
from shaderlab.mutation.locating import Traces, find_first_wrong, trace_draws
from shaderlab.mutation.shader_mutants import ShaderMutant

# Mistakes where nothing is stored.
LEFT_OUT = ("removed", "return", "discarded", "halved", "never written", "else")


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("cases", nargs="*", help="ids of cases; all by default")
    options.add_argument("--each", type=int, default=25, help="mistakes in a case, at most")
    options.add_argument("--seed", type=int, default=0, help="which mistakes are drawn")
    options.add_argument("--list", action="store_true", help="list those that are not named")
    given = options.parse_args(words)
    warnings.simplefilter("ignore")
    catalogue = load_cases(shipped_cases())
    counts: Counter[str] = Counter()
    seconds, cases = 0.0, set()
    with SceneRunner(RunOptions(size=64)) as lab:
        for case in [catalogue[name] for name in given.cases] or catalogue.values():
            for mutant, verdict, took in located(lab, case, given.each, given.seed):
                counts[verdict] += 1
                seconds += took
                cases.add(case.id)
                if given.list and verdict not in ("statement", "call stack"):
                    print(f"{verdict}: {case.id}: {mutant}", flush=True)
    total = sum(counts.values())
    print(f"{total} mistakes in {len(cases)} cases, {seconds / max(total, 1):.2f} s each")
    for verdict, count in counts.most_common():
        print(f"  {count} {verdict}: {count / total:.1%}")
    return 0


def located(lab: SceneRunner, case: Case, most: int, seed: int) -> Iterator[tuple[Any, str, float]]:
    """Some mistakes of a case that change what its first scene draws, and what was named."""
    scene = next(iter(case.scenes()))
    try:
        programs = lab.prepare_for_opengl(scene)
        with lab.evaluation(scene, programs) as right:
            traces = trace_draws(right)
            images = right.drawn.images
    except ShaderlabError:
        return
    mutants = [
        mutant
        for mutant in mutate_case(case)
        if mutant.stage == "fragment" and not any(word in mutant.operator for word in LEFT_OUT)
    ]
    random.Random(seed).shuffle(mutants)
    for mutant in mutants:
        if most <= 0:
            return
        started = time.process_time()
        try:
            changed = lab.prepare_for_opengl(scene, {mutant.shader: mutant.text})
            with lab.evaluation(scene, changed, like=right) as wrong:
                if all(
                    np.array_equal(image.values, images[name].values)
                    for name, image in wrong.drawn.images.items()
                ):
                    continue
                verdict = named(wrong, right, traces, mutant)
        except ShaderlabError:
            continue
        if verdict is not None:
            most -= 1
            yield mutant, verdict, time.process_time() - started


def named(
    wrong: Evaluation,
    right: Evaluation,
    traces: Traces,
    mutant: ShaderMutant,
) -> str | None:
    """What the first value outside says of a mistake; None where no output leaves its band."""
    found = find_first_wrong(wrong, right, traces)
    if found is None:
        return None
    given, trace, first = found
    if first is None:
        return "nothing found"
    text = given.program.source.text if given.program.source is not None else ""
    lines = {given.program.place(first.line)}
    for point in find_watch_points(text):
        if point.kind != "entry" and point.first <= first.line <= point.last:
            lines |= {given.program.place(n) for n in range(point.first, point.last + 1)}
    if any(same(place, mutant) for place in lines):
        return "statement"
    calls = [given.program.place(call) for call in first.calls]
    if any(same(place, mutant) for place in calls):
        return "call stack"
    # The mistake's own call stack: of a function that is called often, only what it stored
    # last is the driver's, and its result shows in the statement that called it.
    own = [e for e in trace.stored if same(given.program.place(e.line), mutant)]
    if {given.program.place(call) for e in own for call in e.calls} & lines:
        return "call stack"
    return "another line"


def same(place: tuple[str, int], mutant: ShaderMutant) -> bool:
    """Whether a place in a file is that of a mistake."""
    return place[1] == mutant.line and (
        place[0].endswith(mutant.file) or mutant.file.endswith(place[0])
    )


if __name__ == "__main__":
    sys.exit(main())
