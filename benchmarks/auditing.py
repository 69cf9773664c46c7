"""How many planted hazards `audit` finds at their lines, and what it says of the catalogue.

    python -m benchmarks.auditing [--only planted|twins|catalogue] [--all]

The hazards are those of `hazards.toml`; found is one that is shown by an input, at its line.
`twins.toml` has whole shaders, and how each is guarded: audit has to fail the first and not the
other. The catalogue's shaders are audited on what the cases' draws give them (`--all`: and on what
is made up). Seconds are of the processor, without the drawing.
"""

from __future__ import annotations

import argparse
import re
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.shipped import load_cases
from shaderlab.analysis.audit import Audit, audit_program
from shaderlab.analysis.interpreter import load
from shaderlab.analysis.invocations import case_stages, program_of
from shaderlab.compiler import Shaders
from shaderlab.engine.catalogue import data_folder
from shaderlab.engine.run import SceneRunner
from shaderlab.errors import ShaderlabError
from shaderlab.model.options import RunOptions

PLANTED = Path(__file__).with_name("hazards.toml")
TWINS = Path(__file__).with_name("twins.toml")
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


_OF_STAGE = {
    "compute": """#version 430 core
layout (local_size_x = 32) in;
layout (std430) buffer Results { float result; };
uniform float x; // range: -1..1
uniform int n; // range: 0..6
float held;
void main()
{
""",
}
_ENDS = {
    "fragment": _END,
    "vertex": "\n}\nvoid main()\n{\n    gl_Position = color();\n}\n",
    "compute": "\n}\nvoid main()\n{\n    result = color();\n}\n",
}
_LAYOUTS = {
    "compute": "layout (local_size_x = 8) in; buffer Results { vec4 result; }; uniform vec2 uv; ",
}
STAGES = tuple(_ENDS)
SUFFIXES = ("frag", "vert", "comp")
_SLOPES = re.compile(r"\b(dFd[xy]|fwidth)\(")  # fragment shaders alone have them


@dataclass(frozen=True)
class Planted:
    """A hazard in a shader: its kind, what `color()` or a stage's own `main` does, the stage."""

    kind: str
    body: str
    stage: str
    own: bool = False

    @property
    def text(self) -> str:
        """The shader."""
        if self.own:
            return f"{_OF_STAGE[self.stage]}{self.body}\n}}\n"
        start = DECLARATIONS
        if self.stage in _LAYOUTS:
            start = start.replace("in vec2 uv;", _LAYOUTS[self.stage])
        if self.stage != "fragment":
            start = start.replace("out vec4 FragColor;", "")
        return f"{start}{self.body}{_ENDS[self.stage]}"

    @property
    def line(self) -> int:
        """Where it goes wrong: at the marked line, or in the function that the body calls."""
        start = _OF_STAGE[self.stage] if self.own else DECLARATIONS
        marked = [i for i, line in enumerate(self.body.splitlines()) if line.endswith("// !")]
        if marked:
            return start.count("\n") + 1 + marked[0]
        return _RATIO


def planted(stage: str = "fragment") -> Iterator[Planted]:
    """Each hazard that a stage can have."""
    data = tomllib.loads(PLANTED.read_text(encoding="utf-8"))
    for kind, bodies in data.items():
        if isinstance(bodies, list):
            here = bodies if stage == "fragment" else [b for b in bodies if not _SLOPES.search(b)]
            yield from (Planted(kind, body, stage) for body in here)
    for kind, bodies in data.get(stage, {}).items():
        yield from (Planted(kind, body, stage, own=True) for body in bodies)


def audit_of(one: Planted) -> Audit:
    """The audit of a shader with a planted hazard."""
    shaders = Shaders([Path()], overrides={"planted.glsl": one.text})
    return audit_program(load(shaders.load("planted.glsl", one.stage)))


def is_found(one: Planted, audit: Audit) -> bool:
    """Whether a hazard is shown at its line."""
    return any(hazard.evident and hazard.line == one.line for hazard in audit.hazards)


def _planted(stage: str) -> None:
    found, total, elsewhere = Counter[str](), Counter[str](), 0
    started = time.process_time()
    for one in planted(stage):
        total[one.kind] += 1
        audit = audit_of(one)
        found[one.kind] += is_found(one, audit)
        others = [h for h in audit.hazards if h.evident and h.line != one.line]
        elsewhere += bool(others)
        if not is_found(one, audit) or others:
            print(f"  {one.kind}: {one.body!r}: {[(h.line, h.kind) for h in audit.hazards]}")
    seconds = (time.process_time() - started) / total.total()
    for kind, count in total.items():
        print(f"{stage}, {kind}: {found[kind]} of {count}")
    print(
        f"{stage}: {found.total()} of {total.total()} at their lines, {seconds:.2f} s each; "
        f"hazards at other lines in {elsewhere}"
    )


@dataclass(frozen=True)
class Twins:
    """A shader with a hazard, by kind, and the same one guarded; the line that shows it."""

    kind: str
    text: str
    guarded: str
    line: int


def twins() -> Iterator[Twins]:
    """Each shader of `twins.toml`."""
    start = "#version 430 core\nout vec4 FragColor;\n"
    for kind, entries in tomllib.loads(TWINS.read_text(encoding="utf-8")).items():
        for entry in entries:
            text, (old, new) = entry["text"], entry["guard"]
            assert text.count(old) == 1, f"{kind}: {old!r} in {text}"
            before = start + text[: text.index("// !")]
            yield Twins(kind, start + text, start + text.replace(old, new), before.count("\n") + 1)


def audit_text(text: str) -> Audit:
    """The audit of a fragment shader's text, without a case."""
    shaders = Shaders([Path()], overrides={"twin.frag": text})
    return audit_program(load(shaders.load("twin.frag", "fragment")))


def _twins() -> None:
    failed, at_line, alarms, total = 0, 0, 0, 0
    for one in twins():
        total += 1
        wrong, right = audit_text(one.text), audit_text(one.guarded)
        shown = any(h.evident and h.line == one.line for h in wrong.hazards)
        failed, at_line = failed + (wrong.clean is False), at_line + shown
        alarms += right.clean is False
        if not shown or not right.clean:
            own = one.text.splitlines()[one.line - 1].strip()
            print(f"  {one.kind}: {own}: {[(h.line, h.message, h.evident) for h in wrong.hazards]}")
            print(f"    guarded: {[(h.line, h.message, h.evident) for h in right.hazards]}")
    print(f"twins: {failed} of {total} fail, {at_line} at their lines; {alarms} guarded ones do")


def _catalogue(made_up: bool) -> None:
    programs, alarms, seconds = 0, 0, 0.0
    with SceneRunner(RunOptions()) as lab:
        for case in load_cases().values():
            try:
                for source, given in case_stages(lab, case):
                    if not given:
                        continue  # a stage whose inputs can't be captured
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
    for path in sorted(p for suffix in SUFFIXES for p in root.rglob(f"*.{suffix}")):
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
    parser.add_argument("--only", choices=("planted", "twins", "catalogue"))
    parser.add_argument("--all", action="store_true", help="made-up inputs for the catalogue, too")
    options = parser.parse_args()
    for stage in STAGES if options.only in (None, "planted") else ():
        _planted(stage)
    if options.only in (None, "twins"):
        _twins()
    if options.only in (None, "catalogue"):
        _catalogue(options.all)


if __name__ == "__main__":
    main()
