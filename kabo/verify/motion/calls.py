"""The geometric call of a node: the robots, bodies, region and families that it names, and what its procedure must do.

Arguments fill the properties that the procedure's task file declares, and take their roles in the order of their
kinds: the first robot, the first body. The purpose of the library's procedures is known by their names; of a domain's own
procedure with another name, only the things that the call names are known.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from kabo.language import ProcedureSignatures
from kabo.language.formulas import Constant, ProcedureCall, Variable
from kabo.language.problem import Problem
from kabo.language.scene_description import SceneDescription
from kabo.plan import Node
from kabo.scene import Scene
from kabo.verify.scene_alone import SceneAlone

KINDS = ("robot", "body", "region")


@dataclass(frozen=True)
class ProcedureSpec:
    """The purpose of a procedure: its result, its roles, and how many robots and bodies it needs (`needed`)."""

    robots: tuple[str, ...] = ("robot",)
    bodies: tuple[str, ...] = ()
    needed: tuple[int, int] = (1, 0)
    takes: str | None = None  # the robot that takes the object
    lets_go: str | None = None  # the robot that lets it go
    places: bool = False  # the object ends as one of its placements says
    mates: bool = False  # two bodies are mated


PROCEDURE_SPECS = {
    "move": ProcedureSpec(),
    "sense": ProcedureSpec(bodies=("object",), needed=(1, 1)),
    "sense_weight": ProcedureSpec(bodies=("object",), needed=(1, 1)),
    "pick": ProcedureSpec(bodies=("object",), needed=(1, 1), takes="robot"),
    "place": ProcedureSpec(bodies=("object", "support"), needed=(1, 1), lets_go="robot", places=True),
    "release": ProcedureSpec(bodies=("object", "support"), needed=(1, 1), lets_go="robot", places=True),
    "transfer": ProcedureSpec(bodies=("object", "support"), needed=(1, 1), places=True),
    "restack": ProcedureSpec(
        bodies=("object", "support"), needed=(1, 2), takes="robot", lets_go="robot", places=True
    ),
    "hand_over": ProcedureSpec(("robot", "receiver"), ("object",), (2, 1), takes="receiver", lets_go="robot"),
    "insert": ProcedureSpec(bodies=("object", "other"), needed=(1, 2), mates=True),
    "insert_bimanual": ProcedureSpec(("robot", "other_robot"), ("object", "other"), (2, 2), mates=True),
}
WHERE_SENSED = {"sense": "sense", "sense_weight": "weigh"}  # the configuration to sense in, if the robot has it


@dataclass(frozen=True)
class Call:
    """A ground call with the roles of its arguments; `spec` is None if the procedure's purpose is unknown here.

    Attributes:
        procedure: the procedure's name.
        things: all robots, bodies and regions that the call names, by kind and in order.
        roles: the name in each role of the spec, and in `region`.
        keep, grasp, placement, mate, at, sensor: names of constraint, grasp family, placement, mate, configuration, camera.
    """

    procedure: str
    things: Mapping[str, tuple[str, ...]]
    roles: Mapping[str, str] = field(default_factory=dict)
    spec: ProcedureSpec | None = None
    keep: str | None = None
    grasp: str | None = None
    placement: str | None = None
    mate: str | None = None
    at: str | None = None  # the configuration in which a robot senses
    sensor: str | None = None  # the camera that sees the object; None: any
    text: str = ""

    def __str__(self) -> str:
        return self.text

    @property
    def robots(self) -> tuple[str, ...]:
        """The robots that the call may move."""
        return self.things["robot"]

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies that the call names."""
        return self.things["body"]

    def looks(self, scene: Scene) -> bool:
        """Whether the call must end where a camera sees the object: it senses, and the robot has a camera."""
        robot = scene.robots.get(self.roles.get("robot", ""))
        return self.spec is not None and self.procedure == "sense" and robot is not None and bool(robot.sensors)

    def role(self, role: str | None) -> str | None:
        """The name of the thing in a role; None if the role is empty or is None."""
        return None if role is None else self.roles.get(role)


class Calls:
    """The geometric calls of the nodes of a plan."""

    def __init__(self, problem: Problem) -> None:
        assert problem.scene is not None
        self.problem, self.scene = problem, problem.scene
        path = problem.domain.path
        self.unjudged: dict[str, None] = {}  # procedures whose purpose is unknown here
        self._procedures = ProcedureSignatures(None if path is None else str(Path(path).parent))

    def of(self, node: Node) -> Call | None:
        """The geometric call of a node; None if its action has none.

        Raises:
            ValueError: the procedure does not exist, or the arguments do not fit it.
        """
        if isinstance(self.problem, SceneAlone):
            name = str(node.action)
            self.unjudged[name] = None
            return Call(name, self.problem.moved, text=name)
        action = self.problem.domain.actions.get(str(node.action))
        if action is None or action.geometry is None:
            return None
        call = action.geometry
        if call.procedure in self.problem.domain.procedures:
            return None  # an external procedure, which has no motion
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
        if found.spec is None:
            self.unjudged[call.procedure] = None
        return found

    def notes(self) -> list[str]:
        """Notes for the report: the procedures whose purpose the verifier does not know and did not judge."""
        whose = "a task" if isinstance(self.problem, SceneAlone) else "a task of the domain's own"
        text = f"{whose}: its motion was verified, and what it takes and records, not its purpose"
        return [f'"{name}" is {text}' for name in self.unjudged]

    def _arguments(self, call: ProcedureCall, node: Node, names: list[str]) -> dict[str, str]:
        """The value of each property, in the order in which the properties are declared."""
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
    """The kind of an argument (see `KINDS`) or None; the scene decides where the task file does not."""
    if declared in KINDS:
        return declared
    if declared != "any":
        return None
    for kind, names in zip(KINDS, (scene.robots, scene.bodies, scene.regions), strict=True):
        if value in names:
            return kind
    return None


def _call(procedure: str, things: Mapping[str, tuple[str, ...]], arguments: Mapping[str, str]) -> Call:
    spec = PROCEDURE_SPECS.get(procedure)
    robots, bodies = things["robot"], things["body"]
    if spec is not None and (len(robots) < spec.needed[0] or len(bodies) < spec.needed[1]):
        spec = None  # a domain's own task that only has the same name
    roles = {"region": things["region"][0]} if things["region"] else {}
    if spec is not None:
        roles |= dict(zip(spec.robots, robots, strict=False)) | dict(zip(spec.bodies, bodies, strict=False))
    given = {name: arguments.get(name) for name in ("keep", "grasp", "placement", "mate", "at", "sensor")}
    chosen = {name: None if value in (None, "", "any") else value for name, value in given.items()}
    chosen["at"] = chosen["at"] or WHERE_SENSED.get(procedure)
    named = {name for names in things.values() for name in names}
    text = f"{procedure}({', '.join(value for value in arguments.values() if value in named)})"
    return Call(procedure, things, roles, spec, text=text, **chosen)
