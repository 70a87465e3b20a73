"""A problem as data: domain, objects, initial knowledge, goal, options, the scene's description, files read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from kabo.displays import counted, display
from kabo.language.formulas import Application, Atom, Effect, Formula, GroundCall, Place, ProcedureCall, Term
from kabo.language.scene_description import SceneDescription
from kabo.options import SolveOptions


@dataclass(frozen=True)
class Function:
    """A function's signature: its value is an object of `value_type`, one of `values`, else a number."""

    name: str
    arguments: tuple[str, ...]
    value_type: str | None = None
    values: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Procedure:
    """An external procedure's signature: the procedure is a test, or has a value like a function."""

    name: str
    arguments: tuple[str, ...]
    is_test: bool
    value_type: str | None = None
    values: tuple[str, ...] | None = None
    place: Place | None = field(default=None, compare=False, repr=False)

    @property
    def is_number(self) -> bool:
        """Whether the value of the procedure is a number."""
        return not self.is_test and self.value_type is None and self.values is None


Answer = bool | str | float | None  # of a test, with an object, with a number; None: there is no value


@dataclass(frozen=True)
class Answers:
    """A source of answers of external procedures, those named in `given`; equal calls must have equal answers."""

    given: frozenset[str]
    ask: Callable[[GroundCall], Answer]


@dataclass(frozen=True)
class Parameter:
    """A parameter of an action: an object of a type, or a run-time variable with the value of `value_of`."""

    name: str
    type: str
    value_of: Application | None = None
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Action:
    """An action schema; `sense` lists the atoms and terms whose values the action observes when it is executed."""

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
    """A domain: `types` maps each type to its supertype or None; all mappings keep the order of the file.

    If `worldly`, conditions are about the world (as in PDDL), so a disjunction requires only that some part holds.
    Otherwise they are about knowledge: `K(p) or K(q)` requires that p is known or q is known.
    `events` happen, and nobody does them: they say what is then known. No plan has one, but the state of a run may.
    """

    name: str
    types: Mapping[str, str | None]
    constants: Mapping[str, str]
    predicates: Mapping[str, tuple[str, ...]]
    functions: Mapping[str, Function]
    update_rules: tuple[Effect, ...]
    actions: Mapping[str, Action]
    path: Path | None = None
    procedures: Mapping[str, Procedure] = field(default_factory=dict)
    worldly: bool = False
    events: Mapping[str, Action] = field(default_factory=dict)

    def __repr__(self) -> str:
        facts = counted(
            len(self.predicates) + len(self.functions), "predicate and function", "predicates and functions"
        )
        return f"<Domain {self.name}: {counted(len(self.actions), 'action')}, {facts}>"

    def is_a(self, kind: str, ancestor: str) -> bool:
        """Whether type `kind` is `ancestor` or one of its subtypes."""
        current: str | None = kind
        while current is not None:
            if current == ancestor:
                return True
            current = self.types.get(current)
        return False


@dataclass(frozen=True)
class Problem:
    """Everything that is known before planning.

    `objects` maps every object *and* every constant of the domain to its type, in order of declaration (constants
    first). `files` maps every file read so far, as a path relative to the problem's folder with forward slashes,
    to `sha256:…` of its bytes; scene loading adds meshes and URDF files. `answers` calls the domain's external
    procedures and is never read from a file; without it all tests hold, and no other procedure has a value.
    """

    name: str
    domain: Domain
    objects: Mapping[str, str]
    initial: tuple[Effect, ...]
    goal: tuple[Formula, ...]
    options: SolveOptions
    scene: SceneDescription | None
    path: Path
    files: Mapping[str, str]
    answers: Answers | None = field(default=None, compare=False, repr=False)

    def __repr__(self) -> str:
        return f"<Problem {self.name}: {', '.join(self._sizes().values())}>"

    def _repr_html_(self) -> str:
        figures = {
            "domain": self.domain.name,
            "objects": ", ".join(f"{name} ({kind})" for name, kind in self.objects.items()),
            "actions": ", ".join(self.domain.actions),
            "scene": self._sizes().get("scene", ""),
            "file": self.path.name,
        }
        return display(f"Problem {self.name}", figures, None if self.scene is None else self)

    def _sizes(self) -> dict[str, str]:
        """How many objects, actions, goals there are, and how large the scene is."""
        sizes = {
            "objects": counted(len(self.objects), "object"),
            "actions": counted(len(self.domain.actions), "action"),
            "goal": f"{counted(len(self.goal), 'goal')}",
        }
        if self.scene is not None:
            robots, bodies = counted(len(self.scene.robots), "robot"), len(self.scene.bodies)
            sizes["scene"] = f"scene with {robots} and {counted(bodies, 'body', 'bodies')}"
        return sizes

    def with_events(self) -> "Problem":
        """The problem in which the domain's events are actions, as far as what was done is concerned."""
        domain = self.domain
        return replace(self, domain=replace(domain, actions={**domain.actions, **domain.events}, events={}))

    def of_type(self, kind: str) -> tuple[str, ...]:
        """The names of all objects and constants of type `kind` or a subtype, in order of declaration."""
        return tuple(name for name, own in self.objects.items() if self.domain.is_a(own, kind))

    def values_of(self, function: str) -> tuple[str, ...] | None:
        """All values that the function can take, in order of declaration; None if its value is a number."""
        declared = self.domain.functions[function]
        if declared.values is not None:
            return declared.values
        return None if declared.value_type is None else self.of_type(declared.value_type)

    def answers_of(self, procedure: str) -> tuple[str, ...]:
        """All values that an external procedure can return, as declared; empty for numbers and tests."""
        declared = self.domain.procedures[procedure]
        if declared.values is not None:
            return declared.values
        return () if declared.value_type is None else self.of_type(declared.value_type)
