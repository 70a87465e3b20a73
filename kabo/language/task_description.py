"""A task file as plain data with places: the tree of its stages, and the values of their properties [T 3.7].

The meaning of a value depends on the type of the stage that has the property. Types of stages are not known here,
so values are kept as written.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from kabo.language.formulas import Place
from kabo.language.source import SourceFile

THINGS = ("robot", "body", "region")  # of the scene
FAMILIES = ("grasp", "placement", "motion_constraint")  # names that the scene gives
LEARNED_PARAMETERS, RISK = "LearnedParameters", "risk"  # the stage and the cost term that read models
KINDS = (*THINGS, *FAMILIES, "name", "number", "boolean", "any")  # of a task's declared properties


@dataclass(frozen=True)
class Word:
    """A scalar value as text; if it is `quoted`, it is never read as a number."""

    text: str
    quoted: bool
    place: Place


@dataclass(frozen=True)
class PropertyReference:
    """A reference to a property of the parent or the interface, such as `<PARENT:name>`; `<PARENT>`: its own name."""

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
        kind: the kind of value, one of `KINDS` (`any` if the file gives only a name); None if an error was
            reported.
        required: whether a call must give the property, since it has no default.
        default: the default of this kind (as written if the kind is `any`); None if there is no default.
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
        type: the value of the key `stage`; None if the key is missing, which was reported.
        stages: the children of a container; None if there is no key `stages`.
        wrapped: the child of a wrapper; None if the stage is no wrapper.
        properties: the values of all other keys; `keys` are the places of these keys.
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
        """The child stages: those of a container, or the one of a wrapper."""
        return (*(self.stages or ()), *(() if self.wrapped is None else (self.wrapped,)))

    def walk(self) -> Iterator["StageDescription"]:
        """This stage and all its descendants, each before its children."""
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


def model_of_risk(stage: StageDescription) -> Written | None:
    """What a stage's cost term `risk` names as its model; None if it has no such term, or the term names none."""
    cost = stage.properties.get("cost")
    risk = cost.values.get(RISK) if isinstance(cost, Entries) else None
    return risk.values.get("model") if isinstance(risk, Entries) else None


def models_named(task: TaskDescription) -> Iterator[Word]:
    """The paths of models that a task names, relative to its file: of stages that infer parameters, and of cost terms."""
    for stage in task.root.walk():
        own = stage.properties.get("model") if stage.type == LEARNED_PARAMETERS else None
        yield from (each for each in (own, model_of_risk(stage)) if isinstance(each, Word))


@dataclass(frozen=True)
class ProcedureProperty:
    """A property of a geometric procedure, which is a task; `kind` is the kind of its values.

    Values of the kinds robot, body and region are things in a scene; values of the kinds grasp, placement and
    motion_constraint are names that a scene defines.
    """

    name: str
    kind: str
    required: bool = True


Signature = tuple[ProcedureProperty, ...]


def spell_signature(name: str, properties: Signature) -> str:
    """The signature of a procedure as text, such as `pick(robot, object, grasp = …)`."""
    return f"{name}({', '.join(each.name if each.required else f'{each.name} = …' for each in properties)})"
