"""SPIR-V of shaders in other languages, made by those languages' own compilers."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from shaderlab.errors import ShaderError
from shaderlab.files import open_regular

_SLANG = "slangc {file} -target spirv -O0 -g -stage {stage} -entry {entry} -o {module}"
_COMMANDS = {
    ".hlsl": _SLANG,
    ".slang": _SLANG,
    ".wgsl": "naga -g {file} {module}",
    ".spvasm": "spirv-as {file} -o {module}",
}
MODULES = (".spv", *_COMMANDS)
"""How files end that are SPIR-V, or become it."""
_LIMIT = 60  # seconds
# What entry points are called: `main`, PSMain, vs_main, frag, mainCS, …
_ENTRY = re.compile(
    rb"\b(main|(?:main_?)?(ps|pixel|frag|fragment|vs|vert|vertex|cs|compute)(?:_?(?:main|shader))?)"
    rb"\s*\([^;{}]*\)[^;{}()]*\{", re.I
)  # fmt: skip
_STAGES = {"fragment": "pf", "vertex": "v", "compute": "c"}  # initials of their names


def has_no_entry(path: Path) -> bool:
    """Whether a file of HLSL or Slang has functions alone, and none of them is an entry point."""
    if _COMMANDS.get(path.suffix.lower()) != _SLANG or not path.is_file():
        return False
    text = path.read_bytes()
    return b"[shader(" not in text and not _find_entries(text)


def _find_entries(text: bytes) -> dict[str | None, str]:
    """The entry points of a text by the stages that their names say, None where they say none."""
    initials = {initial: stage for stage, word in _STAGES.items() for initial in word}
    named = ((one.decode(), kind[:1].decode().lower()) for one, kind in _ENTRY.findall(text))
    return {initials.get(kind): one for one, kind in named}


def find_compiler(path: Path, otherwise: str) -> str:
    """Return the program that makes SPIR-V of such a file. Raises ShaderError: it is not installed;
    the remedy ends with `otherwise`."""
    name = _COMMANDS[path.suffix.lower()].split()[0]
    own = os.path.dirname(sys.executable)  # where wheels put their commands
    program = shutil.which(name) or shutil.which(name, path=own)
    if program is None:
        remedy = f"put {name} on PATH, or {otherwise}"
        raise ShaderError(f"needs {name}, which is not installed", file=path, remedy=remedy)
    return program


def read_module(path: Path, stage: str | None) -> bytes:
    """Return the SPIR-V of a module's file, or of a shader; a stage that neither an attribute in
    the text, the file's name (`a.vert.hlsl`) nor the entry point's (`VSMain`) says is `stage`, or
    else the fragment stage. Raises ShaderError: the language's compiler is not installed, or
    refuses the file; OSError: the file can't be read."""
    with open(open_regular(path), "rb") as file:
        data = file.read()
    command = _COMMANDS.get(path.suffix.lower())
    if command is None:
        return data
    with tempfile.TemporaryDirectory() as folder:
        module = Path(folder, "module.spv")
        inner = {".vert": "vertex", ".comp": "compute"}.get(Path(path.stem).suffix)
        if b"[shader(" in data:  # then every entry point has its stage
            command = re.sub(r" -stage.*main", "", command)
        entries = _find_entries(data)
        named = None not in entries and next((s for s in _STAGES if s in entries), None)
        stage = stage or inner or named or "fragment"
        entry = entries.get(None) or entries.get(stage, "main")
        places = {"file": str(path), "module": str(module), "stage": stage, "entry": entry}
        name, *words = (word.format(**places) for word in command.split())
        shown = command.format_map(places | {"module": path.with_suffix(".spv")})
        program = find_compiler(path, f"compile the file elsewhere: {shown}")
        try:
            done = subprocess.run([program, *words], capture_output=True, timeout=_LIMIT)
        except subprocess.TimeoutExpired:
            raise ShaderError(f"{name} takes over {_LIMIT} s", file=path) from None
        if done.returncode or not module.exists():
            said = (done.stderr or done.stdout).decode(errors="replace").strip()
            errors = said[max(said.find("error"), 0) :]  # warnings come first, and hide them
            raise ShaderError(f"{name} refuses it:\n{errors}", file=path)
        return module.read_bytes()
