"""The kinds of mistakes in GLSL: generators over one node of the syntax tree, and their list.

A generator may propose what does not compile: a compiler tells faster and better than types worked
out here.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise

from tree_sitter import Node

from shaderlab.compiler.syntax import Syntax, arguments_of, field, name_of, operator_of, walk
from shaderlab.mutation.names import Change, Names, Operator

_ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*"}
_ASSIGNMENT = {"+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}
_COMPARISON = {
    "<": ("<=", ">"),
    "<=": ("<", ">"),
    ">": (">=", "<"),
    ">=": (">", "<"),
    "==": ("!=",),
    "!=": ("==",),
}
_LOGIC = {"&&": "||", "||": "&&", "^^": "||"}
_BITS = {"&": "|", "|": "&", "^": "&", "<<": ">>", ">>": "<<"}
_NOT_COMMUTATIVE = ("-", "/", "%", "<<", ">>")
_SLIP = 0.01
# What is left when the call is forgotten: which arguments may stand in its place.
_DROPPABLE = {
    "max": (0, 1), "min": (0, 1), "clamp": (0,), "normalize": (0,), "abs": (0,), "sqrt": (0,),
    "floor": (0,), "ceil": (0,), "fract": (0,), "pow": (0,), "exp": (0,), "radians": (0,),
    "inverse": (0,), "transpose": (0,), "mix": (0, 1), "mod": (0,), "reflect": (0,),
}  # fmt: skip
_SYMMETRIC = ("max", "min", "dot", "distance", "equal", "notEqual")
_SIBLINGS = {
    "max": "min", "min": "max", "sin": "cos", "cos": "sin", "asin": "acos", "acos": "asin",
    "floor": "ceil", "ceil": "floor", "exp": "exp2", "exp2": "exp", "log": "log2", "log2": "log",
    "sqrt": "inversesqrt", "inversesqrt": "sqrt", "dFdx": "dFdy", "dFdy": "dFdx",
    "lessThan": "greaterThan", "greaterThan": "lessThan", "any": "all", "all": "any",
}  # fmt: skip
_ACCESS = ("field_expression", "subscript_expression")
_TIGHT = ("call_expression", *_ACCESS, "parenthesized_expression")
_MOST_NAMES = 3  # of many like variables, the ones declared nearest are mixed up
_SETS = ("xyzw", "rgba", "stpq")
_REMOVABLE = ("expression_statement", "if_statement", "for_statement", "while_statement",
              "return_statement", "break_statement", "continue_statement")  # fmt: skip
_SHOWN = ("binary_expression", "assignment_expression", "init_declarator", "return_statement")
_BUILT_IN = {"gl_FragColor": "vec4", "gl_FragDepth": "float", "gl_PointSize": "float"}
_HALF = {"float": "*= 0.5", "vec": "*= 0.5", "mat": "*= 0.5", "int": "/= 2", "ivec": "/= 2",
         "uint": "/= 2u", "uvec": "/= 2u"}  # fmt: skip
_SECOND_PIXEL = "(int(gl_FragCoord.x) + int(gl_FragCoord.y)) % 2 == 1"


def change_operator(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Another arithmetic, comparison, logic or bit operator, or another compound assignment."""
    if node.type not in ("binary_expression", "assignment_expression"):
        return
    sign = operator_of(node)
    word = file.of(sign)
    for table in (_ARITHMETIC, _LOGIC, _BITS, _ASSIGNMENT):
        if word in table:
            yield "operator", node, sign, table[word]
    for other in _COMPARISON.get(word, ()):
        yield "comparison", node, sign, other


def swap_operands(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """`a − b` the wrong way round; products too where a matrix is in them."""
    if node.type != "binary_expression":
        return
    word = file.of(operator_of(node))
    left, right = field(node, "left"), field(node, "right")
    inside = [file.of(n) for n in walk(node) if n.type == "identifier"]
    matrices = word == "*" and names.has_matrix(inside, node.start_byte)
    if word in _NOT_COMMUTATIVE or matrices:
        yield "operands swapped", node, node, f"{file.of(right)} {word} {_parenthesise(file, left)}"


def drop_sign(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A sign or a `!` forgotten, `++` for `--`."""
    if node.type == "unary_expression":
        word = file.of(operator_of(node))
        if word in "-!~":
            kind = "minus dropped" if word == "-" else "negation dropped"
            yield kind, node, node, file.of(field(node, "argument"))
    elif node.type == "update_expression":
        sign = operator_of(node)
        yield "operator", node, sign, "--" if file.of(sign) == "++" else "++"


def change_constant(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A number that is off by 1 %, or by one if it is an integer; 0 for 1 and 1 for 0."""
    if node.type != "number_literal":
        return
    text = file.of(node)
    around = node.parent if node.parent is not None else node
    shown = around if around.type in ("binary_expression", "argument_list") else node
    if around.type == "argument_list" and around.parent is not None:
        shown = around.parent
    try:
        value = int(text, 0)
    except ValueError:
        pass
    else:
        for other in (value + 1, value - 1):
            yield "integer ± 1", shown, node, str(other)
        return
    suffix = text[-1] if text[-1] in "fF" else ""
    try:
        number = float(text.rstrip("fF"))
    except ValueError:
        return  # a double's suffix, or no number after all
    if number == 0.0:
        yield "constant 0 → 1", shown, node, "1.0" + suffix
        yield "constant + 0.01", shown, node, "0.01" + suffix
        return
    yield "constant + 1 %", shown, node, _literal(number * (1.0 + _SLIP)) + suffix
    yield "constant − 1 %", shown, node, _literal(number * (1.0 - _SLIP)) + suffix
    if number == 1.0:
        yield "constant 1 → 0", shown, node, "0.0" + suffix


def _literal(number: float) -> str:
    """A GLSL float literal with nine digits.

    >>> _literal(0.505), _literal(101.0), _literal(1.01e-6)
    ('0.505', '101.0', '1.01e-06')
    """
    text = f"{number:.9g}"
    return text if any(c in text for c in ".e") else text + ".0"


def _parenthesise(file: Syntax, node: Node) -> str:
    """A node's text in parentheses where it would fall apart on the right of an operator."""
    text = file.of(node)
    return f"({text})" if node.type in ("binary_expression", "conditional_expression") else text


def drop_call(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """`max(x, 0.0)` where only `x` was written, and the like."""
    if node.type != "call_expression":
        return
    name = file.of(field(node, "function"))
    arguments = arguments_of(node)
    for index in _DROPPABLE.get(name, ()):
        if index < len(arguments):
            text = file.of(arguments[index])
            simple = "expression" not in arguments[index].type
            kept = text if simple or arguments[index].type in _TIGHT else f"({text})"
            yield f"{name} dropped", node, node, kept


def swap_arguments(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    if node.type != "call_expression":
        return
    name = file.of(field(node, "function"))
    if name in _SYMMETRIC:
        return
    arguments = arguments_of(node)
    for index, (first, second) in enumerate(pairwise(arguments)):
        one, two = file.of(first), file.of(second)
        texts = [file.of(a) for a in arguments]
        texts[index], texts[index + 1] = two, one
        yield "arguments swapped", node, node, f"{name}({', '.join(texts)})"


def call_sibling(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """The function's sibling: `cos` for `sin`, `min` for `max`."""
    if node.type != "call_expression":
        return
    function = field(node, "function")
    other = _SIBLINGS.get(file.of(function))
    if other is not None:
        yield "function", node, function, other


def swap_variable(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Another variable of the same type where one is read."""
    if node.type != "identifier" or not _is_read(node):
        return
    for other in names.of_same_type(file.of(node), node.start_byte)[:_MOST_NAMES]:
        yield "variable", _around(node), node, other


def swap_member(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    if node.type != "field_expression":
        return
    name = field(node, "field")
    for other in names.siblings(file.of(name))[:_MOST_NAMES]:
        yield "member", _around(node), name, other


def change_swizzle(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """One component of a swizzle changed into its neighbour, or two of them exchanged."""
    if node.type != "field_expression":
        return
    name = field(node, "field")
    word = file.of(name)
    letters = next((s for s in _SETS if set(word) <= set(s)), None)
    if letters is None or len(word) > 4 or names.siblings(word):
        return
    for index, letter in enumerate(word):
        place = letters.index(letter)
        # x ↔ y, z → y, w → z: never a component that the vector may lack.
        other = letters[place - 1] if place else letters[1]
        yield "swizzle", _around(node), name, word[:index] + other + word[index + 1 :]
    for index in range(len(word) - 1):
        pair = word[index + 1] + word[index]
        yield "swizzle", _around(node), name, word[:index] + pair + word[index + 2 :]


def _is_read(node: Node) -> bool:
    """Whether an identifier's value is used: not declared, called, assigned or a member's name."""
    around = node.parent
    if around is None or around.type in ("expression_statement", "qualifier"):
        return False
    if around.type == "init_declarator":
        return around.child_by_field_name("value") == node
    if around.type.endswith(("declaration", "declarator")):
        return False
    if around.type == "call_expression":
        return around.child_by_field_name("function") != node
    if around.type == "assignment_expression":
        return around.child_by_field_name("left") != node
    if around.type in _ACCESS:
        return not _is_assigned(around)
    return True


def _is_assigned(node: Node) -> bool:
    around = node.parent
    if around is None:
        return False
    if around.type in _ACCESS:
        return _is_assigned(around)
    return around.type == "assignment_expression" and around.child_by_field_name("left") == node


def _around(node: Node) -> Node:
    """What to show of a name: the expression around it, up to a call or an operator."""
    shown = node
    while shown.parent is not None and shown.parent.type in (*_ACCESS, "unary_expression"):
        shown = shown.parent
    around = shown.parent
    if around is not None and around.type == "argument_list" and around.parent is not None:
        return around.parent
    return around if around is not None and around.type in _SHOWN else shown


def remove_statement(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A statement that is not there: an assignment, a whole `if` or loop, an early `return`."""
    if node.type not in _REMOVABLE:
        return
    # A lone `;` keeps the grammar happy where the statement is a branch's only one.
    yield "statement removed", node, node, ";"
    if node.type == "if_statement":
        other = node.child_by_field_name("alternative")
        if other is not None:
            yield "else removed", node, other, ""


def fix_condition(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A branch that is always taken, or never."""
    if node.type == "if_statement":
        tested = field(node, "condition")
        for word in ("(true)", "(false)"):
            yield "condition", tested, tested, word
    elif node.type == "conditional_expression":
        tested = field(node, "condition")
        for word in ("true", "false"):
            yield "condition", node, tested, word


def swap_branches(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """The two values of a `? :` in each other's place."""
    if node.type != "conditional_expression":
        return
    parts = (field(node, name) for name in ("condition", "consequence", "alternative"))
    tested, first, second = (file.of(part) for part in parts)
    yield "branches swapped", node, node, f"{tested} ? {second} : {first}"


def discard_pixels(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """Every second pixel thrown away, or those where an output of floats is above 0.25."""
    end = _end_of_main(node, file)
    if end is None or file.stage != "fragment":
        return
    yield "every second pixel discarded", end, end, f"if ({_SECOND_PIXEL}) discard; }}"
    for name, kind in _outputs(file, names).items():
        if kind in ("float", "vec2", "vec3", "vec4"):
            first = name if kind == "float" else f"{name}.x"
            yield "bright pixels discarded", end, end, f"if ({first} > 0.25) discard; }}"


def return_early(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """A `return` at the top of `main`, or before its last statement where leaving that out alone
    is not a mutant itself."""
    end = _end_of_main(node, file)
    if end is None or end.parent is None:
        return
    first, *statements = (n for n in end.parent.children[:-1] if n.type != "comment")
    if statements:
        yield "early return", first, first, "{ return;"
        if statements[-1].type not in _REMOVABLE:
            last = statements[-1]
            yield "early return", last, last, f"return; {file.of(last)}"


def halve_outputs(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    end = _end_of_main(node, file)
    if end is not None:
        for name, kind in _outputs(file, names).items():
            half = _HALF.get(kind.rstrip("234x"))
            if half is not None:
                yield "output halved", end, end, f"{name} {half}; }}"


def shadow_outputs(node: Node, file: Syntax, names: Names) -> Iterator[Change]:
    """An output that is never written: `main` writes to a local variable of the same name.

    Where there is one assignment only, that is a statement removed; where another function writes
    it too, none is made.
    """
    end = _end_of_main(node, file)
    if end is None or end.parent is None:
        return
    written = [_root(n, file) for n in walk(file.root) if n.type == "assignment_expression"]
    inside = [_root(n, file) for n in walk(end.parent) if n.type == "assignment_expression"]
    for name, kind in names.outputs.items():
        if "[" not in kind and 1 < written.count(name) == inside.count(name):
            first = end.parent.children[0]
            yield "output never written", first, first, f"{{ {kind} {name};"


def _end_of_main(node: Node, file: Syntax) -> Node | None:
    """The closing brace of `main`, where `node` is its definition in a stage that ends there."""
    if file.stage not in ("vertex", "fragment") or node.type != "function_definition":
        return None
    return field(node, "body").children[-1] if file.of(name_of(node)) == "main" else None


def _outputs(file: Syntax, names: Names) -> Mapping[str, str]:
    """The outputs, and the built-in ones that are assigned: type by name."""
    written = {_root(n, file) for n in walk(file.root) if n.type == "assignment_expression"}
    return {**names.outputs, **{n: kind for n, kind in _BUILT_IN.items() if n in written}}


def _root(assignment: Node, file: Syntax) -> str:
    """The variable that an assignment writes: `color` of `color.rgb = …`."""
    target = field(assignment, "left")
    while target.type in _ACCESS:
        target = target.children[0]
    return file.of(target)


OUTPUT_OPERATORS: tuple[Operator, ...] = (
    discard_pixels,
    return_early,
    halve_outputs,
    shadow_outputs,
)

OPERATORS: tuple[Operator, ...] = (
    change_operator,
    swap_operands,
    drop_sign,
    change_constant,
    drop_call,
    swap_arguments,
    call_sibling,
    swap_variable,
    swap_member,
    change_swizzle,
    remove_statement,
    fix_condition,
    swap_branches,
    *OUTPUT_OPERATORS,
)
"""Every kind of mistake."""
