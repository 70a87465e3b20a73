"""Reads calls of procedures: geometric procedures, and the external procedures that a domain declares."""

from collections.abc import Sequence

from kabo.language import formulas as f
from kabo.language.expressions import Expression
from kabo.language.resolver import NameResolver
from kabo.language.task_description import ProcedureProperty, spell_signature
from kabo.language.types import TEST
from kabo.language.vocabulary import Symbol

TRUTH_VALUES = ("true", "false")
_FORMS = {"name": "a name", "number": "a number", "boolean": "true or false"}


def read_test(here: NameResolver, node: Expression, symbol: Symbol) -> f.External | None:
    """A call of an external test inside a formula; a procedure that returns a value is reported as an error."""
    if symbol.kind != TEST:
        hint = f"compare it: K({here.quote(node)} = …)"
        here.report(node.name, f'the procedure "{node.text}" has a value: it is no test', hint)
        return None
    arguments = here.arguments(node, symbol)
    return None if arguments is None else f.External(node.text, arguments, here.place(node))


def read_call(here: NameResolver, node: Expression) -> f.ProcedureCall | None:
    """The procedure call under the key `geometry:`, its arguments checked against the procedure's signature."""
    name, procedures = node.text, here.vocabulary.procedures
    symbol = here.find(name)
    if symbol is not None and symbol.role == "procedure":
        return _external_call(here, node, symbol)
    arguments = [_argument(here, piece) for piece in node.parts]
    if name not in procedures:
        hint = here.findings.near(name, list(procedures)) or f"the procedures are {', '.join(procedures)}"
        here.report(node.name, f'unknown procedure "{name}" {here.where}', hint)
        return None
    properties = procedures[name]
    if properties is None:
        return None  # its file is broken, which was reported
    given = [argument for argument in arguments if argument is not None]
    if len(given) < len(arguments) or not _check_properties(here, node, properties, given):
        return None
    return f.ProcedureCall(name, tuple(given), here.place(node))


def _external_call(here: NameResolver, node: Expression, symbol: Symbol) -> f.ProcedureCall | None:
    """A declared test in the place of a procedure of geometry."""
    name = node.text
    if symbol.kind != TEST:
        here.report(node.name, f'the procedure "{name}" has a value: `geometry` takes what succeeds or fails')
        return None
    named = next((piece for piece in node.parts if piece.text), None)
    if named is not None:
        here.report(named, f'the arguments of "{name}" stand by position')
        return None
    given = [_argument(here, piece) for piece in node.parts]
    applied = Expression("call", name, node.start, node.end, [piece.parts[0] for piece in node.parts])
    if here.arguments(applied, symbol) is None or None in given:
        return None
    return f.ProcedureCall(name, tuple(each for each in given if each), here.place(node))


def _argument(here: NameResolver, node: Expression) -> f.Argument | None:
    if node.kind not in ("argument", "name", "number"):  # in a test inside a formula there are other terms
        here.report(node, "an argument of a procedure is a parameter, a name or a number")
        return None
    place, named = here.place(node), None
    value = node
    if node.kind == "argument":
        named, value = node.text or None, node.parts[0]
    at = here.place(value)
    if value.kind in ("yes", "no"):
        return f.Argument(f.Constant("true" if value.kind == "yes" else "false", at), named, place)
    if value.kind == "number":
        return f.Argument(f.Number(float(value.text), at), named, place)
    symbol = here.find(value.text)
    declared = symbol is not None and symbol.role in ("predicate", "function", "procedure")
    if symbol is not None and declared and named is None:
        here.report(value, f'"{value.text}" is {symbol.description}, and no argument of a procedure')
        return None
    if symbol is not None and symbol.role == "run-time variable":
        message = f'the run-time variable "{value.text}" has no value yet and may not stand in `geometry`'
        here.report(value, message)
        return None
    if symbol is None or declared:
        return f.Argument(f.Constant(value.text, at), named, place)
    return f.Argument(symbol.term(at), named, place)


def _check_properties(
    here: NameResolver, node: Expression, properties: Sequence[ProcedureProperty], given: Sequence[f.Argument]
) -> bool:
    signature = spell_signature(node.text, tuple(properties))
    positional = [argument for argument in given if argument.name is None]
    filled = [each.name for each in properties[: len(positional)]]
    by_name = {each.name: each for each in properties}
    for number, (argument, piece) in enumerate(zip(given, node.parts, strict=True)):
        if argument.name is None:
            if number >= len(positional):
                here.report(piece, "arguments by position stand before those by name")
                return False
            wanted: ProcedureProperty | None = properties[number] if number < len(properties) else None
        else:
            wanted = by_name.get(argument.name)
            if wanted is None:
                hint = here.findings.near(argument.name, by_name) or f"it is {signature}"
                here.report(piece, f'{node.text} has no property "{argument.name}"', hint)
                return False
            if argument.name in filled:
                here.report(piece, f'"{argument.name}" is given twice')
                return False
            filled.append(argument.name)
        if wanted is not None and not _fits(here, piece, wanted, argument):
            return False
    missing = [each.name for each in properties if each.required and each.name not in filled]
    if missing or len(positional) > len(properties):
        problem = f'lacks "{missing[0]}"' if missing else f"takes at most {len(properties)} arguments"
        here.report(node.name, f"{node.text} {problem}", f"it is {signature}")
        return False
    return True


def _fits(here: NameResolver, piece: Expression, wanted: ProcedureProperty, argument: f.Argument) -> bool:
    """Whether the form of an argument (name, number, truth value) fits a property; reports if not."""
    given = "name"
    if isinstance(argument.value, f.Number):
        given = "number"
    elif isinstance(argument.value, f.Constant) and argument.value.name in TRUTH_VALUES:
        given = "boolean"
    takes = wanted.kind if wanted.kind in _FORMS else "name"
    if wanted.kind == "any" or given == takes:
        return True
    here.report(piece, f'the property "{wanted.name}" takes {_FORMS[takes]}, not {_FORMS[given]}')
    return False
