"""`shaderlab prove`: `shaderlab audit --prove`, by the name that one looks for."""

from functools import partial
from typing import Any

import click

from shaderlab.cli import audit

_audit: Any = audit.command
_FIXED = {"prove": True, "possible": False}

command = click.Command(
    "prove",
    callback=partial(_audit.callback, **_FIXED),
    params=[each for each in _audit.params if each.name not in _FIXED],
    help="""Prove for all inputs of their ranges that a shader does nothing that GLSL leaves
    undefined, or show an input at which it does. What can be neither proved nor refuted is open,
    with the share of the range that is left. The same as `shaderlab audit --prove`.

    \b
    Examples:
      shaderlab prove lighting.glsl --range roughness=0.05:1
      shaderlab prove lamp.frag --assume 'far > near'

    Exit code: 0 all proved, 1 a hazard found, 2 something open, or wrong usage.
    """,
)
