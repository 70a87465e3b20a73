"""Which robot, object, region and support the geometric call of a node names."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from kabo.language.formulas import Constant, ProcedureCall, Variable
from kabo.language.problem import Problem
from kabo.plan import Node

ROLES = {
    "move": ("robot",),
    "pick": ("robot", "object"),
    "place": ("robot", "object", "region"),
    "transfer": ("robot", "object", "region"),
    "release": ("robot", "object", "region"),
    "restack": ("robot", "object", "support"),
    "sense": ("robot", "object"),
    "sense_weight": ("robot", "object"),
}
_ALSO = {"restack": {"this": "object", "other": "support"}}  # how domains may call the roles by name
WHERE_SENSED = {
    "sense": "sense",
    "sense_weight": "weigh",
}  # the configuration in which a robot senses, if it has it


@dataclass(frozen=True)
class Call:
    """A ground call: who plays which role; `keep`, `grasp`, `placement` and `at` are names or None."""

    procedure: str
    roles: Mapping[str, str] = field(default_factory=dict)
    keep: str | None = None
    grasp: str | None = None
    placement: str | None = None
    at: str | None = None  # the configuration in which a robot senses

    def __str__(self) -> str:
        return f"{self.procedure}({', '.join(self.roles.values())})"


def call_of(node: Node, problem: Problem) -> Call | None:
    """The geometric call of a node; None if its action has none.

    Raises:
        ValueError: a procedure that this verifier does not know, or arguments that do not fit it.
    """
    action = problem.domain.actions.get(str(node.action))
    if action is None or action.geometry is None:
        return None
    call = action.geometry
    if call.procedure not in ROLES:
        raise ValueError(f'the procedure "{call.procedure}" is not judged by this verifier')
    positional, named = _values(call, node)
    names = ROLES[call.procedure]
    if len(positional) > len(names):
        raise ValueError(f'"{call.procedure}" takes {len(names)} arguments, not {len(positional)}')
    named = {_ALSO.get(call.procedure, {}).get(name, name): value for name, value in named.items()}
    roles = dict(zip(names, positional, strict=False)) | {n: v for n, v in named.items() if n in names}
    for required in ("robot", "object", "support"):
        if required in names and required not in roles:
            raise ValueError(f'"{call.procedure}" needs the argument "{required}"')
    any_is_none = {name: None if value == "any" else value for name, value in named.items()}
    keep, grasp, placement = (any_is_none.get(name) for name in ("keep", "grasp", "placement"))
    return Call(call.procedure, roles, keep, grasp, placement, named.get("at", WHERE_SENSED.get(call.procedure)))


def _values(call: ProcedureCall, node: Node) -> tuple[list[str], dict[str, str]]:
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
    return positional, named
