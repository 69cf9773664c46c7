"""How much code is there to read? `python -m benchmarks.weight [--entered] [--list]`.

Prints what `shaderlab/` holds: lines of Python, C, JavaScript and templates, Python files, names at
the top, functions over 60 lines, functions whose cyclomatic complexity is over 15 (by ruff), and
files that import each other in a circle.

`--entered` counts the Python files of shaderlab whose functions are entered by three tasks: one
case in this process without pictures, the same with pictures, and a function's `.check`. Modules
that are only imported do not count. `--list` names the files, functions and circles.
"""

from __future__ import annotations

import argparse
import ast
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "shaderlab"
KINDS = {
    "Python": (".py", ".pyi"),
    "C": (".c", ".h"),
    "JavaScript": (".js",),
    "templates and styles": (".j2", ".css", ".html"),
}
MAX_LINES, MAX_COMPLEXITY = 60, 15

_CASE = ["run", "attenuation[50]", "-j", "0"]
_COUNTER = """
import json, os, sys, threading
sys.path.insert(0, {root!r})
files = set()
def enter(frame, event, argument):
    if event == "call" and not frame.f_code.co_name.startswith("<"):
        files.add(frame.f_code.co_filename)
sys.setprofile(enter)
threading.setprofile(enter)
try:
    {task}
except SystemExit:
    pass
finally:
    sys.setprofile(None)
    ours = sorted(file for file in files if file.startswith({package!r}) and file.endswith(".py"))
    with open({out!r}, "w") as file:
        json.dump(ours, file)
"""


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--entered", action="store_true", help="run three tasks, count files")
    parser.add_argument("--list", action="store_true", help="name what is counted")
    arguments = parser.parse_args()

    total = 0
    for kind, suffixes in KINDS.items():
        lines = sum(_count_lines(file) for file in _files(*suffixes))
        total += lines
        print(f"{lines:8,} lines of {kind}")
    print(f"{total:8,} lines in all")
    print(f"{len(list(_files('.py'))):8,} Python files")
    names = {file.relative_to(PACKAGE).parts[0] for file in _files()}
    print(f"{len(names):8,} names at the top")
    for title, found in (
        (f"functions over {MAX_LINES} lines", sorted(_long_functions())),
        (f"functions of a complexity over {MAX_COMPLEXITY}", sorted(_complex_functions())),
        ("circles of files that import each other", sorted(_circles())),
    ):
        print(f"{len(found):8,} {title}")
        if arguments.list:
            print(*(f"           {line}" for line in found), sep="\n")
    if arguments.entered:
        for title, task in _tasks().items():
            files = _entered(task)
            print(f"{len(files):8,} files entered by {title}")
            if arguments.list:
                print(*(f"           {Path(f).relative_to(PACKAGE)}" for f in files), sep="\n")


def _files(*suffixes: str) -> Iterator[Path]:
    """All files of the package with one of these suffixes, or with any if there is none."""
    for file in sorted(PACKAGE.rglob("*")):
        wanted = not suffixes or file.suffix in suffixes
        if wanted and file.is_file() and "__pycache__" not in file.parts:
            yield file


def _count_lines(file: Path) -> int:
    return len(file.read_text().splitlines())


def _long_functions() -> Iterator[str]:
    for file in _files(".py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                lines = (node.end_lineno or 0) - node.lineno + 1
                if lines > MAX_LINES:
                    yield f"{file.relative_to(ROOT)}:{node.lineno}: {node.name}, {lines} lines"


def _complex_functions() -> Iterator[str]:
    command = [sys.executable, "-m", "ruff", "check", "--isolated", "--select=C901"]
    limit = f"lint.mccabe.max-complexity={MAX_COMPLEXITY}"
    command += ["--config", limit, "--output-format=json", str(PACKAGE)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    for found in json.loads(done.stdout):
        file = Path(found["filename"]).relative_to(ROOT)
        yield f"{file}:{found['location']['row']}: {found['message']}"


def _circles() -> Iterator[str]:
    """Groups of files that reach each other by imports at the top of a module."""
    graph = {_module(file): file for file in _files(".py")}
    reach = {name: set(_imports(file, name, graph)) for name, file in graph.items()}
    for _ in range(len(graph)):
        grown = {name: set.union(near, *(reach[n] for n in near)) for name, near in reach.items()}
        if grown == reach:
            break
        reach = grown
    left = {name for name in reach if name in reach[name]}
    while left:
        name = min(left)
        circle = {other for other in left if other in reach[name] and name in reach[other]}
        left -= circle
        yield f"{len(circle)}: {', '.join(sorted(circle))}"


def _module(file: Path) -> str:
    parts = file.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imports(file: Path, module: str, graph: dict[str, Path]) -> Iterator[str]:
    package = module if file.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*(above if node.level else []), *filter(None, [node.module])])
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                if inner in graph:
                    yield inner
                elif base in graph and base != module:
                    yield base


def _tasks() -> dict[str, str]:
    run = "from shaderlab.__main__ import main; sys.argv = ['shaderlab', *{}]; main()"
    check = (
        "from shaderlab import glsl;"
        "f = glsl.load({!r}).attenuation;"
        "f.check(lambda d, q: 1 / (1 + d * d * q), d=(0.0, 50.0), q=(0.0, 1.0))"
    )
    shader = Path(tempfile.mkdtemp()) / "light.glsl"
    shader.write_text("float attenuation(float d, float q) { return 1.0 / (1.0 + d * d * q); }\n")
    return {
        "`run 'attenuation[50]' -j 0 --no-pictures`": run.format([*_CASE, "--no-pictures"]),
        "`run 'attenuation[50]' -j 0`": run.format(_CASE),
        "a function's `.check`": check.format(str(shader)),
    }


def _entered(task: str) -> list[str]:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "files.json"
        code = _COUNTER.format(root=str(ROOT), package=f"{PACKAGE}/", out=str(out), task=task)
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
        )
        if not out.exists():
            raise SystemExit(f"the task failed:\n{done.stderr}")
        files: list[str] = json.loads(out.read_text())
        return files


if __name__ == "__main__":
    main()
