"""Calls of procedures: those of geometry, and the external ones that a domain declares."""

from collections.abc import Sequence

import lark

from kabo.language import formulas as f
from kabo.language.task_description import Property, spell_signature
from kabo.language.vocabulary import TEST, Symbol, term_of
from kabo.language.yaml.syntax import Tree
from kabo.language.yaml.terms import Context, read_arguments

TRUTH = ("true", "false")
_FORMS = {"name": "a name", "number": "a number", "boolean": "true or false"}


def read_test(context: Context, tree: Tree, symbol: Symbol) -> f.External | None:
    """A call of an external procedure inside a formula, where only tests stand by themselves."""
    name = tree.children[0]
    if symbol.kind != TEST:
        hint = f"compare it: K({context.text(tree)} = …)"
        context.report(name, f'the procedure "{name}" has a value: it is no test', hint)
        return None
    arguments = read_arguments(context, tree, symbol)
    return None if arguments is None else f.External(str(name), arguments, context.parsed.place(tree))


def read_call(context: Context, tree: Tree) -> f.ProcedureCall | None:
    """A call as `geometry:` has it: the procedure's name, and arguments that it has room for."""
    name = tree.children[0]
    symbol = context.scope.find(str(name))
    if symbol is not None and symbol.role == "procedure":
        return _external_call(context, tree, symbol)
    arguments = [_argument(context, piece) for piece in tree.children[1:]]
    if str(name) not in context.procedures:
        hint = context.findings.near(str(name), list(context.procedures))
        hint = hint or f"the procedures are {', '.join(context.procedures)}"
        context.report(name, f'unknown procedure "{name}" {context.where}', hint)
        return None
    properties = context.procedures[str(name)]
    if properties is None:
        return None  # its file is broken, which was reported
    if None in arguments:
        return None
    given = [argument for argument in arguments if argument is not None]
    if not _check_properties(context, tree, properties, given):
        return None
    return f.ProcedureCall(str(name), tuple(given), context.parsed.place(tree))


def _external_call(context: Context, tree: Tree, symbol: Symbol) -> f.ProcedureCall | None:
    """A declared test in the place of a procedure of geometry."""
    name = tree.children[0]
    if symbol.kind != TEST:
        context.report(name, f'the procedure "{name}" has a value: `geometry` takes what succeeds or fails')
        return None
    named = next((piece for piece in tree.children[1:] if len(piece.children) == 2), None)
    if named is not None:
        context.report(named, f'the arguments of "{name}" stand by position')
        return None
    given = [_argument(context, piece) for piece in tree.children[1:]]
    terms = [lark.Tree(_kind(each), each.children, each.meta) for each in tree.children[1:]]
    arguments = read_arguments(context, lark.Tree("term", [name, *terms], tree.meta), symbol)
    if arguments is None or None in given:
        return None
    return f.ProcedureCall(str(name), tuple(each for each in given if each), context.parsed.place(tree))


def _kind(argument: Tree) -> str:
    """How a term of a formula would be called here."""
    return "number" if getattr(argument.children[0], "type", "NAME") == "NUMBER" else "term"


def _argument(context: Context, tree: Tree) -> f.Argument | None:
    place = context.parsed.place(tree)
    if tree.data in ("term", "number") and len(tree.children) == 1:  # in a test inside a formula
        tree = lark.Tree("argument", list(tree.children), tree.meta)
    if tree.data != "argument":
        context.report(tree, "an argument of a procedure is a parameter, a name or a number")
        return None
    value = tree.children[-1]
    named = str(tree.children[0]) if len(tree.children) == 2 else None
    if isinstance(value, lark.Tree):
        truth = "true" if value.data == "yes" else "false"
        return f.Argument(f.Constant(truth, context.parsed.place(value)), named, place)
    if value.type == "NUMBER":
        return f.Argument(f.Number(float(str(value)), context.parsed.place(value)), named, place)
    symbol = context.scope.find(str(value))
    if symbol is not None and symbol.role in ("predicate", "function", "procedure") and named is None:
        context.report(value, f'"{value}" is {symbol.description}, and no argument of a procedure')
        return None
    if symbol is not None and symbol.role == "run-time variable":
        context.report(value, f'the run-time variable "{value}" has no value yet and may not stand in `geometry`')
        return None
    if symbol is None or symbol.role in ("predicate", "function", "procedure"):
        return f.Argument(f.Constant(str(value), context.parsed.place(value)), named, place)
    term = term_of(symbol, context.parsed.place(value))
    return f.Argument(term, named, place)


def _check_properties(
    context: Context, tree: Tree, properties: Sequence[Property], given: Sequence[f.Argument]
) -> bool:
    signature = spell_signature(str(tree.children[0]), tuple(properties))
    positional = [argument for argument in given if argument.name is None]
    filled = [each.name for each in properties[: len(positional)]]
    by_name = {each.name: each for each in properties}
    for number, (argument, piece) in enumerate(zip(given, tree.children[1:], strict=True)):
        if argument.name is None:
            if number >= len(positional):
                context.report(piece, "arguments by position stand before those by name")
                return False
            wanted: Property | None = properties[number] if number < len(properties) else None
        else:
            wanted = by_name.get(argument.name)
            if wanted is None:
                hint = context.findings.near(argument.name, by_name) or f"it is {signature}"
                context.report(piece, f'{tree.children[0]} has no property "{argument.name}"', hint)
                return False
            if argument.name in filled:
                context.report(piece, f'"{argument.name}" is given twice')
                return False
            filled.append(argument.name)
        if wanted is not None and not _fits(context, piece, wanted, argument):
            return False
    missing = [each.name for each in properties if each.required and each.name not in filled]
    if missing or len(positional) > len(properties):
        problem = f'lacks "{missing[0]}"' if missing else f"takes at most {len(properties)} arguments"
        context.report(tree.children[0], f"{tree.children[0]} {problem}", f"it is {signature}")
        return False
    return True


def _fits(context: Context, piece: Tree, wanted: Property, argument: f.Argument) -> bool:
    """Whether an argument may fill a property, as far as its form tells; reports if not."""
    given = "name"
    if isinstance(argument.value, f.Number):
        given = "number"
    elif isinstance(argument.value, f.Constant) and argument.value.name in TRUTH:
        given = "boolean"
    takes = wanted.kind if wanted.kind in _FORMS else "name"
    if wanted.kind == "any" or given == takes:
        return True
    context.report(piece, f'the property "{wanted.name}" takes {_FORMS[takes]}, not {_FORMS[given]}')
    return False
