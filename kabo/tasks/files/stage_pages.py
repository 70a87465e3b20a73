"""Reference pages of stages and their properties for authors of task files, generated from the classes."""

from typing import Any, TypedDict

from kabo.tasks.core import MISSING, Monitor, Reference, Stage
from kabo.tasks.files.checking import declared_by
from kabo.tasks.files.reports import plain
from kabo.tasks.files.values import wanted


class PropertyPage(TypedDict):
    """A property: its type, its default as text (None if a value is required), and its purpose."""

    type: str
    default: str | None
    doc: str


class StagePage(TypedDict):
    """A stage: its purpose in one line and in full, and its properties."""

    does: str
    doc: str
    monitors: bool
    properties: dict[str, PropertyPage]


def stage_page(kind: type[Stage]) -> StagePage:
    """The page of a stage class."""
    doc = (kind.__doc__ or "").strip()
    lines = [line.strip() for line in doc.splitlines()]
    return {
        "does": lines[0] if lines else "",
        "doc": "\n".join(lines),
        "monitors": issubclass(kind, Monitor),
        "properties": {
            name: {"type": wanted(each), "default": _default(each.default), "doc": each.doc}
            for name, each in declared_by(kind).items()
        },
    }


def _default(value: Any) -> str | None:
    if value is MISSING:
        return None
    if isinstance(value, Reference):
        return str(value)
    return "none" if value is None else f'"{value}"' if isinstance(value, str) else str(plain(value))


def describe_stage(name: str, page: StagePage) -> str:
    """A stage's page as text."""
    lines = [name, *(f"  {line}" if line else "" for line in page["doc"].splitlines())]
    if page["monitors"]:
        lines += ["", "  monitors: the path of the stage whose successes trigger it"]
    for key, each in page["properties"].items():
        default = "must be given" if each["default"] is None else f"default {each['default']}"
        lines += ["", f"  {key}: {each['type']}, {default}"]
        if each["doc"]:
            lines.append(f"      {each['doc']}")
    return "\n".join(lines)
