"""Reads the file of a plan, of either format: all errors in its form are reported at once, each with its JSON path.

Only the form is checked here. The verifier judges whether ids exist, branches are complete, and motions fit their
actions.
"""

import logging
import re
from pathlib import Path

from kabo.given import read_file, require_given
from kabo.options import OPTIONS, Option
from kabo.plan.certificate_json import certificate_from_json
from kabo.plan.checked_json import JsonValue, read_checked
from kabo.plan.plan import (
    Done,
    Grant,
    Learned,
    Node,
    ObjectPose,
    Plan,
    Segment,
    StateChange,
    ValueOf,
)
from kabo.plan.trajectory_json import trajectory_from_json
from kabo.plan.writing import FORMAT, READABLE_FORMATS

_LOG = logging.getLogger("kabo.plan")
_ID = re.compile(r"n(0|[1-9][0-9]*)")
_HASH = re.compile(r"sha256:[0-9a-f]{64}")
_SEGMENT = ("robot", "joints", "waypoints", "times", "procedure", "stage", "attach", "detach", "allowed_contacts")
_MOVING = ("motion", "after", "overlap", "learned")
_OTHER_FILES = {
    "kabo-task": ("a report of a task", "kabo task export makes a plan of a solution in it"),
    "kabo-state": (
        "the state of a run",
        "give the plan that was carried out; `--after` of kabo replan takes the state",
    ),
    "kabo-view": ("the content of a page", "give the plan that the page shows"),
}
_FIRST_OPTIONS = ("search", "seed", "epsilon", "geometry")  # of every plan; plans of older kabos have no others


def load_plan(path: str | Path) -> Plan:
    """The plan of a file, as `kabo solve -o` or `Plan.save` wrote it.

    Args:
        path: the plan file.

    Raises:
        InputError: the file cannot be read, or its form is wrong; has all findings with their JSON paths.

    Example:
        >>> plan = kabo.solve(kabo.load_problem("domains/grid/n3.yaml")).plan
        >>> plan.save("plan.json")
        'sha256:...'
        >>> kabo.load_plan("plan.json") == plan
        True
    """
    content = read_file("path", path)
    _LOG.debug("read %s", path, extra={"fields": {"file": str(path), "bytes": len(content)}})
    return plan_from_json(content, file=str(path))


def plan_from_json(content: bytes | str, *, file: str = "plan.json") -> Plan:
    """The plan of a file's bytes, or of its text.

    Args:
        content: the file, as bytes or as text.
        file: its name in diagnostics.

    Raises:
        ArgumentError: `content` is neither bytes nor text.
        InputError: the form is wrong; has all findings with their JSON paths.
    """
    require_given("content", content, bytes, str)
    require_given("file", file, str)
    return read_checked(content.encode("utf-8", "replace") if isinstance(content, str) else content, file, _plan)


def _plan(place: JsonValue) -> Plan:
    place.refuse_other_files("a plan", _OTHER_FILES)
    fields = place.fields(
        ("format", "problem", "options", "root", "nodes"), ("start", "certificate", "certificate_gaps", "done")
    )
    problem = fields["problem"].fields(("name", "files"))
    nodes = fields["nodes"].mapping()
    if not nodes and isinstance(fields["nodes"].value, dict):
        fields["nodes"].add_finding("a plan has at least one node")
    for name, node in nodes.items():
        if not _ID.fullmatch(name):
            node.add_finding(f'"{name}" is no node id', "ids are n0, n1, …")
    plan = Plan(
        problem=problem["name"].text(),
        files={name: _hash(value) for name, value in problem["files"].mapping().items()},
        options=_options(fields["options"]),
        root=_id(fields["root"]),
        nodes={name: _node(node) for name, node in nodes.items()},
        start=state_from_json(fields["start"], ("robots", "objects")) if "start" in fields else None,
        certificate=certificate_from_json(fields["certificate"]) if "certificate" in fields else None,
        certificate_gaps=_gaps(fields) if "certificate_gaps" in fields else (),
        done=tuple(map(done_from_json, fields["done"].items())) if "done" in fields else None,
    )
    if "format" in fields:
        _check_format(fields["format"], plan)
    return plan


def _check_format(place: JsonValue, plan: Plan) -> None:
    if place.value not in READABLE_FORMATS:
        place.add_finding(f'expected "{FORMAT}"', "this file is of another version, or no plan")
    elif place.value != FORMAT and any(s.trajectory for node in plan.nodes.values() for s in node.motion):
        place.add_finding(f'"trajectory" is a key of "{FORMAT}"', "write this format, or leave the key out")


def _gaps(fields) -> tuple[str, ...]:  # type: ignore[no-untyped-def]
    if "certificate" in fields:
        fields["certificate_gaps"].add_finding("a plan with gaps has no certificate")
    return tuple(entry.text() for entry in fields["certificate_gaps"].items(1))


def _id(place: JsonValue) -> str:
    name = place.text()
    if isinstance(place.value, str) and not _ID.fullmatch(name):
        place.add_finding(f'"{name}" is no node id', "ids are n0, n1, …")
    return name


def _hash(place: JsonValue) -> str:
    text = place.text()
    if isinstance(place.value, str) and not _HASH.fullmatch(text):
        place.add_finding(f'"{text}" is no hash', "sha256: and 64 hexadecimal digits")
    return text


def _options(place: JsonValue) -> dict[str, str | float | int | None]:
    header = [name for name, option in OPTIONS.items() if option.in_header != "never"]
    fields = place.fields(_FIRST_OPTIONS, tuple(name for name in header if name not in _FIRST_OPTIONS))
    return {name: _option(OPTIONS[name], value) for name, value in fields.items() if name in OPTIONS}


def _option(option: Option, place: JsonValue) -> str | float | int | None:
    if option.null_in_header and place.value is None:
        return None
    if option.name == "search":  # by whatever planner
        return place.text()
    if option.choices:
        return place.one_of(*option.choices)
    return place.index() if option.kind is int else place.number()


def _node(place: JsonValue) -> Node:
    found = place.mapping()
    if "kind" not in found:
        place.add_finding('"kind" is missing')
        return Node("goal")
    kind = found["kind"].one_of("action", "sense", "branch", "goal")
    if kind == "goal":
        place.fields(("kind",))
        return Node("goal")
    if kind == "branch":
        fields = place.fields(("kind", "on", "branches"))
        return Node("branch", on=fields["on"].text(), branches=_branches(fields["branches"]))
    if kind == "action":
        fields = place.fields(("kind", "action", "arguments", "next"), _MOVING)
        return Node("action", next=_id(fields["next"]), **_acting(fields))
    if kind == "sense" and "delivers" in found:
        fields = place.fields(("kind", "action", "arguments", "delivers", "next"), _MOVING)
        delivers = tuple(entry.text() for entry in fields["delivers"].items(1))
        return Node("sense", next=_id(fields["next"]), delivers=delivers, **_acting(fields))
    if kind == "sense":
        fields = place.fields(("kind", "action", "arguments", "on", "branches"), _MOVING)
        return Node("sense", on=fields["on"].text(), branches=_branches(fields["branches"]), **_acting(fields))
    return Node("goal")


def _acting(fields) -> dict:  # type: ignore[no-untyped-def, type-arg]
    """The fields that action and sense nodes have in common."""
    return {
        "action": fields["action"].text(),
        "arguments": {name: argument_from_json(value) for name, value in fields["arguments"].mapping().items()},
        "motion": tuple(_segment(entry) for entry in fields["motion"].items(1)) if "motion" in fields else (),
        "after": state_from_json(fields["after"], ()) if "after" in fields else None,
        "overlap": _overlap(fields) if "overlap" in fields else 0.0,
        "learned": learned_from_json(fields["learned"]) if "learned" in fields else (),
    }


def learned_from_json(place: JsonValue) -> tuple[Learned, ...]:
    """The records of learned parameters: one object, or a list of two or more."""
    return tuple(map(_learned, place.items(2))) if isinstance(place.value, list) else (_learned(place),)


def _learned(place: JsonValue) -> Learned:
    fields = place.fields(("model", "case", "parameters", "validity", "expected"))
    model, validity = fields["model"].text(), fields["validity"].number()
    if "model" in fields and not model and isinstance(fields["model"].value, str):
        fields["model"].add_finding("expected the path of a model file")
    if not 0.0 < validity <= 1.0 and "validity" in fields:
        fields["validity"].add_finding("a validity is a probability above 0")
    parameters = {name: value.number() for name, value in fields["parameters"].mapping().items()}
    if not parameters and isinstance(fields["parameters"].value, dict):
        fields["parameters"].add_finding("expected at least one parameter")
    return Learned(
        model,
        {name: value.text() for name, value in fields["case"].mapping().items()},
        parameters,
        validity,
        {name: value.number() for name, value in fields["expected"].mapping().items()},
    )


def _overlap(fields) -> float:  # type: ignore[no-untyped-def]
    value: float = fields["overlap"].number()
    if value <= 0.0:
        fields["overlap"].add_finding("an overlap is a span of time above 0")
    if "motion" not in fields:
        fields["overlap"].add_finding("nothing moves: there is nothing to overlap")
    return value


def _branches(place: JsonValue) -> dict[str, str]:
    branches = place.mapping()
    if not branches and isinstance(place.value, dict):
        place.add_finding("a node that branches has at least one branch")
    return {outcome: _id(value) for outcome, value in branches.items()}


def done_from_json(place: JsonValue) -> Done:
    """A step of a run: an action, an observation, or both."""
    fields = place.fields((), ("action", "arguments", "on", "outcome"))
    for first, second in (("action", "arguments"), ("on", "outcome")):
        for one, other in ((first, second), (second, first)):
            if one in fields and other not in fields:
                place.add_finding(f'"{other}" is missing')
    if isinstance(place.value, dict) and not fields:
        place.add_finding("a step is an action, an observation, or both")
    arguments = fields["arguments"].mapping() if "arguments" in fields else {}
    return Done(
        fields["action"].text() if "action" in fields else None,
        {name: argument_from_json(value) for name, value in arguments.items()},
        fields["on"].text() if "on" in fields else None,
        fields["outcome"].text() if "outcome" in fields else None,
    )


def argument_from_json(place: JsonValue) -> str | float | ValueOf:
    """An argument of an action."""
    if isinstance(place.value, dict):
        return ValueOf(place.fields(("value_of",))["value_of"].text())
    return place.value if isinstance(place.value, str) else place.number()


def _segment(place: JsonValue) -> Segment:
    fields = place.fields((*_SEGMENT, "constraint"), ("grants", "trajectory"))
    joints = tuple(entry.text() for entry in fields["joints"].items(1))
    rows = fields["waypoints"].items(2)
    times = fields["times"].items(2)
    if len(rows) != len(times):
        fields["times"].add_finding(f"{len(times)} times for {len(rows)} way points")
    for time in times:
        if time.number() < 0:
            time.add_finding("a time is never negative")
    waypoints = tuple(tuple(value.number() for value in row.items(exactly=len(joints))) for row in rows)
    seconds = tuple(time.number() for time in times)
    attached = [entry.fields(("object", "to")) for entry in fields["attach"].items()]
    return Segment(
        robot=fields["robot"].text(),
        joints=joints,
        waypoints=waypoints,
        times=seconds,
        procedure=fields["procedure"].text(),
        stage=fields["stage"].text_or_null(),
        attach=tuple((entry["object"].text(), entry["to"].text()) for entry in attached),
        detach=tuple(entry.text() for entry in fields["detach"].items()),
        allowed_contacts=tuple(_pair(entry) for entry in fields["allowed_contacts"].items()),
        constraint=fields["constraint"].text_or_null(),
        grants=tuple(_grant(entry) for entry in fields["grants"].items(1)) if "grants" in fields else (),
        trajectory=(
            trajectory_from_json(fields["trajectory"], joints, waypoints, seconds)
            if "trajectory" in fields
            else None
        ),
    )


def _grant(place: JsonValue) -> Grant:
    fields = place.fields(("kind", "bodies", "by"))
    kind = fields["kind"].one_of("grasp", "support", "mate")
    return Grant(kind, _pair(fields["bodies"]), fields["by"].text_or_null())  # type: ignore[arg-type]


def _pair(place: JsonValue) -> tuple[str, str]:
    names = [entry.text() for entry in place.items(exactly=2)]
    return (names[0], names[1]) if len(names) == 2 else ("", "")


def state_from_json(place: JsonValue, required: tuple[str, ...]) -> StateChange:
    """A geometric state, or the part of it that changes; `required` are the keys that must be there."""
    fields = place.fields(required, ("robots", "objects"))
    if not required and isinstance(place.value, dict) and not place.value:
        place.add_finding("nothing changes: leave the key out")
    robots = fields["robots"].mapping() if "robots" in fields else {}
    objects = fields["objects"].mapping() if "objects" in fields else {}
    return StateChange(
        {name: _joints(value) for name, value in robots.items()},
        {name: _pose(value) for name, value in objects.items()},
    )


def _joints(place: JsonValue) -> dict[str, float]:
    return {name: value.number() for name, value in place.fields(("joints",))["joints"].mapping().items()}


def _pose(place: JsonValue) -> ObjectPose:
    fields = place.fields(("parent", "position", "quaternion"))
    position = [value.number() for value in fields["position"].items(exactly=3)]
    quaternion = [value.number() for value in fields["quaternion"].items(exactly=4)]
    if len(position) != 3 or len(quaternion) != 4:
        return ObjectPose("world", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    if abs(sum(value * value for value in quaternion) - 1.0) > 1e-6:
        fields["quaternion"].add_finding("a quaternion (x, y, z, w) has length 1")
    x, y, z = position
    qx, qy, qz, qw = quaternion
    return ObjectPose(fields["parent"].text(), (x, y, z), (qx, qy, qz, qw))
