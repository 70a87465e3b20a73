"""A problem as data: domain, objects, initial knowledge, goal, options, the scene's description, files read."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from kabo.language.formulas import Application, Atom, Effect, Formula, Place, ProcedureCall, Term
from kabo.language.scene_description import SceneDescription


@dataclass(frozen=True)
class Function:
    """A function's signature. Exactly one of `value_type` and `values` is set, or neither: then it is a number."""

    name: str
    arguments: tuple[str, ...]
    value_type: str | None = None
    values: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Parameter:
    """A parameter of an action: of a type, or a run-time variable (`value_of` is the term whose value it is)."""

    name: str
    type: str
    value_of: Application | None = None
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Action:
    """An action schema; `sense` lists what its run-time component delivers (Kw atoms, Kv terms)."""

    name: str
    parameters: tuple[Parameter, ...]
    preconditions: tuple[Formula, ...]
    geometry: ProcedureCall | None
    effects: tuple[Effect, ...]
    sense: tuple[Atom | Application, ...]
    cost: Term
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Domain:
    """A domain: `types` maps each type to its supertype or None; all mappings keep the order of the file."""

    name: str
    types: Mapping[str, str | None]
    constants: Mapping[str, str]
    predicates: Mapping[str, tuple[str, ...]]
    functions: Mapping[str, Function]
    update_rules: tuple[Effect, ...]
    actions: Mapping[str, Action]
    path: Path | None = None

    def is_a(self, kind: str, ancestor: str) -> bool:
        """Whether type `kind` is `ancestor` or one of its subtypes."""
        current: str | None = kind
        while current is not None:
            if current == ancestor:
                return True
            current = self.types.get(current)
        return False


@dataclass(frozen=True)
class Options:
    """What a problem file says about how to solve it; None where it says nothing."""

    search: str | None = None
    seed: int | None = None
    epsilon: float | None = None
    geometry: str | None = None
    max_expansions: int | None = None
    max_samples: int | None = None
    seconds: float | None = None


@dataclass(frozen=True)
class Problem:
    """Everything that is known before planning.

    `objects` maps every object *and* every constant of the domain to its type, in order of declaration (constants
    first). `files` maps every file read so far, as a path relative to the problem's folder with forward slashes,
    to `sha256:…` of its bytes; scene loading adds meshes and URDF files.
    """

    name: str
    domain: Domain
    objects: Mapping[str, str]
    initial: tuple[Effect, ...]
    goal: tuple[Formula, ...]
    options: Options
    scene: SceneDescription | None
    path: Path
    files: Mapping[str, str]

    def of_type(self, kind: str) -> tuple[str, ...]:
        """The names of all objects and constants of type `kind` or a subtype, in order of declaration."""
        return tuple(name for name, own in self.objects.items() if self.domain.is_a(own, kind))

    def values_of(self, function: str) -> tuple[str, ...] | None:
        """All values that the function can take, in order of declaration; None for numbers."""
        declared = self.domain.functions[function]
        if declared.values is not None:
            return declared.values
        return None if declared.value_type is None else self.of_type(declared.value_type)
