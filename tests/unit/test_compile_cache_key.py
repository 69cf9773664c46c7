"""Where the compile cache is, its digest of the compilers, and how to switch it off."""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from shaderlab.compiler import compile_cache, glslang
from shaderlab.compiler.compile import compile_program
from shaderlab.compiler.compile_cache import (
    cache_folder,
    cached_compiler,
    compilers_digest,
    files_digest,
)
from shaderlab.errors import ShaderError

LATER = time.time() + 3600


def two_files(folder: Path) -> list[Path]:
    files = [folder / "lib.so", folder / "code.py"]
    files[0].write_bytes(b"\x7fELF of the compiler")
    files[1].write_text("LIMIT = 200\n")
    return files


def rewritten(files: list[Path]) -> None:
    """Other bytes, as many, under the same name and time."""
    before = files[1].stat()
    files[1].write_text("LIMIT = 300\n")
    os.utime(files[1], ns=(before.st_atime_ns, before.st_mtime_ns))


def replaced(files: list[Path]) -> None:
    new = files[0].with_name("new")
    new.write_bytes(b"\x7fELF of a compiler..")
    new.replace(files[0])


def swapped(files: list[Path]) -> None:
    files.reverse()


@pytest.mark.parametrize("change", [rewritten, replaced, swapped])
def test_the_digest_changes_with_any_file(
    tmp_path: Path, change: Callable[[list[Path]], None]
) -> None:
    files = two_files(tmp_path)
    first = files_digest(files, LATER)
    assert first is not None and len(first) == 64
    change(files)
    assert files_digest(files, LATER) not in (first, None)


def test_the_digest_depends_on_contents_only(tmp_path: Path) -> None:
    first = files_digest(two_files(tmp_path), LATER)
    (tmp_path / "elsewhere").mkdir()
    assert files_digest(two_files(tmp_path / "elsewhere"), LATER) == first


def test_another_python_has_another_digest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = two_files(tmp_path)
    first = files_digest(files, LATER)
    monkeypatch.setattr(sys.implementation, "cache_tag", "snake-20")
    assert files_digest(files, LATER) != first


def test_files_that_have_just_been_written_have_no_digest(tmp_path: Path) -> None:
    files = two_files(tmp_path)
    now = time.time()
    assert files_digest(files, now) is None
    assert files_digest(files, now - 60) is None
    assert files_digest(files, now + 60) is not None


def test_the_digest_covers_the_libraries_and_the_code_around_them(
    monkeypatch: pytest.MonkeyPatch, repository: Path
) -> None:
    seen: list[Path] = []
    monkeypatch.setattr(compile_cache, "files_digest", lambda paths: seen.extend(paths) or "digest")
    assert compilers_digest() == "digest"
    assert set(glslang.files()) < set(seen)
    assert {path.name for path in glslang.files()} == {
        "libglslang.so", "libSPIRV.so", "libglslang-default-resource-limits.so",
        "libSPIRV-Tools-shared.so",
    }  # fmt: skip
    own = set((repository / "shaderlab" / "compiler").glob("*.py"))
    lab = repository / "shaderlab"
    own |= {lab / "errors.py", lab / "files.py"}
    assert set(seen) == own | set(glslang.files())


def test_the_digest_covers_all_that_compiling_imports_of_the_lab(
    monkeypatch: pytest.MonkeyPatch, repository: Path
) -> None:
    import subprocess

    show = (
        "import sys, shaderlab.compiler.compile_cache\n"
        "print('\\n'.join(m.__file__ for n, m in sys.modules.items() if n[:9] == 'shaderlab'))"
    )
    done = subprocess.run([sys.executable, "-c", show], capture_output=True, text=True, check=True)
    seen: list[Path] = []
    monkeypatch.setattr(compile_cache, "files_digest", lambda paths: seen.extend(paths) or "digest")
    compilers_digest()
    package = repository / "shaderlab" / "__init__.py"
    assert set(map(Path, done.stdout.split())) - {package} <= set(seen)


def test_without_the_libraries_there_is_no_digest(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> tuple[Path, ...]:
        raise ShaderError("not installed")

    monkeypatch.setattr(compile_cache, "files", missing)
    assert compilers_digest() is None
    monkeypatch.setattr(compile_cache, "files", lambda: (Path("/nowhere/lib.so"),))
    assert compilers_digest() is None


def test_the_variable_names_the_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for named, folder in (
        (str(tmp_path / "own"), tmp_path / "own"),
        (".cache/lab", tmp_path / ".cache" / "lab"),
        ("~/lab", tmp_path / "home" / "lab"),
    ):
        monkeypatch.setenv("SHADERLAB_CACHE_DIR", named)
        assert cache_folder() == folder / "compiled"


def test_the_default_folder_is_among_the_users_caches(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("SHADERLAB_CACHE_DIR")
    monkeypatch.setenv("HOME", str(tmp_path))
    usual = tmp_path / ".cache" / "shaderlab" / "compiled"
    for base, folder in (
        (str(tmp_path / "xdg"), tmp_path / "xdg" / "shaderlab" / "compiled"),
        ("", usual),
        ("not/absolute", usual),
    ):
        monkeypatch.setenv("XDG_CACHE_HOME", base)
        assert cache_folder() == folder
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_folder() == usual

    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", homeless)
    assert cache_folder() is None
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", "~no-such-user/cache")
    assert cache_folder() is None


def test_an_empty_variable_switches_it_off(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", "")
    assert cache_folder() is None
    assert cached_compiler() is compile_program
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", str(tmp_path))
    assert cached_compiler() is not compile_program
    assert cached_compiler() == cached_compiler()


def test_without_a_folder_there_is_no_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    assert cached_compiler() is not compile_program
    monkeypatch.setenv("SHADERLAB_CACHE_DIR", "")
    assert cached_compiler() is compile_program
