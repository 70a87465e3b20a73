"""A problem as YAML text, and whether reading that gives the same problem: the imports make what the language makes."""

from pathlib import Path

from kabo import load_problem
from kabo.errors import Diagnostic, InputError
from kabo.language import check_files
from kabo.language.problem import Action, Domain, Function, Problem
from kabo.language.spelling import spell


def domain_text(domain: Domain) -> str:
    """The domain as a YAML file has it."""
    lines = [f"domain: {domain.name}", "types:", *_types(domain, None, "  ")]
    lines += ["constants:", *_by_type(domain.constants)] if domain.constants else []
    lines += ["predicates:"] if domain.predicates else []
    lines += [f"  {name}: [{', '.join(kinds)}]" for name, kinds in domain.predicates.items()]
    lines += ["functions:"] if domain.functions else []
    lines += [_function(each) for each in domain.functions.values()]
    lines += ["update_rules:", *_list(domain.update_rules, "  ")] if domain.update_rules else []
    lines += ["actions:"] if domain.actions else ["actions: {}"]
    for action in domain.actions.values():
        lines += _action(action)
    return "\n".join(lines) + "\n"


def problem_text(problem: Problem) -> str:
    """The problem as a YAML file has it; its domain is domain.yaml."""
    own = {name: kind for name, kind in problem.objects.items() if name not in problem.domain.constants}
    lines = [f"problem: {problem.name}", "domain: domain.yaml"]
    lines += ["objects:", *_by_type(own)] if own else []
    lines += ["initial:", *_list(problem.initial, "  ")] if problem.initial else []
    lines += ["goal:", *_list(problem.goal, "  ")] if problem.goal else ["goal: 'true'"]
    return "\n".join(lines) + "\n"


def _types(domain: Domain, parent: str | None, indent: str) -> list[str]:
    lines = []
    for kind, above in domain.types.items():
        if above == parent:
            lines += [f"{indent}{kind}:", *_types(domain, kind, indent + "  ")]
    return lines


def _by_type(names: dict[str, str]) -> list[str]:
    kinds = dict.fromkeys(names.values())
    return [f"  {kind}: [{', '.join(n for n, own in names.items() if own == kind)}]" for kind in kinds]


def _function(function: Function) -> str:
    value = function.value_type or (f"[{', '.join(function.values)}]" if function.values else "number")
    return f"  {function.name}: {{arguments: [{', '.join(function.arguments)}], value: {value}}}"


def _list(trees: tuple, indent: str) -> list[str]:
    return [f"{indent}- {spell(tree)}" for tree in trees]


def _action(action: Action) -> list[str]:
    lines = [f"  {action.name}:"]
    lines += ["    parameters:"] if action.parameters else []
    for parameter in action.parameters:
        kind = parameter.type if parameter.value_of is None else f"{{value_of: {spell(parameter.value_of)}}}"
        if parameter.value_of is not None:
            kind = f'{{value_of: "{spell(parameter.value_of)}"}}'
        lines.append(f"      {parameter.name}: {kind}")
    lines += ["    preconditions:", *_list(action.preconditions, "      ")] if action.preconditions else []
    lines += ["    effects:", *_list(action.effects, "      ")] if action.effects else []
    lines += ["    sense:", *_list(action.sense, "      ")] if action.sense else []
    return [*lines, f"    cost: {spell(action.cost)}"]


def assert_as_written(problem: Problem, folder: Path) -> None:
    """The problem says the same as the one that the language room reads from its YAML text."""
    folder.mkdir(exist_ok=True)
    (folder / "domain.yaml").write_text(domain_text(problem.domain))
    (folder / "problem.yaml").write_text(problem_text(problem))
    again = load_problem(folder / "problem.yaml")
    for name in ("name", "initial", "options", "scene"):
        assert getattr(again, name) == getattr(problem, name), name
    assert again.goal == problem.goal or (not problem.goal and len(again.goal) == 1)
    assert dict(again.objects) == dict(problem.objects)
    for name in ("name", "types", "constants", "predicates", "functions", "update_rules"):
        assert getattr(again.domain, name) == getattr(problem.domain, name), name
    for action in problem.domain.actions.values():
        assert again.domain.actions[action.name] == action
    assert list(again.domain.actions) == list(problem.domain.actions)


def read(folder: Path, *texts: str, ending: str = "pddl", written: bool = True) -> Problem:
    """The problem of one or two texts; by default also compared with its YAML text."""
    paths = []
    for number, text in enumerate(texts):
        paths.append(folder / f"file_{number}.{ending}")
        paths[-1].write_text(text)
    problem = load_problem(*paths)
    if written:
        assert_as_written(problem, folder / "as_yaml")
    return problem


def refused(folder: Path, *texts: str, ending: str = "pddl") -> tuple[Diagnostic, ...]:
    """The findings because of which one or two texts are refused."""
    try:
        read(folder, *texts, ending=ending, written=False)
    except InputError as error:
        return error.diagnostics
    raise AssertionError("nothing was refused")


def warnings(folder: Path, *texts: str, ending: str = "pddl") -> list[Diagnostic]:
    """What `kabo check` says of one or two texts."""
    read(folder, *texts, ending=ending, written=False)
    return check_files(sorted(folder.glob(f"file_*.{ending}")))


def effects(problem: Problem, action: str) -> list[str]:
    """The effects of an action as text."""
    return [spell(each) for each in problem.domain.actions[action].effects]


def preconditions(problem: Problem, action: str) -> list[str]:
    """The preconditions of an action as text."""
    return [spell(each) for each in problem.domain.actions[action].preconditions]


def initial(problem: Problem) -> list[str]:
    """The initial updates as text."""
    return [spell(each) for each in problem.initial]
