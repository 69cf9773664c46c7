"""Handlers of arithmetic: on floats, integers, conditions and composites."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from shaderlab import glslmath
from shaderlab.bands import Band, Integer, TriBool
from shaderlab.bands.arithmetic import product_bounds
from shaderlab.bands.bounds import Terms
from shaderlab.bands.exact import apply_monotone, as_tri_bool, negate
from shaderlab.bands.rounding import LARGEST, RELATIVE_STEP
from shaderlab.compiler.spirv import Glsl450 as G, Op
from shaderlab.errors import FormulaError

from .arithmetic import FLOAT64, Numbers
from .program import Instruction, Type
from .values import PathState, compose, fetch, known_index, replace_part, select

if TYPE_CHECKING:
    from .running import Run

Handler = Callable[["Run", Instruction, PathState], Any]


def call_function(function: str) -> Handler:
    """A handler that calls a function of the arithmetic on the operands' values."""

    def handler(run: Run, at: Instruction, state: PathState) -> Any:
        values = run.values(at.operands)
        exact = _fold(run, function, values) if at.id in run.program.folded else None
        return compute(run, function, values) if exact is None else exact

    return handler


def _fold(run: Run, function: str, values: list[Any]) -> Band | None:
    """What compilers make of exact constants, in float32 or float64, where nothing is rounded."""
    if not all(type(value) is Band and value.lo is value.hi for value in values):
        return None
    found = FLOAT64.call(function, *(value.lo for value in values))
    same = bool((found == found.astype(np.float32)).all())
    return Band.exact(found, values[0].rules) if same else None


def apply(function: Callable[..., Any]) -> Handler:
    """A handler that calls a Python function on the operands' values."""

    def handler(run: Run, at: Instruction, state: PathState) -> Any:
        return function(*run.values(at.operands))

    return handler


_UNITS = 2.0**24  # as many of them as float32 counts exactly
_CONSTANTS = 16  # values at most of what is looked at: a constant's components
WHOLE = frozenset({"floor", "ceil", "trunc", "round", "roundEven", "sign"})
"""Functions whose results are whole numbers."""


def unit_of(run: Run, value: Any) -> float:
    """A power of two that all of a band's values are multiples of, 0 if none is known."""
    if not isinstance(value, Band):
        return 0.0
    known = run.units.get(id(value))
    if known is not None:
        return known[1]
    if value.lo is not value.hi or value.terms is not None or value.lo.size > _CONSTANTS:
        return 0.0
    unit = _unit(value.lo)
    run.note_unit(value, unit)
    return unit


def _unit(values: Any) -> float:
    """The largest power of two that divides all values; 1 if they are 0."""
    if not np.isfinite(values).all():
        return 0.0
    ratios = (float(v).as_integer_ratio() for v in values.flat if v)
    return min((float(n & -n) / d for n, d in ratios), default=1.0)


def compute(run: Run, function: str, values: list[Any]) -> Any:
    """A function of values, exact where all of them have a unit and it can't be rounded."""
    found = run.arithmetic.call(function, *values)
    if run.arithmetic.rules is None:
        return found
    exact = _EXACT.get(function)
    if exact is None:
        if function in WHOLE:
            run.note_unit(found, 1.0)
        return found
    units: list[float] = []
    for value in values:
        units.append(unit_of(run, value))
        if not units[-1]:  # as of most
            return found
    known = exact(*values, *units)
    if known is not None:
        if found.lo is not found.hi:
            found = known[0]
        run.note_unit(found, known[1])
    return found


Found = tuple[Band, float] | None
"""A result and its unit, None where it may be rounded."""


def _add(a: Band, b: Band, of_a: float, of_b: float) -> Found:
    return _make(
        a, b, a.lo + b.lo, a.hi + b.hi, a.abs_sum + b.abs_sum, a.count + b.count, min(of_a, of_b)
    )


def _subtract(a: Band, b: Band, of_a: float, of_b: float) -> Found:
    return _add(a, negate(b), of_a, of_b)


def _multiply(a: Band, b: Band, of_a: float, of_b: float) -> Found:
    bounds = product_bounds(a.lo, a.hi, b.lo, b.hi)
    return _make(a, b, *bounds, a.abs_sum * b.abs_sum, a.count * b.count, of_a * of_b)


def _make(a: Band, b: Band, lo: Any, hi: Any, mag: Any, count: int, unit: float) -> Found:
    """The result of two bands, if none of its terms together are too large to be exact. What is no
    multiple may be added between them later, so each sum's rounding stays pending."""
    if not np.max(mag) < _UNITS * unit:
        return None
    terms = None
    if a.rules.rearrange:
        terms = Terms(mag, (count - 1) * RELATIVE_STEP * mag if count > 1 else None, count)
    return a.derive_exact(lo, hi, b, terms=terms), unit


def _mod(x: Band, y: Band, of_x: float, of_y: float) -> Found:
    """x - y·⌊x/y⌋, whose terms are those of x and one product."""
    turns = glslmath.floor(x.without_terms() / y)
    product = _multiply(y, turns, of_y, 1.0)
    found = _subtract(x, product[0], of_x, product[1]) if product is not None else None
    inside = (y.lo > 0.0).all() or (y.hi < 0.0).all()
    return (found[0].without_terms(), found[1]) if found is not None and inside else None


def _fract(x: Band, unit: float) -> Found:
    found = _subtract(x, apply_monotone(x, np.floor), unit, 1.0)
    return None if found is None else (glslmath.clamp(found[0], 0.0, 1.0), found[1])


_EXACT: Mapping[str, Callable[..., Found]] = {
    "add": _add, "subtract": _subtract, "multiply": _multiply,
    "negate": lambda a, unit: (negate(a), unit), "mod": _mod, "fract": _fract,
}  # fmt: skip


_NOTHING = 0xFFFFFFFF


def _extract(run: Run, at: Instruction, state: PathState) -> Any:
    value = run.value(at.operands[0])
    for index in at.operands[1:]:
        value = run.part(value, index)
    return value


def _insert(run: Run, at: Instruction, state: PathState) -> Any:
    new, whole = run.values(at.operands[:2])
    return replace_part(whole, run.program.types[at.type], at.operands[2:], new, state.mask)


def _insert_dynamic(run: Run, at: Instruction, state: PathState) -> Any:
    vector, new, index = run.values(at.operands)
    type_: Type = run.program.types[at.type]
    return replace_part(vector, type_, [known_index(index)], new, state.mask)


def _shuffle(run: Run, at: Instruction, state: PathState) -> Any:
    first, second = run.values(at.operands[:2])
    size = first.shape[-1]
    picks = [0 if i == _NOTHING else i for i in at.operands[2:]]
    if all(i < size for i in picks):
        return run.cache_part(first, tuple(picks), lambda: first[..., picks])
    parts = [run.part(first, i) if i < size else run.part(second, i - size) for i in picks]
    return compose(run.program.types[at.type], parts)


COMPOSITES: Mapping[int, Handler] = {
    Op.VectorExtractDynamic: lambda run, at, state: fetch(
        run.value(at.operands[0]), [known_index(run.value(at.operands[1]))], state.mask
    ),
    Op.VectorInsertDynamic: _insert_dynamic,
    Op.VectorShuffle: _shuffle,
    Op.CompositeConstruct: lambda run, at, state: compose(
        run.program.types[at.type], run.values(at.operands)
    ),
    Op.CompositeExtract: _extract,
    Op.CompositeInsert: _insert,
    Op.Transpose: call_function("transpose"),
}


def _compare(function: Any) -> Handler:
    def run_comparison(run: Run, at: Instruction, state: PathState) -> Any:
        values: Sequence[Any] = run.values(at.operands)
        if isinstance(run.arithmetic, Numbers):
            values = run.arithmetic.take_given(values)
        return as_tri_bool(function(*values))

    return run_comparison


def _different(a: TriBool, b: TriBool) -> TriBool:
    return (a & ~b) | (~a & b)


_ORDERS = {"LessThan": operator.lt, "GreaterThan": operator.gt,
           "LessThanEqual": operator.le, "GreaterThanEqual": operator.ge}  # fmt: skip
LOGIC: Mapping[int, Handler] = {
    Op.Any: apply(TriBool.any), Op.All: apply(TriBool.all), Op.Select: apply(select),
    Op.IsNan: _compare(glslmath.isnan), Op.IsInf: _compare(glslmath.isinf),
    Op.LogicalEqual: apply(lambda a, b: ~_different(a, b)), Op.LogicalNotEqual: apply(_different),
    Op.LogicalOr: apply(operator.or_), Op.LogicalAnd: apply(operator.and_),
    Op.LogicalNot: apply(operator.invert), Op.FOrdEqual: _compare(operator.eq),
    Op.FOrdNotEqual: _compare(operator.ne), Op.FUnordNotEqual: _compare(operator.ne),
    **{Op[f"FOrd{name}"]: _compare(function) for name, function in _ORDERS.items()},
}  # fmt: skip
"""The comparisons are those that glslang writes: ordered ones, and != that holds for NaN."""


def _from_integer(run: Run, at: Instruction, state: PathState) -> Any:
    whole: Integer = run.value(at.operands[0])
    if run.arithmetic.rules is None:
        return run.arithmetic.rounded(whole.lo)
    band = whole.as_band(run.arithmetic.rules)
    run.note_unit(band, 1.0)
    return band


def _bitcast(run: Run, at: Instruction, state: PathState) -> Any:
    value, to = run.value(at.operands[0]), run.program.types[at.type].base
    if to.kind == "float":
        return run.arithmetic.call("uintBitsToFloat", value.convert(True))
    if isinstance(value, Integer):
        return value.convert(not to.signed)
    return run.arithmetic.call("floatBitsToInt" if to.signed else "floatBitsToUint", value)


_CALLED = {
    Op.ConvertFToU: "uint", Op.ConvertFToS: "int", Op.FNegate: "negate", Op.FAdd: "add",
    Op.FSub: "subtract", Op.FMul: "multiply", Op.FDiv: "divide", Op.FRem: "remainder",
    Op.FMod: "mod", Op.VectorTimesScalar: "multiply", Op.MatrixTimesVector: "mul",
    Op.MatrixTimesMatrix: "matmul", Op.OuterProduct: "outerProduct", Op.Dot: "dot",
}  # fmt: skip
FLOATS: Mapping[int, Handler] = {
    **{op: call_function(name) for op, name in _CALLED.items()},
    Op.ConvertSToF: _from_integer, Op.ConvertUToF: _from_integer, Op.Bitcast: _bitcast,
    Op.VectorTimesMatrix: lambda run, at, state: run.arithmetic.call(
        "mul", run.arithmetic.call("transpose", run.value(at.operands[1])),
        run.value(at.operands[0])),
    Op.MatrixTimesScalar: lambda run, at, state: run.arithmetic.call(
        "multiply", run.value(at.operands[0]), run.value(at.operands[1])[..., None]),
}  # fmt: skip


def derivative(run: Run, function: str, value: Any) -> Any:
    """A derivative of a value by its name in GLSL; of ranges any number, for the other pixels' are
    unknown. Raises FormulaError: the pixels' places are unknown."""
    if run.for_ranges:
        low = np.full(value.shape, 0.0 if function.startswith("fwidth") else -LARGEST)
        return Band.between(low, np.full(value.shape, LARGEST), value.rules)
    if value.shape[0] == 1:
        return run.arithmetic.call("subtract", value, value)
    if run.places is None:
        raise FormulaError(f"{function} without gl_FragCoord of each pixel")
    return run.arithmetic.call(function, value, run.places)


def _derivative(function: str) -> Handler:
    def handler(run: Run, at: Instruction, state: PathState) -> Any:
        return derivative(run, function, run.value(at.operands[0]))

    return handler


DERIVATIVES: Mapping[int, Handler] = {
    Op[f"{opcode}{kind}"]: _derivative(f"{name}{kind}")
    for opcode, name in (("DPdx", "dFdx"), ("DPdy", "dFdy"), ("Fwidth", "fwidth"))
    for kind in ("", "Fine", "Coarse")
}


FUNCTIONS: Mapping[int, str] = {
    **{G[name[0].upper() + name[1:]]: name for name in (
        "round", "roundEven", "trunc", "floor", "ceil", "fract", "radians", "degrees", "sin", "cos",
        "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "pow",
        "exp", "log", "exp2", "log2", "sqrt", "determinant", "step", "fma", "ldexp", "length",
        "distance", "cross", "normalize", "reflect", "refract", "packSnorm4x8", "packUnorm4x8",
        "packSnorm2x16", "packUnorm2x16", "packHalf2x16", "unpackSnorm2x16", "unpackUnorm2x16",
        "unpackHalf2x16", "unpackSnorm4x8", "unpackUnorm4x8",
    )},
    G.FAbs: "abs", G.FSign: "sign", G.Atan2: "atan", G.InverseSqrt: "inversesqrt",
    G.MatrixInverse: "inverse", G.ModfStruct: "modf", G.FMin: "min", G.FMax: "max",
    G.FClamp: "clamp", G.FMix: "mix", G.SmoothStep: "smoothstep", G.FrexpStruct: "frexp",
    G.FaceForward: "faceforward",
}  # fmt: skip
"""Those of floats by number, as GLSL calls them."""
_INTEGERS: Mapping[int, tuple[str, bool | None]] = {
    G.SAbs: ("abs", False), G.SSign: ("sign", False), G.UMin: ("min", True),
    G.SMin: ("min", False), G.UMax: ("max", True), G.SMax: ("max", False),
    G.UClamp: ("clamp", True), G.SClamp: ("clamp", False), G.FindILsb: ("findLSB", None),
    G.FindSMsb: ("findMSB", False), G.FindUMsb: ("findMSB", True),
}  # fmt: skip


def call_extended(run: Run, at: Instruction, state: PathState) -> Any:
    number, operands = at.operands[1], at.operands[2:]
    name = FUNCTIONS.get(number)
    if name is not None:
        return settle_parts(run, compute(run, name, run.values(operands)), state)
    if number in _INTEGERS:
        function, unsigned = _INTEGERS[number]
        values: list[Integer] = run.values(operands)
        if unsigned is not None:
            values = [value.convert(unsigned) for value in values]
        result: Integer = run.arithmetic.call(function, *values)
        return settle(run, result.convert(not run.program.types[at.type].base.signed), state)
    name = G(number).name if number in set(G) else f"instruction {number}"
    raise run.program.not_interpreted(f"GLSL's {name}", at.line)


def settle_parts(run: Run, value: Any, state: PathState) -> Any:
    """The result; integers in it only as far as they concern the invocations that are here."""
    if isinstance(value, tuple):
        return tuple(settle_parts(run, part, state) for part in value)
    if isinstance(value, Integer):
        return settle(run, value, state)
    return value


def call_integers(
    function: Callable[..., Any], *, unsigned: bool | None = None, bits: bool = False
) -> Handler:
    """A handler of a function of integers; `unsigned` is how it reads its operands, None as they
    are. With `bits` the last operands are a field's offset and size, and stay as they are."""

    def handler(run: Run, at: Instruction, state: PathState) -> Any:
        values: list[Integer] = run.values(at.operands)
        if unsigned is not None:
            values = [value.convert(unsigned) for value in values]
        elif not bits and len({value.unsigned for value in values}) > 1:
            values = [value.convert(values[0].unsigned) for value in values]
        result = function(*values)
        if not isinstance(result, tuple):
            result = result.convert(not run.program.types[at.type].base.signed)
        return settle_parts(run, result, state)

    return handler


def settle(run: Run, value: Integer, state: PathState) -> Integer:
    """The integer without what it may be for invocations that are not here: one number, so that
    the value counts as known where it is known for those that are."""
    if run.arithmetic.rules is None:
        rounded: Integer = run.arithmetic.rounded(value)
        return rounded
    if value.known or value.shape[0] != state.mask.size:
        return value
    high = np.where(state.mask[:, None], value.hi, value.lo)
    anything = value.anything & (state.mask[:, None] if value.anything.ndim else True)
    return Integer(
        value.lo,
        None if np.array_equal(high, value.lo) else high,
        unsigned=value.unsigned,
        rules=value.rules,
        anything=anything if anything.any() else np.False_,
    )


_YES, _NO = (TriBool.of([[holds]]) for holds in (True, False))


def _compare_integers(function: Callable[[Any, Any], Any], unsigned: bool | None = None) -> Handler:
    def handler(run: Run, at: Instruction, state: PathState) -> Any:
        a, b = run.values(at.operands)
        kind = a.unsigned if unsigned is None else unsigned
        a, b = a.convert(kind), b.convert(kind)
        if a.lo.size == b.lo.size == 1 and run.arithmetic.rules is None:  # as a loop's counter is
            return _YES if function(a.lo.item(), b.lo.item()) else _NO
        return as_tri_bool(function(a, b))

    return handler


_SIGNLESS: Mapping[int, Callable[..., Any]] = {
    Op.SNegate: operator.neg, Op.IAdd: operator.add, Op.ISub: operator.sub, Op.IMul: operator.mul,
    Op.ShiftLeftLogical: operator.lshift, Op.BitwiseOr: operator.or_, Op.BitwiseXor: operator.xor,
    Op.BitwiseAnd: operator.and_, Op.Not: operator.invert, Op.BitCount: glslmath.bitCount,
    Op.BitReverse: glslmath.bitfieldReverse,
}  # fmt: skip
INTEGERS: Mapping[int, Handler] = {
    **{op: call_integers(function) for op, function in _SIGNLESS.items()},
    Op.UDiv: call_integers(operator.truediv, unsigned=True),
    Op.SDiv: call_integers(operator.truediv, unsigned=False),
    Op.UMod: call_integers(operator.mod, unsigned=True),
    Op.SRem: call_integers(operator.mod, unsigned=False),
    Op.SMod: call_integers(operator.mod, unsigned=False),
    Op.IAddCarry: call_integers(glslmath.uaddCarry, unsigned=True),
    Op.ISubBorrow: call_integers(glslmath.usubBorrow, unsigned=True),
    Op.UMulExtended: call_integers(lambda a, b: glslmath.umulExtended(a, b)[::-1], unsigned=True),
    Op.SMulExtended: call_integers(lambda a, b: glslmath.imulExtended(a, b)[::-1], unsigned=False),
    Op.IEqual: _compare_integers(operator.eq),
    Op.INotEqual: _compare_integers(operator.ne),
    **{
        Op[f"{sign}{name}"]: _compare_integers(function, unsigned=sign == "U")
        for sign in "US"
        for name, function in _ORDERS.items()
    },
    Op.ShiftRightLogical: call_integers(operator.rshift, unsigned=True),
    Op.ShiftRightArithmetic: call_integers(operator.rshift, unsigned=False),
    Op.BitFieldInsert: call_integers(glslmath.bitfieldInsert, bits=True),
    Op.BitFieldSExtract: call_integers(glslmath.bitfieldExtract, bits=True),
    Op.BitFieldUExtract: call_integers(glslmath.bitfieldExtract, bits=True),
}
