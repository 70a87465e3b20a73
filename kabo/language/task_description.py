"""A task file as plain data with places: the tree of its stages, and the values that stand beside them [T 3.7].

The meaning of a value depends on the stage that has the property. No stages are known here: values stay as
written.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from kabo.language.formulas import Place
from kabo.language.source import SourceFile

THINGS = ("robot", "body", "region")  # of the scene
FAMILIES = ("grasp", "placement", "motion_constraint")  # names that the scene gives
KINDS = (*THINGS, *FAMILIES, "name", "number", "boolean", "any")  # of a task's declared properties


@dataclass(frozen=True)
class Word:
    """A scalar; text that is `quoted` is never read as a number."""

    text: str
    quoted: bool
    place: Place


@dataclass(frozen=True)
class PropertyReference:
    """`<PARENT>`, `<PARENT:name>`, `<INTERFACE:name>`; without a name, the property's own."""

    source: Literal["PARENT", "INTERFACE"]
    name: str | None
    place: Place

    def __str__(self) -> str:
        return f"<{self.source}>" if self.name is None else f"<{self.source}:{self.name}>"


@dataclass(frozen=True)
class Items:
    """A list of values."""

    values: tuple["Written", ...]
    place: Place


@dataclass(frozen=True)
class Entries:
    """A mapping of words to values."""

    values: Mapping[str, "Written"]
    place: Place


Written = Word | PropertyReference | Items | Entries
Value = str | int | float | bool | None


@dataclass(frozen=True)
class Input:
    """A property that a task declares; the inputs of a task, in order, are the arguments of its calls.

    Attributes:
        kind: one of `KINDS` (`any` where the file only names the property); None after a reported error.
        required: whether there is no default.
        default: a value of the kind, or for `any` the value as written; None if there is no default.
    """

    name: str
    kind: str | None
    place: Place
    required: bool = True
    default: Value | Written = None


@dataclass(frozen=True)
class StageDescription:
    """A stage as described in a task file.

    Attributes:
        type: the value of the key `stage`; None if that is missing (which was reported).
        stages: the children of a container; None for what has no key `stages`.
        wrapped: the child of a wrapper.
        properties: every other key; `keys` are their places.
    """

    name: str
    type: str | None
    place: Place
    type_place: Place
    stages: tuple["StageDescription", ...] | None = None
    wrapped: "StageDescription | None" = None
    monitors: Word | None = None
    properties: Mapping[str, Written] = field(default_factory=dict)
    keys: Mapping[str, Place] = field(default_factory=dict)

    @property
    def children(self) -> tuple["StageDescription", ...]:
        """The stages below, wrapped or not."""
        return (*(self.stages or ()), *(() if self.wrapped is None else (self.wrapped,)))

    def walk(self) -> Iterator["StageDescription"]:
        """This stage and all below, each before its children."""
        yield self
        for child in self.children:
            yield from child.walk()


@dataclass(frozen=True)
class TaskDescription:
    """A task file: its inputs, and its stages below `root`, a serial container with the task's name."""

    name: str
    inputs: tuple[Input, ...]
    root: StageDescription
    max_solutions: int | None = None
    timeout: float | None = None
    source: SourceFile = field(default_factory=lambda: SourceFile(Path(), "", ""))


@dataclass(frozen=True)
class ProcedureProperty:
    """A property of a procedure, that is, of a task; `kind` is the kind of value that it takes.

    Things (robot, body, region) are those of a scene; families (grasp, placement, motion_constraint) names that a
    scene gives.
    """

    name: str
    kind: str
    required: bool = True


Signature = tuple[ProcedureProperty, ...]


def spell_signature(name: str, properties: Signature) -> str:
    """`pick(robot, object, grasp = …)`."""
    return f"{name}({', '.join(each.name if each.required else f'{each.name} = …' for each in properties)})"
