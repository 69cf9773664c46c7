"""The engine that runs commands: glslangValidator and spirv-val, of a wheel, a system or an SDK.

It is slower than the libraries by the start of a process for each program and target. One command
checks many files as plain GLSL, but makes SPIR-V for one program only, since it links all the files
that it gets.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from shaderlab.glsl.engines import Checked, Linked
from shaderlab.glsl.executables import CompilerDiedError, Executables, run
from shaderlab.glsl.sources import Source
from shaderlab.glsl.targets import SETTINGS
from shaderlab.glsl.text import EXTENSIONS

# The first extension of each stage is the one that the command knows.
_SUFFIX = {stage: extension for extension, stage in reversed(list(EXTENSIONS.items()))}
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
    """An `Engine`; see there.

    Args:
        executables: the commands.
        seconds: time limit for each command.
    """

    name = "process"

    def __init__(self, executables: Executables, seconds: float | None = None) -> None:
        self.executables = executables
        self._seconds = seconds
        self._checked: dict[tuple[str, str], Checked] = {}

    def prepare(self, sources: Sequence[Source]) -> None:
        """Checks all of them with one command and keeps the results until the next call."""
        try:
            checks = self._check(sources)
        except CompilerDiedError:
            checks = []  # one of them crashed it, so `check` runs a command for each
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
            code, output = self._run(["-d", "-E", *names], folder)
        return None if code else output

    def link(self, sources: Sequence[Source], target: str) -> Linked:
        with tempfile.TemporaryDirectory(prefix=_STEM) as folder:
            names = _write(sources, folder)
            code, printed = self._run([*SETTINGS[target].flags, *names], folder)
            modules = {
                source.stage: file.read_bytes()
                for source in sources
                if (file := Path(folder) / f"{_SUFFIX[source.stage][1:]}.spv").is_file()
            }
        output = _FILE.sub(r"\1: 0:\2:", printed.replace(_NO_MODULE, ""))
        sections = _sections(output, names)
        log = ""
        if not _NOT_PARSED.search(output):
            # A message without a line is the link's, which is printed after all else.
            sections[-1], log = _split(sections[-1])
        else:
            sections[-1] = _LINKING.sub("", sections[-1])  # the command links what it could parse
        logs = {s.stage: section for s, section in zip(sources, sections, strict=True)}
        return Linked(code == 0, logs, log, {} if code else modules)

    def validate(self, module: bytes, environment: str) -> str | None:
        arguments = ["--target-env", environment, "-"]
        validator = self.executables.validator
        code, output = run(validator, arguments, given=module, seconds=self._seconds)
        return _POSITION.sub("", output.strip()) if code else None

    def versions(self) -> Mapping[str, str]:
        said = self._run(["--version"], None)[1]
        version = re.search(r"Glslang Version: (?:\d+:)?(\S+)", said)
        tools = run(self.executables.validator, ["--version"])[1].split("\n")[0]
        return {
            "glslang": version[1] if version else said.split("\n")[0],
            "glslang command": str(self.executables.glslang),
            "SPIRV-Tools": tools.removeprefix("SPIRV-Tools "),
            "SPIRV-Tools command": str(self.executables.validator),
        }

    def _check(self, sources: Sequence[Source]) -> list[Checked]:
        with tempfile.TemporaryDirectory(prefix=_STEM) as folder:
            names = _write(sources, folder)
            _, output = self._run(["-d", *names], folder)
        return [
            Checked(not re.search(r"^(INTERNAL )?ERROR: ", log, re.M), log)
            for log in _sections(output, names)
        ]

    def _run(self, arguments: Sequence[str], folder: str | None) -> tuple[int, str]:
        return run(self.executables.glslang, arguments, folder=folder, seconds=self._seconds)


def _write(sources: Sequence[Source], folder: str) -> list[str]:
    names = []
    for number, source in enumerate(sources):
        name = f"{_STEM}{number}{_SUFFIX[source.stage]}"
        (Path(folder) / name).write_text(source.text, encoding="utf-8", newline="")
        names.append(name)
    return names


def _sections(output: str, names: Sequence[str]) -> list[str]:
    """The command's output for each file, which starts with the file's name on its own line."""
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
