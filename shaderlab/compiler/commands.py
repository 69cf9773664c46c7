"""The engine that runs commands: glslangValidator and spirv-val, of a wheel, a system or an SDK.

It is slower than the libraries by the start of a process for each stage's check, and for each
program and target.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from shaderlab.errors import ShaderError

from .engines import (
    GLSLANG_WHEEL,
    INSTALL,
    SETTINGS,
    SPIRV_TOOLS_WHEEL,
    Checked,
    CompilerDiedError,
    Linked,
    find,
)
from .shader_files import EXTENSIONS
from .sources import Source

# The first extension of each stage is the one that the command knows.
_SUFFIX = {stage: extension for extension, stage in reversed(list(EXTENSIONS.items()))}
_GLSLANG_NAMES = ("glslangValidator", "glslang")
_VALIDATOR_NAME = "spirv-val"
_NOT_PARSED = re.compile(r"^ERROR: \d+ compilation errors", re.M)
_LINKING = re.compile(r"^(?:ERROR|WARNING): Linking .*\n(?:[ \t]+.*\n)*", re.M)
_STEM = "shaderlab-"
# The command names files where the library says 0.
_FILE = re.compile(rf"^((?:INTERNAL )?ERROR|WARNING|NOTE): {_STEM}\d+\.\w+:(\d+):", re.M)
_ENTRY = re.compile(r"^(?:INTERNAL ERROR|ERROR|WARNING|NOTE): ", re.M)
_PLACED = re.compile(r"(?:INTERNAL ERROR|ERROR|WARNING|NOTE): (?:-?\d+:\d+: |\d+ compilation err)")
_NO_MODULE = "SPIR-V is not generated for failed compile or link"
_POSITION = re.compile(r"\Aerror: (?:line \d+: |\d+: )?")


@dataclass(frozen=True)
class Executables:
    """The two commands' files."""

    glslang: Path
    validator: Path


def locate(command: str | None) -> Executables:
    """Find the commands.

    Args:
        command: a glslangValidator by its path or name. By default the wheels, the PATH and the
            Vulkan SDK are searched.

    Raises:
        ShaderError: a command is missing; the remedy says what to install.
    """
    if command is None:
        glslang = next(_candidates(_GLSLANG_NAMES, GLSLANG_WHEEL), None)
        if glslang is None:
            raise ShaderError("there is no glslangValidator command", remedy=INSTALL)
    else:
        named = shutil.which(command)
        if named is None:
            raise ShaderError(
                f"SHADERLAB_GLSLANG names no program: {command}",
                remedy="set it to the path of glslangValidator, or unset it",
            )
        glslang = Path(named)
    neighbour = shutil.which(_VALIDATOR_NAME, path=str(glslang.parent))
    validator = Path(neighbour) if neighbour else None
    validator = validator or next(_candidates((_VALIDATOR_NAME,), SPIRV_TOOLS_WHEEL), None)
    if validator is None:
        raise ShaderError(f"there is no {_VALIDATOR_NAME} command", remedy=INSTALL)
    return Executables(glslang, validator)


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

    def check(self, source: Source) -> Checked:
        _, output, _ = self._glslang(["-d"], [source])
        (log,) = _sections(output, _names([source]))
        return Checked(not re.search(r"^(INTERNAL )?ERROR: ", log, re.M), log)

    def preprocess(self, source: Source) -> str | None:
        code, output, _ = self._glslang(["-d", "-E"], [source])
        return None if code else output

    def link(self, sources: Sequence[Source], target: str, *, lines: bool = False) -> Linked:
        flags = [*SETTINGS[target].flags, *(["-g"] if lines else [])]
        code, printed, modules = self._glslang(flags, sources)
        output = _FILE.sub(r"\1: 0:\2:", printed.replace(_NO_MODULE, ""))
        sections = _sections(output, _names(sources))
        log = ""
        if not _NOT_PARSED.search(output):
            # A message without a line is the link's, which is printed after all else.
            sections[-1], log = _split(sections[-1])
        else:
            sections[-1] = _LINKING.sub("", sections[-1])  # the command links what it could parse
        logs = {s.stage: section for s, section in zip(sources, sections, strict=True)}
        return Linked(code == 0, logs, log, {} if code else modules)

    def validate(self, module: bytes, environment: str) -> str | None:
        flags = ["--target-env", environment, "-"]
        code, output = _run(self.executables.validator, flags, stdin=module, seconds=self._seconds)
        return _POSITION.sub("", output.strip()) if code else None

    def versions(self) -> Mapping[str, str]:
        output = _run(self.executables.glslang, ["--version"])[1]
        version = re.search(r"Glslang Version: (?:\d+:)?(\S+)", output)
        tools = _run(self.executables.validator, ["--version"])[1].split("\n")[0]
        return {
            "glslang": version[1] if version else output.split("\n")[0],
            "glslang command": str(self.executables.glslang),
            "SPIRV-Tools": tools.removeprefix("SPIRV-Tools "),
            "SPIRV-Tools command": str(self.executables.validator),
        }

    def _glslang(
        self, flags: Sequence[str], sources: Sequence[Source]
    ) -> tuple[int, str, Mapping[str, bytes]]:
        """Run glslangValidator on the sources: its exit status, output, and modules by stage."""
        names = _names(sources)
        with tempfile.TemporaryDirectory(prefix=_STEM) as name:
            folder = Path(name)
            for file, source in zip(names, sources, strict=True):
                (folder / file).write_text(source.text, encoding="utf-8", newline="")
            command = self.executables.glslang
            code, output = _run(command, [*flags, *names], folder=folder, seconds=self._seconds)
            modules = {
                source.stage: module.read_bytes()
                for source in sources
                if (module := folder / f"{_SUFFIX[source.stage][1:]}.spv").is_file()
            }
        return code, output, modules


def _names(sources: Sequence[Source]) -> list[str]:
    return [f"{_STEM}{number}{_SUFFIX[s.stage]}" for number, s in enumerate(sources)]


def _sections(output: str, names: Sequence[str]) -> list[str]:
    """Return the command's output for each file, which follows a line of the file's name."""
    parts = re.split(rf"^({_STEM}\d+\.\w+)\n", output, flags=re.M)[1:]
    by_name = dict(zip(parts[::2], parts[1::2], strict=True))
    texts = [by_name.get(name, "").strip() for name in names]
    return [f"{text}\n" if text else "" for text in texts]


def _split(section: str) -> tuple[str, str]:
    """Return a section's messages with a line in the text, and those without."""
    starts = [match.start() for match in _ENTRY.finditer(section)]
    ends = [*starts[1:], len(section)]
    entries = [section[start:end] for start, end in zip(starts, ends, strict=False)]
    placed = [entry for entry in entries if _PLACED.match(entry)]
    return "".join(placed), "".join(entry for entry in entries if entry not in placed)


def _run(
    program: Path,
    arguments: Sequence[str],
    *,
    folder: Path | None = None,
    stdin: bytes = b"",
    seconds: float | None = None,
) -> tuple[int, str]:
    """Run a command; returns its exit status, and standard output and error together.

    Raises:
        CompilerDiedError: it crashed or took longer than `seconds`.
        ShaderError: it can't be run.
    """
    try:
        done = subprocess.run(
            [str(program), *arguments],
            cwd=folder,
            input=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=environment(program),
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        message = f"{program.name} took longer than {seconds:g} s"
        raise CompilerDiedError("timeout", message) from None
    except OSError as error:
        message = f"can't run this command: {error.strerror or error}"
        raise ShaderError(message, file=program) from None
    output = done.stdout.decode("utf-8", "replace")
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        raise CompilerDiedError("crash", f"{program.name} died: {name}")
    if done.returncode in (126, 127):
        last = output.strip().rpartition("\n")[2]
        raise ShaderError(f"this command does not start: {last}", file=program, remedy=INSTALL)
    return done.returncode, output


def _candidates(names: Sequence[str], wheel: str) -> Iterator[Path]:
    for name in names:
        with suppress(ShaderError):
            yield find(wheel, name, "bin")
    sdk = os.environ.get("VULKAN_SDK")
    folders = [os.environ.get("PATH", os.defpath), *([str(Path(sdk) / "bin")] if sdk else [])]
    found = (shutil.which(name, path=folder) for folder in folders for name in names)
    yield from map(Path, filter(None, found))


def environment(program: Path) -> Mapping[str, str]:
    """Variables for a command; those of the wheels need the path of their libraries."""
    lib = program.parent.parent / "lib"
    if lib.parent.name != "cmeel.prefix":
        return os.environ
    paths = [str(lib), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
    return {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join(paths)}
