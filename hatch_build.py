"""Builds the compiled passes over bands where there is a C compiler; elsewhere NumPy does them.

Wheels and editable installs run this; `python hatch_build.py` does it in a checkout.
"""

from __future__ import annotations

import os
import shutil
import sysconfig
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

# Directed rounding must be left alone, and no product be fused with a sum; the rest lets loops be
# vectorised.
FLAGS = [
    *("-O3", "-g0", "-std=gnu11", "-frounding-math", "-ffp-contract=off"),
    *("-fno-trapping-math", "-fno-math-errno"),
]


def build(root: Path) -> Path | None:
    """The extension module in the checkout `root`, newer than its sources; None without one."""
    import numpy
    from setuptools import Distribution, Extension
    from setuptools.command.build_ext import build_ext

    folder = root / "shaderlab" / "bands"
    built = folder / f"_kernels{sysconfig.get_config_var('EXT_SUFFIX')}"
    sources = [Path(__file__), *(folder / "kernels").iterdir()]
    if built.exists() and built.stat().st_mtime >= max(s.stat().st_mtime for s in sources):
        return built
    built.unlink(missing_ok=True)
    if os.name != "posix":
        return None
    extension = Extension(
        "_kernels",
        [str(folder / "kernels" / "_kernels.c")],
        include_dirs=[numpy.get_include()],
        extra_compile_args=FLAGS,
        optional=True,
    )
    with TemporaryDirectory() as scratch:
        command = build_ext(Distribution({"ext_modules": [extension]}))
        command.build_lib = command.build_temp = scratch
        command.ensure_finalized()
        command.run()
        made = Path(scratch, built.name)
        if not made.exists():
            return None
        # Replaced whole: a process may have the old one in use.
        shutil.copy2(made, f"{built}.new")
        os.replace(f"{built}.new", built)
    return built


class KernelsHook(BuildHookInterface[Any]):
    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        built = build(Path(self.root))
        if built is not None:
            build_data["artifacts"].append(f"/{built.relative_to(self.root).as_posix()}")
            build_data["pure_python"] = False
            build_data["infer_tag"] = True


if __name__ == "__main__":
    print(build(Path(__file__).resolve().parent) or "no compiled passes: NumPy does them")
