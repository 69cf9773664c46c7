"""How many planted hazards `audit` finds at their lines, and what it says of the catalogue.

    python -m benchmarks.auditing [--only planted|catalogue] [--all]

The hazards are those of `hazards.toml`; found is one that is shown by an input, at its line. The
catalogue's shaders are audited on what the cases' draws give them (`--all`: and on inputs that are
made up). Seconds are of the processor, without the drawing.
"""

from __future__ import annotations

import argparse
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from shaderlab.audit import Audit, audit_program
from shaderlab.catalogue import load_cases
from shaderlab.compiler import Shaders
from shaderlab.discovery import data_folder, shipped_cases
from shaderlab.errors import ShaderlabError
from shaderlab.evaluation import Lab
from shaderlab.evaluation.interpreting import program_of
from shaderlab.evaluation.rewriting import stages
from shaderlab.interpreter import load
from shaderlab.options import RunOptions

PLANTED = Path(__file__).with_name("hazards.toml")
DECLARATIONS = """#version 430 core
struct Light { vec3 color; float power; };
in vec2 uv; // range: 0..1
uniform float x; // range: -1..1
uniform float y; // range: 0..1
uniform float a; // range: -1..1
uniform float b; // range: -1..1
uniform vec3 v; // range: -2..2
uniform vec3 w; // range: -2..2
uniform vec3 unitA; // range: unit
uniform vec3 unitB; // range: unit
uniform vec3 color0; // range: 0..1
uniform vec3 color1; // range: 0..1
uniform float weights[4]; // range: 0..1
uniform int n; // range: 0..6
uniform int m; // range: 0..6
uniform int bits; // range: 0..40
uniform sampler2D image;
out vec4 FragColor;
float ratio(float over, float under)
{
    return over / under;
}
void maybe(float over, out float result)
{
    if (over > 0.0) {
        result = over;
    }
}
vec4 color()
{
"""
_END = "\n}\nvoid main()\n{\n    FragColor = color();\n}\n"
_RATIO = DECLARATIONS[: DECLARATIONS.index("over / under")].count("\n") + 1


def planted() -> Iterator[tuple[str, str]]:
    """The kind and the body of each hazard."""
    for kind, bodies in tomllib.loads(PLANTED.read_text(encoding="utf-8")).items():
        for body in bodies:
            yield kind, body


def audit_of(body: str) -> Audit:
    """The audit of a shader with a planted hazard."""
    text = f"{DECLARATIONS}{body}{_END}"
    shaders = Shaders([Path()], overrides={"planted.frag": text})
    return audit_program(load(shaders.load("planted.frag", "fragment")))


def line_of(body: str) -> int:
    """The line at which a body goes wrong; in the function that it calls if it marks none."""
    marked = [i for i, line in enumerate(body.splitlines()) if line.endswith("// !")]
    return DECLARATIONS.count("\n") + 1 + marked[0] if marked else _RATIO


def is_found(body: str, audit: Audit) -> bool:
    """Whether a hazard is shown at its line."""
    return any(hazard.evident and hazard.line == line_of(body) for hazard in audit.hazards)


def _planted() -> None:
    found, total, elsewhere = Counter[str](), Counter[str](), 0
    started = time.process_time()
    for kind, body in planted():
        total[kind] += 1
        audit = audit_of(body)
        found[kind] += is_found(body, audit)
        others = [h for h in audit.hazards if h.evident and h.line != line_of(body)]
        elsewhere += bool(others)
        if not is_found(body, audit) or others:
            print(f"  {kind}: {body!r}: {[(h.line, h.kind) for h in audit.hazards]}")
    seconds = (time.process_time() - started) / total.total()
    for kind, count in total.items():
        print(f"{kind}: {found[kind]} of {count}")
    print(f"planted: {found.total()} of {total.total()} at their lines, {seconds:.2f} s each")
    print(f"hazards at other lines: in {elsewhere}")


def _catalogue(made_up: bool) -> None:
    programs, alarms, seconds = 0, 0, 0.0
    with Lab(RunOptions()) as lab:
        for case in load_cases(shipped_cases()).values():
            try:
                for source, given in stages(lab, case):
                    started = time.process_time()
                    audit = audit_program(program_of(source), captured=given)
                    seconds += time.process_time() - started
                    programs += 1
                    alarms += not audit.clean
                    for hazard in audit.hazards:
                        print(f"  {case.id}: {hazard}")
            except ShaderlabError as error:
                print(f"  {case.id}: can't say: {error}")
    print(f"catalogue: alarms in {alarms} of {programs} programs, {seconds:.1f} s")
    if made_up:
        _files()


def _files() -> None:
    root, files, alarms = data_folder("shaders"), 0, 0
    for path in sorted([*root.rglob("*.frag"), *root.rglob("*.vert")]):
        try:
            source = Shaders([root]).load(path.relative_to(root).as_posix())
            audit = audit_program(program_of(source))
        except ShaderlabError as error:
            print(f"  {path.name}: can't say: {error}")
            continue
        files += 1
        alarms += not audit.clean
        for hazard in audit.hazards:
            print(f"  {hazard}")
    print(f"files without a case: alarms in {alarms} of {files}")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("planted", "catalogue"))
    parser.add_argument("--all", action="store_true", help="made-up inputs for the catalogue, too")
    options = parser.parse_args()
    if options.only != "catalogue":
        _planted()
    if options.only != "planted":
        _catalogue(options.all)


if __name__ == "__main__":
    main()
