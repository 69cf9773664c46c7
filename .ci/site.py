"""What the site has beside docs/: CONTRIBUTING.md and pages of docstrings (a hook of MkDocs)."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import re
from pathlib import Path
from types import FunctionType
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that are made, and those that lie outside of docs/."""
    made = {
        "CONTRIBUTING.md": (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"),
        "api/cases.md": _page("Names for cases", _public("shaderlab/__init__.pyi")),
        "api/functions.md": _page("Tests of functions", ["shaderlab.glsl"]),
        "api/formulas.md": _page("Formulas", _modules("shaderlab.reference")),
    }
    for path, text in made.items():
        files.append(File.generated(config, path, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Point links to CONTRIBUTING.md, and those in it, to where it is in the site."""
    if page.file.src_uri == "CONTRIBUTING.md":
        return markdown.replace("](docs/", "](")
    return re.sub(r"\]\((?:\.\./)+CONTRIBUTING\.md", _upwards(page) + "CONTRIBUTING.md", markdown)


def _upwards(page: Any) -> str:
    return "](" + "../" * page.file.src_uri.count("/")


def _page(title: str, names: list[str]) -> str:
    return f"# {title}\n\n" + "\n\n".join(f"::: {name}" for name in names) + "\n"


def _public(stub: str) -> list[str]:
    """Where each public class and function is defined, by the stub that lists them."""
    found = {}
    for node in ast.parse((ROOT / stub).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and node.level:
            module = importlib.import_module(f"shaderlab.{node.module}")
            for alias in node.names:
                value = getattr(module, alias.name, None)
                if isinstance(value, type | FunctionType):
                    found[f"{value.__module__}.{value.__qualname__}"] = None
    return list(found)


def _modules(package: str) -> list[str]:
    found = pkgutil.iter_modules(importlib.import_module(package).__path__)
    return [f"{package}.{module.name}" for module in found]
