"""The float constants of a function's code."""

from __future__ import annotations

import ast
import dis
import functools
import inspect
import linecache
import re
import sysconfig
from collections.abc import Callable, Iterable, Iterator
from types import CellType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any
from weakref import WeakKeyDictionary

from shaderlab.bands import Literal, Rules

_LOADS_CONSTANT = dis.opmap["LOAD_CONST"]
_NUMBER = re.compile(rb"[\d._]+([eE][+-]?[\d_]+)?")


def with_literals(code: CodeType, literal: Callable[[float], Literal]) -> CodeType | None:
    """A function's code with literals for its float constants, where each stands in the source as
    it is, so that Python has folded none: then the source need not be parsed. None elsewhere."""
    if not has_floats(code.co_consts) or len(code.co_consts) > 256:
        return None
    lines = linecache.getlines(code.co_filename)
    spelt = set()
    steps = zip(code.co_code[::2], code.co_code[1::2], code.co_positions(), strict=True)
    for step, number, (line, last, start, end) in steps:
        if step != _LOADS_CONSTANT or type(value := code.co_consts[number]) is not float:
            continue
        if not line or line != last or line > len(lines):
            return None
        text = lines[line - 1].encode()[start:end]
        # Patterns of `match` take no literals.
        if not _NUMBER.fullmatch(text) or float(text) != value or "case" in lines[line - 1]:
            return None
        spelt.add(number)
    made: list[Any] = []
    for number, value in enumerate(code.co_consts):
        if number in spelt and repr(value)[0].isdigit():
            made.append(literal(value))
        elif inspect.iscode(value) and has_floats(value.co_consts):
            inner = with_literals(value, literal)
            if inner is None:
                return None
            made.append(inner)
        elif has_floats((value,)):
            return None
        else:
            made.append(value)
    return code.replace(co_consts=tuple(made))


def has_floats(constants: Iterable[Any]) -> bool:
    """Whether a float is among constants, or inside of one: Python folds none away altogether."""
    for constant in constants:
        if isinstance(constant, float | complex):
            return True
        inside = constant.co_consts if inspect.iscode(constant) else constant
        if isinstance(inside, tuple | frozenset) and has_floats(inside):
            return True
    return False


_COPIES: WeakKeyDictionary[FunctionType, dict[Rules, FunctionType]] = WeakKeyDictionary()
_STORING = {dis.opmap["STORE_GLOBAL"], dis.opmap["STORE_DEREF"]}
_FOREIGN = tuple({sysconfig.get_path(key) for key in ("stdlib", "purelib", "platlib")})
# What a constant of a module may be computed of, to be computed again of literals.
_ARITHMETIC = (ast.BinOp, ast.UnaryOp, ast.Name, ast.Constant, ast.operator, ast.unaryop, ast.Load)


def as_written(reference: Callable[..., Any], rules: Rules) -> Callable[..., Any]:
    """The same formula with the constants of its source; itself where that can't be had.

    Constants inside of lists, arrays and objects that were made before stay numbers: what Python
    has folded there stays folded.
    """
    converted: Callable[..., Any] = _converted(reference, rules)
    return converted


def _converted(value: Any, rules: Rules) -> Any:
    """A function, module or number as formulas should see it."""
    if type(value) is float:
        return Literal.of(value, rules)
    if isinstance(value, FunctionType):
        return _copied(value, rules)
    if isinstance(value, functools.partial):
        given = {name: _converted(v, rules) for name, v in value.keywords.items()}
        arguments = [_converted(v, rules) for v in value.args]
        return functools.partial(_converted(value.func, rules), *arguments, **given)
    if isinstance(value, MethodType) and isinstance(value.__func__, FunctionType):
        return MethodType(_copied(value.__func__, rules), value.__self__)
    if isinstance(value, ModuleType) and _has_formulas(value.__name__, value.__dict__):
        return _Module(value, rules)
    return value


def _has_formulas(name: str, names: dict[str, Any]) -> bool:
    """Whether a module is a case's or a user's, or one of the lab's formulas."""
    if name.partition(".")[0] == "shaderlab":
        return name.startswith("shaderlab.reference")
    file = names.get("__file__") or ""
    return bool(file) and not file.startswith(_FOREIGN)


class _Module:
    """A module whose functions and constants are converted as they are asked for."""

    def __init__(self, module: ModuleType, rules: Rules) -> None:
        self._module = module
        self._rules = rules

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._module, name)
        found = _global(self._module.__dict__, name, value, self._rules)
        setattr(self, name, found)
        return found


class _Literals(dict[float, Literal]):
    """A literal for each number, made once: the same object is the same value to bands."""

    def __init__(self, rules: Rules) -> None:
        self._rules = rules

    def __missing__(self, value: float) -> Literal:
        made = self[value] = Literal.of(value, self._rules)
        return made


def _copied(function: FunctionType, rules: Rules) -> FunctionType:
    copies = _COPIES.setdefault(function, {})
    if rules in copies:
        return copies[rules]
    names = function.__globals__
    code = None
    if _has_formulas(function.__module__ or "", names):
        code = function.__code__
        spelt = with_literals(code, _Literals(rules).__getitem__)
        code = _unfolded(code) if spelt is None or _assigns_outside(code) else spelt
    if code is None:
        copies[rules] = function
        return function
    own: dict[str, Any] = {"__builtins__": names["__builtins__"], "__name__": names["__name__"]}
    cells = tuple(CellType() for _ in code.co_freevars)
    made = copies[rules] = FunctionType(code, own, function.__name__, None, cells)
    # The copy is known before what it calls is converted, which may call it again.
    made.__defaults__ = function.__defaults__ and tuple(
        _converted(v, rules) for v in function.__defaults__
    )
    made.__kwdefaults__ = function.__kwdefaults__ and {
        name: _converted(v, rules) for name, v in function.__kwdefaults__.items()
    }
    for cell, original in zip(cells, function.__closure__ or (), strict=True):
        try:
            cell.cell_contents = _converted(original.cell_contents, rules)
        except ValueError:  # an empty cell, of a name that was deleted
            continue
    for name in {name for part in _parts(code) for name in part.co_names}:
        if name[0].isdigit():
            own[name] = Literal.of(float(name), rules)
        elif name in names:
            own[name] = _global(names, name, names[name], rules)
    return made


def _global(names: dict[str, Any], name: str, value: Any, rules: Rules) -> Any:
    """A module's value; a number that the module computes of constants, computed of literals."""
    if type(value) is not float:
        return _converted(value, rules)
    expression = _assigned(names.get("__file__") or "", name)
    if expression is not None:
        own: dict[str, Any] = {"__builtins__": {}}
        for used in expression.co_names:
            if used[0].isdigit():
                own[used] = Literal.of(float(used), rules)
            elif used in names and used != name:
                own[used] = _global(names, used, names[used], rules)
        try:
            found = eval(expression, own)
        except (ArithmeticError, NameError, TypeError):
            found = None
        if isinstance(found, Literal) and found == value:
            return found
    return Literal.of(value, rules)


def _without_floats(node: Any) -> Any:
    """A syntax tree with a global name for each float constant, spelt as it, which Python cannot
    fold; the very same one where it has none."""
    if isinstance(node, ast.Constant):
        if type(node.value) is not float or not repr(node.value)[0].isdigit():
            return node
        return ast.copy_location(ast.Name(repr(node.value), ast.Load()), node)
    if not isinstance(node, ast.AST) or isinstance(node, ast.MatchValue):
        return node
    parts = dict(ast.iter_fields(node))
    made = {
        name: [_without_floats(each) for each in part]
        if isinstance(part, list)
        else _without_floats(part)
        for name, part in parts.items()
    }
    if all(_same(made[name], part) for name, part in parts.items()):
        return node
    return ast.copy_location(type(node)(**made), node)


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, list):
        return all(a is b for a, b in zip(one, other, strict=True))
    return one is other


@functools.lru_cache(maxsize=256)
def _parsed(file: str) -> ast.Module:
    """A file's syntax tree; empty where it can't be read."""
    try:
        return ast.parse("".join(linecache.getlines(file)))
    except (SyntaxError, ValueError):
        return ast.Module([], [])


@functools.lru_cache(maxsize=1024)
def _assigned(file: str, name: str) -> CodeType | None:
    """The arithmetic that a file assigns to a name of its top level, unfolded."""
    for statement in _parsed(file).body:
        if isinstance(statement, ast.Assign):
            targets: list[ast.expr] = statement.targets
        elif isinstance(statement, ast.AnnAssign):
            targets = [statement.target]
        else:
            continue
        value = statement.value
        if value is None or not any(isinstance(t, ast.Name) and t.id == name for t in targets):
            continue
        if all(isinstance(node, _ARITHMETIC) for node in ast.walk(value)):
            return compile(ast.Expression(_without_floats(value)), file, "eval")
    return None


def _unfolded(code: CodeType) -> CodeType | None:
    """A function's code with global names for float constants; None where its source is not
    found, or where it changes variables that a copy would not share."""
    if not has_floats(code.co_consts):  # as most: their source need not be read
        return None if _assigns_outside(code) else code
    body = _parsed(code.co_filename).body
    for number, statement in enumerate(body):
        first = min([statement.lineno, *(d.lineno for d in _decorators(statement))])
        if first <= code.co_firstlineno <= (statement.end_lineno or first):
            changed = _pieces(code.co_filename, number).get(_place(code))
            return None if changed is None or _assigns_outside(changed) else changed
    return None


def _decorators(statement: ast.stmt) -> list[ast.expr]:
    found: list[ast.expr] = getattr(statement, "decorator_list", [])
    return found


@functools.lru_cache(maxsize=1024)
def _pieces(file: str, number: int) -> dict[Any, CodeType]:
    """The unfolded code of all functions of a file's statement, by their places."""
    body = _parsed(file).body
    # Calls of what is imported are compiled in a way of their own.
    before = [
        s for s in body[:number] if isinstance(s, ast.Import | ast.ImportFrom | ast.If | ast.Try)
    ]
    own = body[number]
    unfolded = _without_floats(own)
    original = _compiled([*before, own], file)
    changed = original if unfolded is own else _compiled([*before, unfolded], file)
    pairs = zip(_parts(original), _parts(changed), strict=True)
    return {_place(before): after for before, after in pairs}


def _compiled(statements: list[ast.stmt], file: str) -> CodeType:
    return compile(ast.Module(statements, []), file, "exec", dont_inherit=True)


def _assigns_outside(code: CodeType) -> bool:
    """Whether a function changes variables that a copy of it would not share."""
    if not (_STORING & set(code.co_code[::2])):
        return False
    return any(
        step.opname == "STORE_GLOBAL"
        or (step.opname == "STORE_DEREF" and step.argval in code.co_freevars)
        for step in dis.get_instructions(code)
    )


def _place(code: CodeType) -> tuple[Any, ...]:
    """What tells the functions of a file from each other, and from those of an older text."""
    return code.co_name, code.co_names, code.co_code, code.co_firstlineno, code.co_linetable


def _parts(code: CodeType) -> Iterator[CodeType]:
    """A code object and those inside of it, in the order of their source."""
    yield code
    for constant in code.co_consts:
        if inspect.iscode(constant):
            yield from _parts(constant)
