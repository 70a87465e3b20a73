"""Problem files: objects, additions to the scene, initial knowledge, goal, options [docs/reference/files.md]."""

from collections.abc import Iterator
from collections.abc import Mapping as MappingType
from math import inf
from typing import Any, cast

from kabo.language import formulas as f
from kabo.language.expressions import Expression
from kabo.language.findings import Findings, spell_place
from kabo.language.problem import Problem
from kabo.language.resolver import NameResolver
from kabo.language.spelling import spell
from kabo.language.task_description import FAMILIES, THINGS, ProcedureProperty, Signature
from kabo.language.tree_algebra import nodes
from kabo.language.vocabulary import Vocabulary
from kabo.language.yaml.documents import Mapping, YamlNode
from kabo.language.yaml.domain_file import DomainReading, named, read_named_things, read_parsed
from kabo.language.yaml.effects import read_effects
from kabo.language.yaml.queries import read_formula
from kabo.language.yaml.scenes.scene_file import SceneReading
from kabo.language.yaml.syntax import parse
from kabo.language.yaml.values import Reader
from kabo.options import OPTIONS, Option, SolveOptions

PROBLEM_KEYS = ("problem", "domain", "scene", "objects", "bodies", "regions", "initial", "goal", "options")

_SAID = {tuple(each.problem_key.split(".")): each for each in OPTIONS.values() if each.problem_key is not None}
OPTION_KEYS = tuple(dict.fromkeys(path[0] for path in _SAID))
BUDGET_KEYS = tuple(path[1] for path in _SAID if path[0] == "budget")


def read_problem(
    root: Mapping, domain: DomainReading | None, scene: SceneReading | None, findings: Findings
) -> Problem | None:
    """The problem that a document describes; None if `domain` is None, after errors have been reported.

    Without a domain, formulas are only parsed, because their names cannot be resolved. `Problem.files` is left
    empty.
    """
    reader = Reader(findings)
    reader.keys(root, PROBLEM_KEYS, "a problem")
    name = reader.name(reader.require(root, "problem", "a problem"), "a problem")
    if scene is None and root.get("scene") is None:
        for key in ("bodies", "regions"):
            if key in root.entries:
                findings.add(root.key(key).place, f"a problem without `scene` has no {key}")
    options = read_options(reader, root.get("options"))
    goal_node = reader.require(root, "goal", "a problem")
    if domain is None or domain.domain is None:
        _only_parse(reader, root, findings)
        return None
    objects, places = _read_objects(reader, domain, root.get("objects"))
    scalars = reader.formulas(root.get("initial"), "an initial update")
    effects = [
        read_parsed(scalar, "effect", domain.vocabulary, "in the initial knowledge", _read_initial)
        for scalar in scalars
    ]
    scalars = reader.formulas(goal_node, "a goal")
    goal = [read_parsed(scalar, "formula", domain.vocabulary, "in the goal", _read_goal) for scalar in scalars]
    problem = Problem(
        name or "", domain.domain, objects, tuple(effect for group in effects for effect in group or ()),
        tuple(each for each in goal if each is not None), options, None if scene is None else scene.description,
        root.source.path, {},
    )  # fmt: skip
    if scene is not None and scene.description is not None:
        _check_calls(problem, scene, places, domain.vocabulary)
    return problem


def _read_initial(here: NameResolver, node: Expression) -> tuple[f.Effect, ...]:
    return read_effects(here, node, world=False, conditional=False)


def _read_goal(here: NameResolver, node: Expression) -> f.Formula | None:
    return read_formula(here, node, temporal=True)


def _only_parse(reader: Reader, root: Mapping, findings: Findings) -> None:
    for key, start in (("initial", "effect"), ("goal", "formula")):
        for scalar in reader.formulas(root.get(key), "a formula"):
            parse(scalar, start, findings)


def _read_objects(
    reader: Reader, domain: DomainReading, node: YamlNode | None
) -> tuple[dict[str, str], dict[str, f.Place]]:
    objects = dict(domain.constants)
    places: dict[str, f.Place] = {}
    for scalar, kind in read_named_things(reader, domain.vocabulary, node, "object"):
        if domain.vocabulary.declare(named(scalar, "object", kind)) and kind is not None:
            objects[scalar.text] = kind
            places[scalar.text] = scalar.place
    return objects, places


# ------------------------------------------------------------------------------------------------------- options
def read_options(reader: Reader, node: YamlNode | None) -> SolveOptions:
    """The options that a problem file sets."""
    mapping = reader.mapping(node, "`options`")
    if mapping is None:
        return {}
    reader.keys(mapping, OPTION_KEYS, "`options`")
    budget = reader.mapping(mapping.get("budget"), "`budget`")
    if budget is not None:
        reader.keys(budget, BUDGET_KEYS, "`budget`")
    found: dict[str, Any] = {}
    for path, option in _SAID.items():
        holder = mapping if len(path) == 1 else budget
        value = None if holder is None else _read_option(reader, option, holder.get(path[-1]), f"`{path[-1]}`")
        if value is not None:
            found[option.name] = value
    return cast("SolveOptions", found)


def _read_option(reader: Reader, option: Option, node: YamlNode | None, what: str) -> str | float | None:
    if option.choices:
        return reader.choice(node, option.choices, what)
    if option.kind is int:
        return reader.whole(node, what, option.problem_least)
    if option.kind is bool:
        return reader.boolean(node, what)
    if not option.at_least and option.at_most is None:
        return reader.positive(node, what)
    return reader.between(
        node, what, option.at_least or 0.0, inf if option.at_most is None else option.at_most, option.unit
    )


# -------------------------------------------------------------------------------------- objects and their things
def _check_calls(
    problem: Problem, scene: SceneReading, places: MappingType[str, f.Place], vocabulary: Vocabulary
) -> None:
    """Reports every argument that a procedure can get and that the scene does not have."""
    domain, findings = problem.domain, vocabulary.findings
    wanted: dict[str, dict[str, f.ProcedureCall]] = {}  # by type and kind of thing: the first call that needs it
    calls = _calls_in((problem.goal, domain.update_rules))
    for action in domain.actions.values():
        calls += _calls_in((action.geometry, action.preconditions, action.effects))
    for call in calls:
        for property_, argument in _filled(call, vocabulary.procedures):
            value = argument.value
            if property_.kind in THINGS and isinstance(value, f.Variable):
                wanted.setdefault(value.type, {}).setdefault(property_.kind, call)
            elif property_.kind in THINGS and isinstance(value, f.Constant):
                _check_thing(scene, property_.kind, value.name, value.place, call, findings)
            elif property_.kind in FAMILIES and isinstance(value, f.Constant) and not scene.unsound:
                _check_family(scene, property_, value, findings)
    for name, own_type in problem.objects.items():
        for kind in ancestors(own_type, domain.types):
            for thing, call in wanted.get(kind, {}).items():
                place = places.get(name) or (call.place if call.place is not None else None)
                _check_thing(scene, thing, name, place, call, findings)


def ancestors(kind: str, types: MappingType[str, str | None]) -> Iterator[str]:
    """The type and its supertypes."""
    current: str | None = kind
    while current is not None:
        yield current
        current = types.get(current)


def _filled(
    call: f.ProcedureCall, procedures: MappingType[str, Signature | None]
) -> Iterator[tuple[ProcedureProperty, f.Argument]]:
    """Every argument of a call with the property that it fills."""
    properties = procedures.get(call.procedure)
    if properties is None:
        return  # an external procedure: its arguments were checked by their types
    by_name = {each.name: each for each in properties}
    for number, argument in enumerate(call.arguments):
        yield (properties[number] if argument.name is None else by_name[argument.name]), argument


def _calls_in(trees: object) -> list[f.ProcedureCall]:
    """All procedure calls inside formulas and effects, the last one first."""
    return [node for node in nodes(trees) if isinstance(node, f.ProcedureCall)][::-1]


def _check_thing(
    scene: SceneReading, wanted: str, name: str, place: f.Place | None, call: f.ProcedureCall, findings: Findings
) -> None:
    role = scene.role_of(name)
    description = scene.description
    if role == wanted or description is None or place is None:
        return
    things = {"robot": description.robots, "body": description.bodies, "region": description.regions}[wanted]
    called = f"{spell(call)} at {spell_place(call.place)}" if call.place is not None else spell(call)
    if (role is None and name in scene.places) or (place, wanted) in scene.reported:
        return  # it is there, but something is wrong with it, which was reported
    scene.reported.add((place, wanted))
    problem = f"is a {role} of the scene" if role is not None else f"is no {wanted} of the scene"
    hint = findings.near(name, things.keys())
    findings.add(place, f'"{name}" {problem}; {called} needs a {wanted}', hint)


def _check_family(scene: SceneReading, wanted: ProcedureProperty, value: f.Constant, findings: Findings) -> None:
    description, place = scene.description, value.place
    if description is None or place is None:
        return
    if wanted.kind == "motion_constraint":
        names = set(description.motion_constraints)
    elif wanted.kind == "grasp":
        names = {"any"}.union(*(body.grasps for body in description.bodies.values()))
    else:
        names = {"any"}.union(*(body.placements for body in description.bodies.values()))
    if value.name not in names:
        kind = wanted.kind.replace("_", " ") + (" family" if wanted.kind == "grasp" else "")
        hint = findings.near(value.name, sorted(names - {"any"}))
        findings.add(place, f'the scene has no {kind} "{value.name}"', hint)
