"""Reference formulas with the float constants of their source text.

Python folds `0.52 - 0.02` when it compiles a formula; a device may compute it in float32. So a
formula that gives bands is compiled once more, with a global name in place of each float constant,
which stands for a `Literal`.
"""

from __future__ import annotations

import ast
import dis
import functools
import inspect
import linecache
import sysconfig
from collections.abc import Callable, Iterable, Iterator
from types import CellType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any
from weakref import WeakKeyDictionary

from shaderlab.bands import Literal, Rules

_COPIES: WeakKeyDictionary[FunctionType, dict[Rules, FunctionType]] = WeakKeyDictionary()
_FOREIGN = tuple({sysconfig.get_path(key) for key in ("stdlib", "purelib", "platlib")})
# What a module's constant may be computed from, to be computed again from literals.
_ARITHMETIC = (ast.BinOp, ast.UnaryOp, ast.Name, ast.Constant, ast.operator, ast.unaryop, ast.Load)


def with_literals(reference: Callable[..., Any], rules: Rules) -> Callable[..., Any]:
    """Return the same formula, computing with the constants of its source; the formula itself
    where that can't be had.

    Constants inside of lists, arrays and objects that were made before stay numbers: what Python
    has folded there stays folded.
    """
    converted: Callable[..., Any] = _convert(reference, rules)
    return converted


def _convert(value: Any, rules: Rules) -> Any:
    if type(value) is float:
        return Literal.of(value, rules)
    if isinstance(value, FunctionType):
        return _copy_function(value, rules)
    if isinstance(value, functools.partial):
        keywords = {name: _convert(v, rules) for name, v in value.keywords.items()}
        arguments = [_convert(v, rules) for v in value.args]
        return functools.partial(_convert(value.func, rules), *arguments, **keywords)
    if isinstance(value, MethodType) and isinstance(value.__func__, FunctionType):
        return MethodType(_copy_function(value.__func__, rules), value.__self__)
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
    """A module whose functions and constants are converted on first use."""

    def __init__(self, module: ModuleType, rules: Rules) -> None:
        self._module = module
        self._rules = rules

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._module, name)
        converted = _convert_global(self._module.__dict__, name, value, self._rules)
        setattr(self, name, converted)
        return converted


def _copy_function(function: FunctionType, rules: Rules) -> FunctionType:
    copies = _COPIES.setdefault(function, {})
    if rules in copies:
        return copies[rules]
    names = function.__globals__
    formula = _has_formulas(function.__module__ or "", names)
    code = _unfold(function.__code__) if formula else None
    if code is None:
        copies[rules] = function
        return function
    own: dict[str, Any] = {"__builtins__": names["__builtins__"], "__name__": names["__name__"]}
    cells = tuple(CellType() for _ in code.co_freevars)
    # The copy is known before what it calls is converted, which may call it again.
    copied = copies[rules] = FunctionType(code, own, function.__name__, None, cells)
    copied.__defaults__ = function.__defaults__ and tuple(
        _convert(v, rules) for v in function.__defaults__
    )
    copied.__kwdefaults__ = function.__kwdefaults__ and {
        name: _convert(v, rules) for name, v in function.__kwdefaults__.items()
    }
    for cell, original in zip(cells, function.__closure__ or (), strict=True):
        try:
            cell.cell_contents = _convert(original.cell_contents, rules)
        except ValueError:  # an empty cell, of a name that was deleted
            continue
    for name in {name for part in _code_objects(code) for name in part.co_names}:
        if name[0].isdigit():
            own[name] = Literal.of(float(name), rules)
        elif name in names:
            own[name] = _convert_global(names, name, names[name], rules)
    return copied


def _convert_global(names: dict[str, Any], name: str, value: Any, rules: Rules) -> Any:
    """A module's value; a number that it computes from constants is computed from literals."""
    if type(value) is not float:
        return _convert(value, rules)
    expression = _find_assigned_expression(names.get("__file__") or "", name)
    if expression is not None:
        own: dict[str, Any] = {"__builtins__": {}}
        for used in expression.co_names:
            if used[0].isdigit():
                own[used] = Literal.of(float(used), rules)
            elif used in names and used != name:
                own[used] = _convert_global(names, used, names[used], rules)
        try:
            found = eval(expression, own)
        except (ArithmeticError, NameError, TypeError):
            found = None
        if isinstance(found, Literal) and found == value:
            return found
    return Literal.of(value, rules)


class _NameFloats(ast.NodeTransformer):
    """Puts a global name for each float constant, spelled as it, which Python can't fold."""

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if type(node.value) is not float or not repr(node.value)[0].isdigit():
            return node
        return ast.copy_location(ast.Name(repr(node.value), ast.Load()), node)

    def visit_MatchValue(self, node: ast.MatchValue) -> ast.AST:
        return node  # patterns take no names


@functools.lru_cache(maxsize=256)
def _parse(file: str) -> ast.Module:
    try:
        return ast.parse("".join(linecache.getlines(file)))
    except (SyntaxError, ValueError):
        return ast.Module([], [])


@functools.lru_cache(maxsize=1024)
def _find_assigned_expression(file: str, name: str) -> CodeType | None:
    for statement in _parse(file).body:
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
            expression = _NameFloats().visit(value)
            return compile(ast.Expression(expression), file, "eval")
    return None


def _unfold(code: CodeType) -> CodeType | None:
    """A function's code with global names for float constants; None where its source is not
    found, or where it changes variables that a copy would not share."""
    if _assigns_outside(code):
        return None
    if not _has_floats(code.co_consts):  # as most: their source need not be read
        return code
    for number, statement in enumerate(_parse(code.co_filename).body):
        decorators = getattr(statement, "decorator_list", [])
        first = min(node.lineno for node in (statement, *decorators))
        if first <= code.co_firstlineno <= (statement.end_lineno or first):
            return _unfold_functions(code.co_filename, number).get(_identity(code))
    return None


def _has_floats(constants: Iterable[Any]) -> bool:
    """Whether a float is among constants, or inside of one: Python folds none away altogether."""
    for constant in constants:
        if isinstance(constant, float | complex):
            return True
        inside = constant.co_consts if inspect.iscode(constant) else constant
        if isinstance(inside, tuple | frozenset) and _has_floats(inside):
            return True
    return False


@functools.lru_cache(maxsize=1024)
def _unfold_functions(file: str, number: int) -> dict[Any, CodeType]:
    """The unfolded code of all functions of a file's statement, by their identities."""
    body = _parse(file).body
    # Calls of what is imported are compiled in a way of their own.
    imports = [
        s for s in body[:number] if isinstance(s, ast.Import | ast.ImportFrom | ast.If | ast.Try)
    ]
    original = _compile([*imports, body[number]], file)
    unfolded = _compile([*imports, _NameFloats().visit(body[number])], file)
    pairs = zip(_code_objects(original), _code_objects(unfolded), strict=True)
    return {_identity(before): after for before, after in pairs}


def _compile(statements: list[ast.stmt], file: str) -> CodeType:
    return compile(ast.Module(statements, []), file, "exec", dont_inherit=True)


def _assigns_outside(code: CodeType) -> bool:
    return any(
        step.opname == "STORE_GLOBAL"
        or (step.opname == "STORE_DEREF" and step.argval in code.co_freevars)
        for step in dis.get_instructions(code)
    )


def _identity(code: CodeType) -> tuple[Any, ...]:
    """What tells the functions of a file from each other, and from those of an older text."""
    return code.co_name, code.co_names, code.co_code, code.co_firstlineno, code.co_linetable


def _code_objects(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if inspect.iscode(constant):
            yield from _code_objects(constant)
