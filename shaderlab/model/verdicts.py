"""What compilers and drivers say of a program, as plain data: part of the records of a run."""

from dataclasses import dataclass
from typing import Literal

Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True, kw_only=True)
class Diagnostic:
    """One message of a compiler, at the author's own file and line (counted from 1)."""

    file: str
    line: int | None
    severity: Severity
    message: str
    token: str = ""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The verdict of one compile target, or of a driver, on one program.

    `ok` covers the compiler and, for SPIR-V targets, SPIRV-Tools' validator as well; the
    validator alone is in `valid`, None where there was no module to look at.
    `spirv_bytes` is the size of all its stages' modules and `instructions` how many SPIR-V
    instructions they have; both are 0 for plain GLSL. `assembly` is the file of the modules as
    text, those of the program's other targets among them, relative to the run's folder, or "".
    `status` is "" for an answer; "crash" or "timeout" where the compiler gave none, and
    "disagrees" where a driver's answer is not that of the plain GLSL compiler.
    """

    target: str
    ok: bool
    diagnostics: tuple[Diagnostic, ...] = ()
    spirv_bytes: int = 0
    instructions: int = 0
    valid: bool | None = None
    assembly: str = ""
    status: Literal["", "crash", "timeout", "disagrees"] = ""
