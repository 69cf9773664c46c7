"""Files and folders compiled as `shaderlab compile` does, for tests and benchmarks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from shaderlab.compiler.harness import CompileOptions, FileResult, compile_files
from shaderlab.compiler.shader_files import find_shaders
from shaderlab.workers.pool import WorkerPool


def compile_glsl(
    paths: Sequence[str | Path],
    *,
    link: bool = False,
    workers: WorkerPool | None = None,
    **options: Any,
) -> Iterator[FileResult]:
    """One result for each shader at these paths, sorted by path; with `link` they are the stages of
    one program. Raises as `find_shaders`."""
    how = CompileOptions(**options)
    shaders = find_shaders(paths, [Path(folder) for folder in how.include], stage=how.stage)
    return compile_files([shaders] if link else [[one] for one in shaders], how, workers)
