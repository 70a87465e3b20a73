"""The kinds of constraints between features, from the table by which files are checked."""

from kabo.language.constraint_kinds import CONSTRAINT_KINDS, ConstraintKind
from scripts.reference.markdown import code, table


def table_of() -> list[tuple[str, str, str]]:
    """Of each kind its name, what it relates, and what its bound is about."""
    return [(code(name), shapes(kind), bound(kind)) for name, kind in CONSTRAINT_KINDS.items()]


def shapes(kind: ConstraintKind) -> str:
    """The pairs of shapes that a kind relates."""
    if not kind.shapes:
        return "a body and a region"
    order = ("point", "line", "plane")
    pairs = sorted(kind.shapes, key=lambda pair: tuple(map(order.index, pair)))
    text = ", ".join(f"{first}–{second}" for first, second in pairs)
    return text + (" (the point first)" if kind.point_first else "")


def bound(kind: ConstraintKind) -> str:
    """What the bound of a kind is about, in which unit; empty if it takes none."""
    if kind.quantity is None:
        return ""
    unit = {"m": "m", "rad": "rad, or degrees with `deg`"}[kind.quantity.unit]
    return f"`= x`, `<= x`, `>= x` or `in [x, y]`, in {unit}"


def section() -> str:
    """The table of all kinds."""
    return "\n\n" + table(("constraint", "between", "bound"), table_of()) + "\n\n"
