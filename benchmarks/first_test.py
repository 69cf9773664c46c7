"""How long a newcomer waits: from installing the wheel to a first test that fails, then passes.

    python -m benchmarks.first_test [--python PYTHON]

Builds the wheel, then does in a new environment and an empty folder what docs/guide/tutorial.md
says, up to its first shader, and prints the seconds of each step. pip takes packages from where it
is set up to take them, its cache left aside; a reader's own time comes on top.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from tests.meta.examples import Command, examples

ROOT = Path(__file__).resolve().parents[1]


def main() -> None:
    """Do it, and print a line for each step and the sum. Exits with 1 where a step goes wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--python", default=sys.executable, help="of the new environment")
    python = parser.parse_args().python
    with tempfile.TemporaryDirectory(prefix="shaderlab-") as name:
        folder = Path(name, "fog")
        folder.mkdir()
        build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", name]
        subprocess.run([*build, str(ROOT)], check=True, capture_output=True)
        (wheel,) = Path(name).glob("*.whl")
        total = step("python3 -m venv .venv", f"{python} -m venv .venv", folder)
        total += step("pip install", f"pip install --no-cache-dir '{wheel}[pytest]'", folder)
        for example in examples(ROOT / "docs" / "guide" / "tutorial.md"):
            if not isinstance(example, Command):
                (folder / example.name).write_text(example.text, encoding="utf-8")
                if example.name.endswith(".frag"):
                    break
                continue
            total += step(example.line, example.line, folder, example.status)
        print(f"{total:6.1f} s  from nothing to a test that failed and passes")


def step(what: str, line: str, folder: Path, status: int = 0) -> float:
    """Run a command line with the folder's environment; returns its seconds."""
    path = f"{folder / '.venv' / 'bin'}{os.pathsep}{os.environ['PATH']}"
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "VIRTUAL_ENV"))}
    env = {**kept, "PATH": path, "SHADERLAB_CACHE_DIR": str(folder.parent / "cache")}
    began = time.perf_counter()
    done = subprocess.run(
        ["sh", "-c", line], cwd=folder, env=env, stdin=subprocess.DEVNULL, capture_output=True,
        text=True,
    )  # fmt: skip
    seconds = time.perf_counter() - began
    print(f"{seconds:6.1f} s  {what}", flush=True)
    if done.returncode != status:
        sys.exit(done.stdout + done.stderr)
    return seconds


if __name__ == "__main__":
    main()
