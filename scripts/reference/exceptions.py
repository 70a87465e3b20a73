"""Errors and exit codes, from kabo/errors.py and kabo/cli/exit_codes.py."""

import ast
import inspect
from pathlib import Path

from kabo import errors
from kabo.cli import exit_codes as codes
from scripts.reference.markdown import code, docstring, table
from scripts.reference.sources import source

PATH = Path(errors.__file__)

#: What each exit code means to who called the command; one without a meaning stops the script.
MEANINGS = {
    "DONE": "done",
    "DEFECT": "a defect of kabo",
    "BAD_INPUT": "bad input; every finding with its place",
    "PROVEN_NO_PLAN": "proven: there is no plan, even if every procedure succeeded, or because every refusal is a proof",
    "NO_PLAN": "no plan for another reason: a budget or a limit was reached, or kabo cannot decide",
    "VERIFICATION_FAILED": "verification failed",
    "SERVICE": "no server in time, a busy one, cancelled, worker lost",
    "STOPPED": "`execute` stopped before a goal; the text says why",
    "INTERRUPTED": "interrupted",
}


def sections() -> str:
    """The tree of error classes, then a section for each, and the diagnostic that they carry."""
    classes = [
        each for each in vars(errors).values() if inspect.isclass(each) and each.__module__ == errors.__name__
    ]
    raised = [each for each in classes if issubclass(each, Exception)]
    tree = "```text\n" + "\n".join(branch(errors.KaboError, raised, 0)) + "\n```"
    others = [each for each in classes if each not in raised]
    return "\n\n" + "\n\n".join([tree, *(section(each) for each in [*raised, *others])]) + "\n\n"


def branch(kind: type, raised: list[type], depth: int) -> list[str]:
    """A class and those that inherit from it, as lines of a tree."""
    exit_code = f"exit code {getattr(kind, 'exit_code', '')}"
    lines = [f"{'  ' * depth}{kind.__name__:<{20 - 2 * depth}}{exit_code}"]
    for each in raised:
        if kind in each.__bases__:
            lines += branch(each, raised, depth + 1)
    return lines


def section(kind: type) -> str:
    """The section of one class: what it means, and what it carries."""
    here = source(PATH)
    node = here.find(kind.__name__)
    assert isinstance(node, ast.ClassDef)
    parts = [f"### {kind.__name__}", docstring(inspect.getdoc(kind) or "")]
    fields = [each for each in node.body if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)]
    if fields:
        rows = [
            (code(here.segment(each.target)), code(here.segment(each.annotation)), here.comment(each))
            for each in fields
        ]
        parts.append(table(("field", "type", "meaning"), rows))
    return "\n\n".join(parts)


def exit_codes() -> str:
    """The exit codes with the statuses and error codes that lead to them."""
    named = {name: number for name, number in vars(codes).items() if name.isupper() and isinstance(number, int)}
    rows = []
    for name, number in named.items():
        leads = [
            each
            for known in (codes.BY_STATUS, codes.BY_CODE)
            for each, leads_to in known.items()
            if leads_to == number
        ]
        rows.append((str(number), MEANINGS[name], ", ".join(code(each) for each in leads)))
    return "\n\n" + table(("exit code", "means", "status of a result, or code of an error"), rows) + "\n\n"
