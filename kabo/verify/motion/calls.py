"""What the geometric call of a node names: robots, bodies, a region, families; and what its procedure is to do.

Arguments fill the properties that the procedure's task file declares, and play their roles in the order of their
kinds: the first robot, the first body. What the procedures of the library are to do is told by their names; of a
task of the domain's own with another name, only what it names is known.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from kabo.language import ProcedureSignatures
from kabo.language.formulas import Constant, ProcedureCall, Variable
from kabo.language.problem import Problem
from kabo.language.scene_description import SceneDescription
from kabo.plan import Node

KINDS = ("robot", "body", "region")


@dataclass(frozen=True)
class Law:
    """What a procedure is to do: the roles of its robots and bodies, in order, the first `needed` of each given."""

    robots: tuple[str, ...] = ("robot",)
    bodies: tuple[str, ...] = ()
    needed: tuple[int, int] = (1, 0)
    takes: str | None = None  # the robot that takes the object
    lets_go: str | None = None  # the robot that lets it go
    places: bool = False  # the object ends as one of its placements says
    mates: bool = False  # two bodies are mated


LAWS = {
    "move": Law(),
    "sense": Law(bodies=("object",), needed=(1, 1)),
    "sense_weight": Law(bodies=("object",), needed=(1, 1)),
    "pick": Law(bodies=("object",), needed=(1, 1), takes="robot"),
    "place": Law(bodies=("object", "support"), needed=(1, 1), lets_go="robot", places=True),
    "release": Law(bodies=("object", "support"), needed=(1, 1), lets_go="robot", places=True),
    "transfer": Law(bodies=("object", "support"), needed=(1, 1), places=True),
    "restack": Law(bodies=("object", "support"), needed=(1, 2), takes="robot", lets_go="robot", places=True),
    "hand_over": Law(("robot", "receiver"), ("object",), (2, 1), takes="receiver", lets_go="robot"),
    "insert": Law(bodies=("object", "other"), needed=(1, 2), mates=True),
    "insert_bimanual": Law(("robot", "other_robot"), ("object", "other"), (2, 2), mates=True),
}
WHERE_SENSED = {"sense": "sense", "sense_weight": "weigh"}  # the configuration to sense in, if the robot has it


@dataclass(frozen=True)
class Call:
    """A ground call: who plays which role; `law` is None for a task whose purpose is not known here.

    Attributes:
        procedure: its name.
        things: all robots, bodies and regions that it names, by kind and in order.
        roles: role -> name, as the law calls them; and `region`.
        keep, grasp, placement, mate, at: names, or None for any.
    """

    procedure: str
    things: Mapping[str, tuple[str, ...]]
    roles: Mapping[str, str] = field(default_factory=dict)
    law: Law | None = None
    keep: str | None = None
    grasp: str | None = None
    placement: str | None = None
    mate: str | None = None
    at: str | None = None  # the configuration in which a robot senses
    text: str = ""

    def __str__(self) -> str:
        return self.text

    @property
    def robots(self) -> tuple[str, ...]:
        """The robots that it may move."""
        return self.things["robot"]

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies that it names."""
        return self.things["body"]

    def role(self, role: str | None) -> str | None:
        """Who plays a role."""
        return None if role is None else self.roles.get(role)


class Calls:
    """The geometric calls of the nodes of a plan."""

    def __init__(self, problem: Problem) -> None:
        assert problem.scene is not None
        self.problem, self.scene = problem, problem.scene
        path = problem.domain.path
        self.unjudged: dict[str, None] = {}  # procedures whose purpose is not known here
        self._procedures = ProcedureSignatures(None if path is None else str(Path(path).parent))

    def of(self, node: Node) -> Call | None:
        """The geometric call of a node; None if its action has none.

        Raises:
            ValueError: a procedure that does not exist, or arguments that do not fit it.
        """
        action = self.problem.domain.actions.get(str(node.action))
        if action is None or action.geometry is None:
            return None
        call = action.geometry
        if call.procedure in self.problem.domain.procedures:
            return None  # somebody else answers for it: it says whether, not how
        signature = self._procedures.get(call.procedure)
        if signature is None:
            raise ValueError(
                f'the procedure "{call.procedure}" is not judged by this verifier: it has no task file'
            )
        arguments = self._arguments(call, node, [each.name for each in signature])
        kinds = {each.name: each.kind for each in signature}
        things: dict[str, list[str]] = {kind: [] for kind in KINDS}
        for name, declared in kinds.items():
            kind = _kind(declared, arguments.get(name), self.scene)
            if name in arguments and kind is not None:
                things[kind].append(arguments[name])
        found = _call(call.procedure, {kind: tuple(names) for kind, names in things.items()}, arguments)
        if found.law is None:
            self.unjudged[call.procedure] = None
        return found

    def notes(self) -> list[str]:
        """What was not judged, for people."""
        text = (
            "a task of the domain's own: its motion was verified, and what it takes and records, not its purpose"
        )
        return [f'"{name}" is {text}' for name in self.unjudged]

    def _arguments(self, call: ProcedureCall, node: Node, names: list[str]) -> dict[str, str]:
        """Property -> value, in the order in which the properties are declared."""
        positional, named = [], {}
        for argument in call.arguments:
            value = argument.value
            if isinstance(value, Variable):
                shown = str(node.arguments.get(value.name))
            else:
                shown = value.name if isinstance(value, Constant) else f"{value.value:g}"
            if argument.name is None:
                positional.append(shown)
            else:
                named[argument.name] = shown
        if len(positional) > len(names):
            raise ValueError(f'"{call.procedure}" takes {len(names)} arguments, not {len(positional)}')
        given = dict(zip(names, positional, strict=False)) | named
        return {name: given[name] for name in names if name in given}


def _kind(declared: str, value: str | None, scene: SceneDescription) -> str | None:
    """The kind of thing that an argument is, or None; where the file does not say, the scene does."""
    if declared in KINDS:
        return declared
    if declared != "any":
        return None
    for kind, names in zip(KINDS, (scene.robots, scene.bodies, scene.regions), strict=True):
        if value in names:
            return kind
    return None


def _call(procedure: str, things: Mapping[str, tuple[str, ...]], arguments: Mapping[str, str]) -> Call:
    law = LAWS.get(procedure)
    robots, bodies = things["robot"], things["body"]
    if law is not None and (len(robots) < law.needed[0] or len(bodies) < law.needed[1]):
        law = None  # a task of the domain's own that only has the same name
    roles = {"region": things["region"][0]} if things["region"] else {}
    if law is not None:
        roles |= dict(zip(law.robots, robots, strict=False)) | dict(zip(law.bodies, bodies, strict=False))
    given = {name: arguments.get(name) for name in ("keep", "grasp", "placement", "mate", "at")}
    chosen = {name: None if value in (None, "", "any") else value for name, value in given.items()}
    chosen["at"] = chosen["at"] or WHERE_SENSED.get(procedure)
    named = {name for names in things.values() for name in names}
    text = f"{procedure}({', '.join(value for value in arguments.values() if value in named)})"
    return Call(procedure, things, roles, law, text=text, **chosen)
