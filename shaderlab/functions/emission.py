"""The text of a file with nothing but what one function needs, line for line as in the file.

What other stages and callers set becomes plain variables, which a kernel assigns.
"""

from __future__ import annotations

from collections.abc import Mapping

from shaderlab.functions.declarations import Declarations, constant
from shaderlab.functions.scanner import Item, Named, Spec
from shaderlab.functions.types import Type


def redeclares(item: Item) -> bool:
    """Whether an item declares anew what GLSL declares itself."""
    return any(name.startswith("gl_") for name in item.declares)


class Types:
    """A file's types by the way they are written."""

    def __init__(self, found: Declarations) -> None:
        self._constants: Mapping[str, int] = found.constants
        self._structs = {i.name: i for i in found.items if i.kind in ("struct", "block")}

    def of(self, spec: Spec) -> Type:
        """Raises LookupError, which says what is not known."""
        dims = []
        for length in spec.lengths:
            value = constant(length, self._constants)
            if value is None or value < 1:
                raise LookupError(f"the length of {spec.name}[{length}] is not known")
            dims.append(value)
        struct = self._structs.get(spec.name)
        if struct is None:
            return Type(spec.name, tuple(dims))
        members = tuple((member.name, self.of(member.spec)) for member in struct.members)
        return Type(spec.name, tuple(dims), members)


def emitted(found: Declarations, needed: list[Item], types: Types) -> str:
    """The file's text with nothing but the needed items, each on its own lines."""
    parts, at = [], 0
    text = found.text
    for item in needed:
        parts.append("\n" * text.count("\n", at, item.start))
        whole = text[item.start : item.end]
        new = _as_variables(item, whole, types)
        parts.append(new + "\n" * (whole.count("\n") - new.count("\n")))
        at = item.end
    return "".join(parts)


def _as_variables(item: Item, whole: str, types: Types) -> str:
    """An item's own text, or plain variables for what other stages and callers set."""
    if redeclares(item):
        return ""
    if item.kind == "block":
        members = "".join(f"{_spelt(m)}; " for m in item.members)
        if item.instance is None:
            return members
        return f"struct {item.name} {{ {members}}}; {_spelt(item.instance)};"
    if item.kind == "struct" and item.variables:
        head = whole[whole.index("struct") : whole.rindex("}") + 1]
        return head + "; " + _plain_variables(item.variables, types)
    if item.kind == "variables":
        return _plain_variables(item.members, types)
    return whole


def _plain_variables(variables: tuple[Named, ...], types: Types) -> str:
    found = []
    for named in variables:
        try:
            opaque = types.of(named.spec).opaque
        except LookupError:
            opaque = False
        default = " = " + " ".join(named.default.split()) if named.default else ""
        qualifier = "uniform " if opaque else "const " if "const" in named.qualifiers else ""
        found.append(f"{qualifier}{_spelt(named)}{default};")
    return " ".join(found)


def _spelt(named: Named) -> str:
    return f"{named.spec.name} {named.name}" + "".join(f"[{n}]" for n in named.spec.lengths)
