"""Wrong shaders that no case may miss: fragments kept out, and outputs of half their size.

`python -m benchmarks.wrong_shaders` takes every fragment shader of the shipped cases of which an
expectation reads an output, directly or as a texture, and makes each of these mistakes behind its
`main`:

- every second pixel is discarded, as on a chess board;
- pixels where a judged output is above a quarter are discarded;
- one judged output, or the depth that it writes, is halved.

Each mistake is judged as `shaderlab mutate` judges a mutant: by all expectations of all variants.
It prints what goes unnoticed, and the sums. What changes nothing that the case draws, such
as half of 0, is counted by itself. The exit status is 1 where anything goes unnoticed.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Iterator

from shaderlab.catalogue import Catalogue
from shaderlab.evaluation import Lab
from shaderlab.model import Case
from shaderlab.mutation.compare import judged_outputs
from shaderlab.mutation.judging import Judge
from shaderlab.mutation.mutants import ShaderMutant
from shaderlab.mutation.subjects import ShaderFile, shader_files

CHESS = "every second pixel discarded"
BRIGHT = "discarded above a quarter"
HALF = "an output halved"


def main(words: list[str] | None = None) -> int:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("cases", nargs="*", help="ids of cases; all by default")
    given = options.parse_args(words)
    tried: Counter[str] = Counter()
    unnoticed: Counter[str] = Counter()
    without: Counter[str] = Counter()
    catalogue = Catalogue.shipped()
    chosen = [catalogue.find(name) for name in given.cases] or catalogue
    with Lab() as lab:
        for case in chosen:
            mistakes = list(wrong_shaders(lab, case))
            judge = Judge(lab, case) if mistakes else None
            for mutant in mistakes:
                assert judge is not None
                fate = judge.fate(mutant)
                tried[mutant.operator] += 1
                if fate.status == "equivalent" or fate.by.startswith("only on wider inputs"):
                    without[mutant.operator] += 1
                elif fate.status != "killed":
                    unnoticed[mutant.operator] += 1
                    what = f"{mutant.operator} ({mutant.after})"
                    print(
                        f"{case.id}: {mutant.shader}: {what}: {fate.status}, {fate.by}", flush=True
                    )
    for operator in (CHESS, BRIGHT, HALF):
        print(
            f"{operator}: {unnoticed[operator]} of {tried[operator]} unnoticed, "
            f"{without[operator]} without any effect"
        )
    return 1 if unnoticed else 0


def wrong_shaders(lab: Lab, case: Case) -> Iterator[ShaderMutant]:
    """The mistakes in each judged fragment shader of a case, each text once."""
    scenes = list(case.scenes())
    judged = judged_outputs(scenes)
    files = {file.name: file for file in shader_files(case)}
    done: set[str] = set()
    for scene in scenes:
        for name, draws in lab.prepare_for_opengl(scene).items():
            for draw in draws:
                shader = draw.draw.fragment
                kinds = {v.name: v.type for v in draw.interface.outputs.values()}
                if "gl_FragDepth" in (draw.text("fragment") or "") and (name, "depth") in judged:
                    kinds["gl_FragDepth"] = "float"
                read = [n for n in kinds if (name, n) in judged or n == "gl_FragDepth"]
                for mutant in _mistakes(files[shader], {n: kinds[n] for n in read}):
                    if mutant.text not in done:
                        done.add(mutant.text)
                        yield mutant


def _mistakes(file: ShaderFile, outputs: dict[str, str]) -> Iterator[ShaderMutant]:
    if not outputs:
        return
    chess = "if (((int(gl_FragCoord.x) + int(gl_FragCoord.y)) & 1) == 1) discard;"
    yield _mistake(file, CHESS, chess)
    for name, kind in outputs.items():
        unsigned = kind == "uint" or kind.startswith("uvec")
        integer = unsigned or kind == "int" or kind.startswith("ivec")
        first = name if kind in ("float", "int", "uint") else f"{name}.x"
        if kind.endswith("]") or not (integer or kind == "float" or kind.startswith("vec")):
            continue
        yield _mistake(file, BRIGHT, f"if (float({first}) > 0.25) discard;")
        yield _mistake(file, HALF, f"{name} /= {'2u' if unsigned else '2' if integer else '2.0'};")


def _mistake(file: ShaderFile, operator: str, ending: str) -> ShaderMutant:
    """The shader with another `main` that calls its own and goes on with `ending`."""
    text = re.sub(r"\bvoid\s+main\s*\(", "void with_mistake(", file.text)
    text += f"\nvoid main() {{\n    with_mistake();\n    {ending}\n}}\n"
    return ShaderMutant(
        shader=file.name,
        file=file.path,
        line=0,
        operator=operator,
        before="",
        after=ending,
        text=text,
    )


if __name__ == "__main__":
    sys.exit(main())
