"""The messages of the service, from kabo/service/messages.py."""

import ast

from scripts.reference.markdown import code, docstring, plain, table
from scripts.reference.sources import Source, module_path, source

MODULE = "kabo.service.messages"


def sections() -> str:
    """A section for each message, and the codes of errors."""
    here = source(module_path(MODULE))
    messages = [node for node in here.tree.body if isinstance(node, ast.ClassDef) and is_message(here, node)]
    return "\n\n" + "\n\n".join(section(here, each) for each in messages) + "\n\n"


def is_message(here: Source, node: ast.ClassDef) -> bool:
    """Whether a class is a message; the envelope is what the server reads of a request before a worker does."""
    return any(here.segment(base) == "msgspec.Struct" for base in node.bases) and node.name != "Envelope"


def section(here: Source, node: ast.ClassDef) -> str:
    """The section of one message."""
    fields = [each for each in node.body if isinstance(each, ast.AnnAssign)]
    rows = [
        (code(here.segment(each.target)), code(here.segment(each.annotation)), default(here, each))
        for each in fields
    ]
    said = docstring(ast.get_docstring(node) or "")
    return "\n\n".join([f"### {node.name}", said, table(("field", "type", "default"), rows)])


def default(here: Source, field: ast.AnnAssign) -> str:
    """The default of a field: numbers that have a name are looked up."""
    if field.value is None:
        return "must be given"
    if isinstance(field.value, ast.Name) and isinstance(found := here.find(field.value.id), ast.Assign):
        return code(here.segment(found.value))
    return plain(code(here.segment(field.value)))
