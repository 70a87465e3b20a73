"""The stages that task files may name, with their properties, as `kabo task stages` shows them."""

from kabo.tasks import Connector, Generator, Monitor, Propagator, Stage, Wrapper
from kabo.tasks.files import registry
from kabo.tasks.files.stage_pages import stage_page
from scripts.reference.markdown import code, plain, table

_KINDS = (
    (Wrapper, "wrappers"),
    (Monitor, "monitoring generators"),
    (Generator, "generators"),
    (Propagator, "propagators"),
    (Connector, "connectors"),
)
_ORDER = ("containers", "wrappers", "generators", "monitoring generators", "propagators", "connectors")


def kind_of(stage: type[Stage]) -> str:
    """To which group a stage belongs."""
    return next((name for kind, name in _KINDS if issubclass(stage, kind)), "containers")


def shipped() -> dict[str, type[Stage]]:
    """The stages that kabo has, without those that somebody registered in this process."""
    kinds = {name: registry.find(name) for name in registry.names()}
    return {name: kind for name, kind in kinds.items() if kind is not None and kind.__module__.startswith("kabo.")}


def sections() -> str:
    """A section for each group, in it one for each stage."""
    stages = shipped()
    parts = []
    for group in _ORDER:
        members = [name for name, kind in stages.items() if kind_of(kind) == group]
        parts.append(f"## {group[:1].upper()}{group[1:]}")
        parts += [section(name, stages[name]) for name in members]
    return "\n\n" + "\n\n".join(parts) + "\n\n"


def section(name: str, kind: type[Stage]) -> str:
    """The section of one stage."""
    page = stage_page(kind)
    rows = (
        [("`monitors`", "the path of a stage", "must be given", "whose successes trigger it")]
        if page["monitors"]
        else []
    )
    rows += [
        (
            code(key),
            each["type"],
            code(each["default"]) if each["default"] is not None else "must be given",
            plain(each["doc"]),
        )
        for key, each in page["properties"].items()
    ]
    properties = table(("property", "type", "default", "meaning"), rows) if rows else "No properties of its own."
    return "\n\n".join([f"### {name}", plain(page["doc"]), properties])
