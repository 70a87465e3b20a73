"""The language room: from files to a Problem.

YAML, PDDL, contingent PDDL and PKS XML become the one kind of problem that kabo plans for, every name resolved and
every type checked; all findings at once, as diagnostics with places. What kabo cannot say is refused by name and place,
never dropped. It reads text and makes values: it evaluates nothing and opens no mesh.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kabo.language.problem import Action, Domain, Function, Options, Parameter, Problem
    from kabo.language.reading import check_files, is_imported, load_problem
    from kabo.language.scene_description import SceneDescription
    from kabo.language.spelling import spell, spell_number
    from kabo.language.task_description import Property
    from kabo.language.yaml.loading import load_scene_description, own_task_files
    from kabo.language.yaml.procedures import Procedures

_HOMES = {
    "Action": "problem",
    "Domain": "problem",
    "Function": "problem",
    "Options": "problem",
    "Parameter": "problem",
    "Problem": "problem",
    "Procedures": "yaml.procedures",
    "Property": "task_description",
    "SceneDescription": "scene_description",
    "check_files": "reading",
    "is_imported": "reading",
    "load_problem": "reading",
    "load_scene_description": "yaml.loading",
    "own_task_files": "yaml.loading",
    "spell": "spelling",
    "spell_number": "spelling",
}

__all__ = [
    "Action",
    "Domain",
    "Function",
    "Options",
    "Parameter",
    "Problem",
    "Procedures",
    "Property",
    "SceneDescription",
    "check_files",
    "is_imported",
    "load_problem",
    "load_scene_description",
    "own_task_files",
    "spell",
    "spell_number",
]


def __getattr__(name: str) -> Any:
    """Loads the file that offers `name` when it is first asked for [PEP 562]."""
    if name not in _HOMES:
        raise AttributeError(f"module 'kabo.language' has no attribute {name!r}")
    value = getattr(import_module(f"kabo.language.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
