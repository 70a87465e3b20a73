"""The language room: from files to a Problem.

YAML with places, one grammar for formulas, every name resolved and every type checked; all findings at once, as
diagnostics. It reads text and makes values: it evaluates nothing and opens no mesh.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kabo.language.loading import check_files, load_problem, load_scene_description, own_task_files
    from kabo.language.problem import Action, Domain, Function, Options, Parameter, Problem
    from kabo.language.procedures import Procedures, Property
    from kabo.language.scene_description import SceneDescription
    from kabo.language.spelling import spell, spell_number

_HOMES = {
    "Action": "problem",
    "Domain": "problem",
    "Function": "problem",
    "Options": "problem",
    "Parameter": "problem",
    "Problem": "problem",
    "Procedures": "procedures",
    "Property": "procedures",
    "SceneDescription": "scene_description",
    "check_files": "loading",
    "load_problem": "loading",
    "load_scene_description": "loading",
    "own_task_files": "loading",
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
