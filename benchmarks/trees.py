"""Shaders to measure and to test with: the lab's own, many times over, and broken ones."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from pathlib import Path

from shaderlab.compiler import Shaders
from shaderlab.compiler.sources import Source
from shaderlab.errors import ShaderError

SUFFIX = {
    "vertex": "vert",
    "tess_control": "tesc",
    "tess_evaluation": "tese",
    "geometry": "geom",
    "fragment": "frag",
    "compute": "comp",
}
_TOKEN = re.compile(r"\s+|\w+|.")
_NUMBERS = ("0", "1", "2", "3", "5", "8", "32", "64", "255", "4096", "2147483647")
_OPERATORS = ("+", "-", "*", "/", "%", "<", ">", "&", "|", "^")
_TYPES = ("float", "int", "uint", "bool", "vec2", "vec3", "vec4", "ivec3", "mat3", "mat4", "double")
_QUALIFIERS = ("in", "out", "uniform", "const", "flat", "inout", "buffer", "shared", "patch")
_SPICE = ("{", "}", "(", ")", ";", "0", "1e38", "-1", "in", "out", "uniform", "struct", "[3]", "é")


def own_shaders(repository: Path) -> list[Source]:
    """Every shader of the lab with its includes expanded, sorted by name."""
    shaders = Shaders([repository / "shaders"])
    found = []
    for name in shaders.names():
        try:
            found.append(shaders.load(name))
        except ShaderError:
            continue  # a file to be included
    return found


def variation(source: Source, number: int) -> str:
    """The shader with one more function, so that no two texts are equal; no line moves."""
    return (
        f"{source.text.rstrip()}\nfloat variation_{number}(float x) {{ return x + {number}.0; }}\n"
    )


def write_tree(folder: Path, repository: Path, count: int) -> list[Path]:
    """That many right shaders in folders of a hundred, none like another."""
    own = [source for source in own_shaders(repository) if "errata" not in source.name]
    paths = []
    for number in range(count):
        source = own[number % len(own)]
        path = folder / f"{number // 100:03}" / f"{number:05}.{SUFFIX[source.stage]}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(variation(source, number), encoding="utf-8")
        paths.append(path)
    return paths


def mutant(text: str, rng: random.Random) -> str:
    """The text, which has no comments, with a few changes; often it still compiles.

    Half of the changes are gentle: another number, operator, type, or line order. The others
    delete, double, swap, misspell or insert tokens. Its first line is left alone.
    """
    first, _, body = text.partition("\n")
    tokens: list[str] = _TOKEN.findall(body)
    places = [i for i, token in enumerate(tokens) if token.strip()]
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if rng.random() < 0.5:
            _change_gently(tokens, rng)
        else:
            _change(tokens, rng.choice(places), rng.choice(places), rng)
    return first + "\n" + "".join(tokens)


def _change_gently(tokens: list[str], rng: random.Random) -> None:
    for kind in rng.sample((_NUMBERS, _OPERATORS, _TYPES, _QUALIFIERS), 4):
        places = [i for i, token in enumerate(tokens) if token in kind]
        if places:
            tokens[rng.choice(places)] = rng.choice(kind)
            return


def _change(tokens: list[str], at: int, other: int, rng: random.Random) -> None:
    kind = rng.randrange(6)
    if kind == 0:
        tokens[at] = ""
    elif kind == 1:
        tokens[at] += " " + tokens[at]
    elif kind == 2:
        tokens[at], tokens[other] = tokens[other], tokens[at]
    elif kind == 3:
        tokens[at] += "x"
    elif kind == 4:
        tokens[at] = tokens[other]
    else:
        tokens[at] += f" {rng.choice(_SPICE)}"


def noise(rng: random.Random) -> bytes:
    """Something that is hardly a shader: bytes, brackets, or GLSL's words in no order."""
    kind = rng.randrange(4)
    if kind == 0:
        return rng.randbytes(rng.randrange(200))
    if kind == 1:
        return bytes(rng.choices(b"(){}[];,.+-*/#\\\"' \n01xe", k=rng.randrange(400)))
    words = ["void main()", "float", "vec4", "x", "=", "1.0", ";", "{", "}", "(", ")", "if", "#if"]
    words += ["#define x", "\n", "uniform", "for", "struct", "return", "layout(location=0)", "mat4"]
    text = " ".join(rng.choices(words, k=rng.randrange(200)))
    return (f"#version 450\n{text}\n" if kind == 2 else text).encode()


def storm(repository: Path, count: int, seed: int) -> Iterator[tuple[str, bytes]]:
    """Names and contents of mutated and random sources, nine of ten mutated."""
    rng = random.Random(seed)
    own = own_shaders(repository)
    for number in range(count):
        source = rng.choice(own)
        wild = number % 10 == 9
        data = noise(rng) if wild else mutant(source.code, rng).encode()
        yield f"{number:05}.{SUFFIX[source.stage]}", data
