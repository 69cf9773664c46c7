"""The lab's verdicts beside the commands': `python -m benchmarks.verdicts [--write] [FOLDER…]`.

Each shader is compiled by itself for each target, by glslangValidator and spirv-val with the flags
of docs/guide/compiling.md, and by the lab: for all targets at once, and for each alone. Without a
folder, shaders/ and tests/dialects/ are compared. `--write` writes what the commands accept into
tests/dialects/accepted.toml, which a test holds the lab against. The exit status is 1 if a verdict
differs that EXPLAINED does not have.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from shaderlab.compiler import Shaders
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.glslang import ALL_TARGETS, SETTINGS
from shaderlab.compiler.sources import Source
from shaderlab.errors import ShaderError

sys.path.insert(0, str(Path(__file__).resolve().parent))
from commands import FLAGS, environment, glslang_command, validator_command
from trees import SUFFIX

REPOSITORY = Path(__file__).resolve().parent.parent
DIALECTS = REPOSITORY / "tests" / "dialects"
# Where the lab differs on purpose, and the words of docs/guide/compiling.md that say so.
EXPLAINED = {
    "does not support the compatibility profile": "prints this error, and goes on",
    "compiled with": "Samplers in uniform structs are lifted out",
    "compiled as GLSL ES 3.10": "ES 1.00 and 3.00 are compiled as ES 3.10",
    "a text that would crash the compiler": "A text that would crash the compiler is refused",
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    count = differ = depend = 0
    accepted: dict[str, list[str]] = {}
    for folder in given.folders or [REPOSITORY / "shaders", DIALECTS]:
        for source in sources(folder):
            for verdict in compile_program([source], ALL_TARGETS).verdicts:
                count += 1
                target = verdict.target
                taken = by_command(source, target)
                if folder.resolve() == DIALECTS:
                    accepted.setdefault(source.name, []).extend([target] * taken)
                alone = compile_program([source], (target,)).verdicts[0]
                depend += alone != verdict
                said = " / ".join(d.message for d in verdict.diagnostics)
                if taken != verdict.ok and not any(words in said for words in EXPLAINED):
                    differ += 1
                    print(f"{source.path} [{target}]: the command says {taken}; the lab: {said}")
    print(f"{count} verdicts: {differ} differ from the commands', {depend} depend on other targets")
    if given.write and accepted:
        lines = (f'"{name}" = {targets}\n' for name, targets in sorted(accepted.items()))
        (DIALECTS / "accepted.toml").write_text("".join(lines).replace("'", '"'))
    return 1 if differ or depend else 0


def sources(folder: Path) -> Iterator[Source]:
    """Every shader below a folder that can be read and is no include, sorted by name."""
    shaders = Shaders([folder])
    for name in sorted(shaders.names()):
        try:
            yield shaders.load(name)
        except ShaderError:
            continue


def by_command(source: Source, target: str) -> bool:
    """Whether glslangValidator accepts a shader for a target, and spirv-val its module."""
    settings, suffix = SETTINGS[target], SUFFIX[source.stage]
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, f"one.{suffix}").write_text(source.text, encoding="utf-8")
        steps = [[str(glslang_command()), *FLAGS[target], f"one.{suffix}"]]
        if settings.environment:
            flags = ["--target-env", settings.environment, f"{suffix}.spv"]
            steps.append([str(validator_command()), *flags])
        return all(
            subprocess.run(step, cwd=folder, env=environment(), capture_output=True).returncode == 0
            for step in steps
        )


if __name__ == "__main__":
    sys.exit(main())
