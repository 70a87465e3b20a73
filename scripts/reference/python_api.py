"""The Python API: public names with signature and docstring, read from the sources without importing them."""

import ast
from collections.abc import Iterator

from scripts.reference.markdown import cell, code, docstring, plain, table
from scripts.reference.sources import Source, names_of, resolve

LONGEST = 80  # letters of a signature on one line
#: What stands in data classes for machinery alone.
_HIDDEN = {"exit_code"}


def sections(module: str) -> str:
    """A list of a module's public names, and a section for each."""
    found = {name: place for name in names_of(module) if (place := resolve(module, name)) is not None}
    described = {name: section(name, *place) for name, place in sorted(found.items(), key=by_name)}
    links = ", ".join(f"[`{name}`](#{anchor})" for name, anchor in anchors(list(described)).items())
    return "\n\n" + "\n\n".join([links, *described.values()]) + "\n\n"


def anchors(names: list[str]) -> dict[str, str]:
    """The anchors of headings, in their order: of names that differ in capitals alone the later ones get a number."""
    lower = [name.lower() for name in names]
    repeated = [lower[:number].count(each) for number, each in enumerate(lower)]
    return {
        name: each + (f"-{count}" if count else "")
        for name, each, count in zip(names, lower, repeated, strict=True)
    }


def by_name(entry: tuple[str, object]) -> str:
    """Functions and classes in one alphabet."""
    return entry[0].lower()


def section(name: str, here: Source, node: ast.stmt) -> str:
    """The section of one name."""
    parts = [f"## {name}"]
    if isinstance(node, ast.FunctionDef):
        parts += [block([signature(here, node, name)]), docstring(ast.get_docstring(node) or "")]
    elif isinstance(node, ast.ClassDef):
        parts += class_parts(here, node, name)
    else:
        parts += [block([value_of(here, node, name)]), sentence(here.comment(node))]
    return "\n\n".join(part for part in parts if part)


def value_of(here: Source, node: ast.stmt, name: str) -> str:
    """A name with its value, unless that is made by something private."""
    text = here.segment(node)
    return name if text.startswith(f"{name} = _") else text


def sentence(text: str) -> str:
    """A comment as a sentence."""
    return plain(text[:1].upper() + text[1:] + ".") if text else ""


def block(lines: list[str]) -> str:
    """Lines of Python that are looked at, and not run."""
    return "```text\n" + "\n".join(lines) + "\n```"


def class_parts(here: Source, node: ast.ClassDef, name: str) -> Iterator[str]:
    """What a class is, its fields, its methods."""
    bases = ", ".join(here.segment(base) for base in node.bases)
    yield block([f"class {name}({bases})" if bases else f"class {name}"])
    yield docstring(ast.get_docstring(node) or "")
    if rows := list(fields(here, node)):
        yield table(("field", "type", "meaning"), rows)
    methods = [each for each in node.body if isinstance(each, ast.FunctionDef) and is_public(each)]
    if methods:
        last = {each.name: each for each in methods}  # of several that overload each other
        yield "\n".join(listed(here, each) for each in last.values())


def listed(here: Source, method: ast.FunctionDef) -> str:
    """A method as an item of a list."""
    said = plain(first_sentence(method))
    return f"- {code(member(here, method))}" + (f": {said}" if said else "")


def is_public(method: ast.FunctionDef) -> bool:
    """Whether a method is for callers: named without an underscore, or the constructor, and no overload of another."""
    decorators = {each.id for each in method.decorator_list if isinstance(each, ast.Name)}
    return (not method.name.startswith("_") or method.name == "__init__") and "overload" not in decorators


def fields(here: Source, node: ast.ClassDef) -> Iterator[tuple[str, str, str]]:
    """The public fields of a class with their types, defaults and comments."""
    for each in node.body:
        if not isinstance(each, ast.AnnAssign) or not isinstance(each.target, ast.Name):
            continue
        name = each.target.id
        if not name.startswith("_") and name not in _HIDDEN:
            yield code(name), code(field_type(here, each)), cell(plain(here.comment(each)))


def field_type(here: Source, each: ast.AnnAssign) -> str:
    """The type of a field, and its default if that is written as a value."""
    kind = here.segment(each.annotation).strip('"')
    value = here.segment(each.value) if each.value is not None else ""
    return kind if not value or "field(" in value else f"{kind} = {value}"


def member(here: Source, method: ast.FunctionDef) -> str:
    """A method as it is called; a property by its name and type."""
    decorators = {here.segment(each) for each in method.decorator_list}
    if decorators & {"property", "cached_property"}:
        returned = f": {here.segment(method.returns)}" if method.returns is not None else ""
        return method.name + returned
    return " ".join(signature(here, method, method.name).split()).replace("( ", "(").replace(", )", ")")


def signature(here: Source, function: ast.FunctionDef, name: str) -> str:
    """The name, the parameters as they stand in the source, and what is returned."""
    given = function.args
    parts = []
    positional = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(positional) - len(given.defaults)) + [*given.defaults]
    for each, default in zip(positional, defaults, strict=True):
        if each.arg not in ("self", "cls"):
            parts.append(parameter(here, each, default))
    if given.vararg is not None:
        parts.append(f"*{parameter(here, given.vararg, None)}")
    elif given.kwonlyargs:
        parts.append("*")
    parts += [
        parameter(here, each, default) for each, default in zip(given.kwonlyargs, given.kw_defaults, strict=True)
    ]
    if given.kwarg is not None:
        parts.append(f"**{parameter(here, given.kwarg, None)}")
    returned = f" -> {here.segment(function.returns)}" if function.returns is not None else ""
    line = f"{name}({', '.join(parts)}){returned}"
    if len(line) <= LONGEST or not parts:
        return line
    inner = "".join(f"\n    {part}," for part in parts)
    return f"{name}({inner}\n){returned}"


def parameter(here: Source, argument: ast.arg, default: ast.expr | None) -> str:
    """One parameter with its type and default."""
    text = here.segment(argument)
    return text if default is None else f"{text} = {here.segment(default)}"


def first_sentence(method: ast.FunctionDef) -> str:
    """The first line of a method's docstring."""
    return (ast.get_docstring(method) or "").split("\n")[0]
