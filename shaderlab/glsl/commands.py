"""The engine that drives commands: glslangValidator and spirv-val, of a wheel, a system, an SDK.

Slower than the libraries by the start of a process for each program and target; plain checks are
made for many files at once, since the command takes many. SPIR-V can't be: given many files,
the command links them all.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from shaderlab.glsl.frontend import Checked, Linked
from shaderlab.glsl.programs import CompilerDiedError, Programs, Ran, run
from shaderlab.glsl.sources import Source

_SUFFIX = {
    "vertex": "vert",
    "tess_control": "tesc",
    "tess_evaluation": "tese",
    "geometry": "geom",
    "fragment": "frag",
    "compute": "comp",
}
# What the command is told of each target, before the files.
FLAGS: Mapping[str, Sequence[str]] = {
    "glsl": ("-d", "-l"),
    "opengl": ("-d", "-G", "--aml", "--amb"),
    "vulkan": ("-d", "-V", "-R", "--aml", "--amb"),
    "vulkan-strict": ("-d", "-V", "--aml", "--amb"),
}
_NOT_PARSED = re.compile(r"^ERROR: \d+ compilation errors", re.M)
_LINKING = re.compile(r"^(?:ERROR|WARNING): Linking .*\n(?:[ \t]+.*\n)*", re.M)
_STEM = "shaderlab-"
# The command names files where the library says 0.
_FILE = re.compile(rf"^((?:INTERNAL )?ERROR|WARNING|NOTE): {_STEM}\d+\.\w+:(\d+):", re.M)
_ENTRY = re.compile(r"^(?:INTERNAL ERROR|ERROR|WARNING|NOTE): ", re.M)
_PLACED = re.compile(r"(?:INTERNAL ERROR|ERROR|WARNING|NOTE): (?:-?\d+:\d+: |\d+ compilation err)")
_NO_MODULE = "SPIR-V is not generated for failed compile or link"
_POSITION = re.compile(r"\Aerror: (?:line \d+: |\d+: )?")


class Commands:
    """An engine that starts a command for each question it has no answer to.

    Args:
        programs: the commands.
        seconds: how long one of them may take.
    """

    name = "process"

    def __init__(self, programs: Programs, seconds: float | None = None) -> None:
        self.programs = programs
        self._seconds = seconds
        self._checked: dict[tuple[str, str], Checked] = {}

    def limited(self, seconds: float) -> Commands:
        """The same commands with a time limit."""
        return Commands(self.programs, seconds)

    def prepare(self, sources: Sequence[Source]) -> None:
        """Checks all of them with one command, and remembers until the next call."""
        try:
            checks = self._check(sources)
        except CompilerDiedError:
            checks = []  # one of them took it down: `check` asks for each by itself
        self._checked = {
            (source.stage, source.text): checked
            for source, checked in zip(sources, checks, strict=False)
        }

    def check(self, source: Source) -> Checked:
        known = self._checked.get((source.stage, source.text))
        return known if known is not None else self._check([source])[0]

    def preprocess(self, source: Source) -> str | None:
        with tempfile.TemporaryDirectory(prefix=_STEM) as folder:
            names = _write([source], folder)
            ran = self._run(["-d", "-E", *names], folder)
        return None if ran.code else ran.output

    def link(self, sources: Sequence[Source], target: str) -> Linked:
        with tempfile.TemporaryDirectory(prefix=_STEM) as folder:
            names = _write(sources, folder)
            ran = self._run([*FLAGS[target], *names], folder)
            modules = {
                source.stage: file.read_bytes()
                for source in sources
                if (file := Path(folder) / f"{_SUFFIX[source.stage]}.spv").is_file()
            }
        output = _FILE.sub(r"\1: 0:\2:", ran.output.replace(_NO_MODULE, ""))
        sections = _sections(output, names)
        log = ""
        if not _NOT_PARSED.search(output):
            # A message without a line is the link's, which is printed after all else.
            sections[-1], log = _split(sections[-1])
        else:
            sections[-1] = _LINKING.sub("", sections[-1])  # the command links what it could parse
        logs = {s.stage: section for s, section in zip(sources, sections, strict=True)}
        return Linked(ran.code == 0, logs, log, modules if ran.code == 0 else {})

    def validate(self, module: bytes, environment: str) -> str | None:
        ran = run(
            self.programs.validator,
            ["--target-env", environment, "-"],
            given=module,
            seconds=self._seconds,
        )
        return None if ran.code == 0 else _POSITION.sub("", ran.output.strip())

    def versions(self) -> Mapping[str, str]:
        said = self._run(["--version"], None).output
        version = re.search(r"Glslang Version: (?:\d+:)?(\S+)", said)
        tools = run(self.programs.validator, ["--version"]).output.split("\n")[0]
        return {
            "glslang": version[1] if version else said.split("\n")[0],
            "glslang command": str(self.programs.glslang),
            "SPIRV-Tools": tools.removeprefix("SPIRV-Tools "),
            "SPIRV-Tools command": str(self.programs.validator),
        }

    def _check(self, sources: Sequence[Source]) -> list[Checked]:
        with tempfile.TemporaryDirectory(prefix=_STEM) as folder:
            names = _write(sources, folder)
            ran = self._run(["-d", *names], folder)
        return [
            Checked(not re.search(r"^(INTERNAL )?ERROR: ", log, re.M), log)
            for log in _sections(ran.output, names)
        ]

    def _run(self, arguments: Sequence[str], folder: str | None) -> Ran:
        return run(self.programs.glslang, arguments, folder=folder, seconds=self._seconds)


def _write(sources: Sequence[Source], folder: str) -> list[str]:
    names = []
    for number, source in enumerate(sources):
        name = f"{_STEM}{number}.{_SUFFIX[source.stage]}"
        (Path(folder) / name).write_text(source.text, encoding="utf-8", newline="")
        names.append(name)
    return names


def _sections(output: str, names: Sequence[str]) -> list[str]:
    """What the command printed of each file: it prints a file's name first, on its own line."""
    sections = []
    rest = output
    for name, after in zip(names, [*names[1:], None], strict=True):
        rest = rest.partition(f"{name}\n")[2]
        section, mark, _ = rest.partition(f"\n{after}\n") if after else (rest, "", "")
        if after and not mark:
            section = "" if rest.startswith(f"{after}\n") else rest
        sections.append(f"{section.strip()}\n" if section.strip() else "")
    return sections


def _split(section: str) -> tuple[str, str]:
    """A section's messages with a line in the text, and those without."""
    starts = [match.start() for match in _ENTRY.finditer(section)]
    ends = [*starts[1:], len(section)]
    entries = [section[start:end] for start, end in zip(starts, ends, strict=False)]
    placed = [entry for entry in entries if _PLACED.match(entry)]
    return "".join(placed), "".join(entry for entry in entries if entry not in placed)
