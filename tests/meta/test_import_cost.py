"""Importing is cheap and touches no device: what is heavy is imported where it is used.

Modules are looked at rather than clocks: a slow machine fails no test, a careless import does.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from shaderlab.cli import COMMANDS

DEVICE = {"moderngl", "glcontext", "OpenGL", "vulkan", "cffi", "playwright"}
HEAVY = {
    "colour",
    "OpenImageIO",
    "jinja2",
    "pygments",
    "latex2mathml",
    "trimesh",
    "scipy",
    "glm",
}
PRINTING = {"rich", "markdown_it"}


def modules_after(statement: str) -> set[str]:
    """Names of top-level modules loaded in a fresh interpreter by running `statement`."""
    show = "print('\\n' + ' '.join({name.split('.')[0] for name in sys.modules}))"
    code = f"import sys\n{statement}\n{show}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


@pytest.mark.parametrize(
    "statement",
    [
        "import shaderlab",
        "import shaderlab.glslmath, shaderlab.assets, shaderlab.reference",
        "import shaderlab.compiler, shaderlab.model.records",
        "import shaderlab.engine.run",
        "import shaderlab.glsl",
    ],
)
def test_importing_loads_nothing_heavy(statement: str) -> None:
    loaded = modules_after(statement)
    assert not loaded & (DEVICE | HEAVY | PRINTING | {"click", "pytest", "cattrs"})


def test_the_pytest_plugin_costs_other_peoples_tests_little() -> None:
    new = modules_after("import shaderlab.pytest_plugin") - modules_after("import pytest")
    assert not new & (DEVICE | HEAVY | PRINTING | {"click", "cattrs"})


def test_listing_cases_loads_nothing_heavy() -> None:
    statement = "from shaderlab.cli import cli\ncli(['list'], standalone_mode=False)"
    assert not modules_after(statement) & (DEVICE | HEAVY | PRINTING | {"pytest", "cattrs"})


def test_a_worker_loads_nothing_heavy() -> None:
    loaded = modules_after("import shaderlab.compiler.glslang, shaderlab.engine.worker")
    assert not loaded & (DEVICE | HEAVY | PRINTING | {"click", "cattrs"})


def test_a_command_starts_its_worker_before_it_loads_anything_large() -> None:
    """Not even NumPy: what the report needs is loaded while the worker gets ready."""
    loaded = modules_after("import shaderlab.cli.run, shaderlab.engine.jobs")
    assert not loaded & (DEVICE | HEAVY | PRINTING | {"numpy", "cattrs"})


@pytest.mark.parametrize(
    ("words", "ending"),
    [
        (["audit"], ".frag"), (["audit"], ".glsl"), (["audit", "--precision"], ".frag"),
        (["diff"], ".frag"), (["diff"], ".glsl"), (["explain"], ".frag"),
    ],
)  # fmt: skip
def test_a_command_about_shader_files_leaves_what_is_large_to_its_worker(
    words: list[str], ending: str, tmp_path: Path
) -> None:
    """The answer is plain data, too: unpickling it loads nothing. The worker loads no driver."""
    function = "float half_of(float x) { return 0.5 * x; }"
    main = "in float x; out vec4 color; void main() { color = vec4(half_of(x)); }"
    file = tmp_path / f"one{ending}"
    file.write_text(f"#version 330 core\n{function}\n{main}" if ending == ".frag" else function)
    words = [*words, str(file), *[str(file)] * (words == ["diff"])]
    command = f"from shaderlab.cli import cli\ncli({words!r}, standalone_mode=False)"
    assert not modules_after(command) & (DEVICE | HEAVY | {"numpy", "tree_sitter"})
    loaded = modules_after(command.replace(words[0], words[0] + "', '-j', '0", 1))
    assert "numpy" in loaded and not loaded & (DEVICE | HEAVY)


def test_help_opens_no_device() -> None:
    """No command's: each is asked, in one interpreter."""
    statement = (
        "from shaderlab.cli import cli\n"
        f"for command in {list(COMMANDS)!r}:\n    cli([command, '-h'], standalone_mode=False)"
    )
    assert not modules_after(statement) & (DEVICE | HEAVY)
