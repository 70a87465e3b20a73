"""What a file given to the viewer is, and where the problem of a plan is."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from kabo.errors import Diagnostic, InputError
from kabo.language import is_imported, kind_of_file, load_problem, load_scene_description
from kabo.language.problem import Problem
from kabo.plan import READABLE_FORMATS, Plan
from kabo.verify.scene_alone import scene_alone
from kabo.viewer.content.document import Given
from kabo.whole_files import file_hash

DEPTHS = (
    "",
    "*/",
    "*/*/",
)  # of the folders below the plan's and the working one in which its problem is looked for
EXPECTED = (
    "a scene, problem or task file (YAML, PDDL, PKS), a plan (`kabo solve`), a report (`kabo task plan -o`) "
    "or an explanation (`kabo explain --json`)"
)


@dataclass(frozen=True)
class GivenFile:
    """A file and what it is; `content` is what a JSON file holds."""

    path: Path
    kind: Given
    content: Any = None


def given_file(path: Path) -> GivenFile:
    """What a file is.

    Raises:
        InputError: it is nothing that can be viewed, or cannot be read.
        OSError: it cannot be opened.
    """
    if is_imported(path):
        return GivenFile(path, "problem")
    if path.suffix.lower() == ".json":
        return _json_file(path)
    kind = kind_of_file(path)
    if kind not in ("scene", "problem", "task"):
        what = (
            "nothing that can be viewed"
            if kind is None
            else f"a file of kind {kind}, which shows nothing by itself"
        )
        raise _refusal(path, f"this is {what}", f"give {EXPECTED}")
    return GivenFile(path, cast("Given", kind))


def _json_file(path: Path) -> GivenFile:
    text = path.read_bytes()
    try:
        content = json.loads(text, parse_constant=_refuse)
    except RecursionError:
        raise _refusal(path, "this JSON has too many brackets inside each other", f"give {EXPECTED}") from None
    except ValueError as error:  # of JSON, or of UTF-8
        line, column = getattr(error, "lineno", 1), getattr(error, "colno", 1)
        raise InputError([Diagnostic(str(path), line, column, f"this is no JSON: {error}", None)]) from None
    keys = content.keys() if isinstance(content, dict) else set()
    name = content.get("format") if isinstance(content, dict) else None
    if name in READABLE_FORMATS:
        return GivenFile(path, "plan", content)
    if name in ("kabo-task/1", "kabo-task/2"):
        return GivenFile(path, "report", content)
    if {"verdict", "counterfactuals"} <= keys:
        return GivenFile(path, "explanation", content)
    what = f'the format "{name}" is not known here' if name else "this JSON has no `format` of kabo"
    raise _refusal(path, what, f"give {EXPECTED}")


def _refuse(word: str) -> float:
    raise ValueError(f"{word} is no number of JSON")


def _refusal(path: Path, message: str, hint: str) -> InputError:
    return InputError([Diagnostic(str(path), 1, 1, message, hint)])


def problem_of_plan(plan: Plan, path: Path, given: Path | None = None, domain: Path | None = None) -> Problem:
    """The problem of a plan: the given file, or one that is found by its name and its hash near the plan or here.

    The plan of a task has a scene instead of a problem.

    Raises:
        InputError: no such file is there, which says how to name it; or the files have errors.
    """
    found = _found_near(plan, path) if given is None else given
    if domain is None and not is_imported(found) and kind_of_file(found) == "scene":
        return scene_alone(load_scene_description(found), plan)
    return load_problem(found, domain)


def _found_near(plan: Plan, path: Path) -> Path:
    """The problem file for which a plan was made, else its scene file; by name and hash.

    Raises:
        InputError: no such file is there; says how to name it.
    """
    same = [found for found in _candidates(plan, path) if file_hash(found) in plan.files.values()]
    for fits in (_is_problem, _is_scene):
        for found in same:
            if fits(found):
                return found
    names = [name for name in plan.files if "/" not in name]
    looked = f"its problem is none of {', '.join(sorted(names))} in or below the folder of the plan, or this one"
    raise _refusal(path, f'the problem "{plan.problem}" of this plan was not found', f"{looked}: --problem FILE")


def _candidates(plan: Plan, path: Path) -> Iterator[Path]:
    """The files near a plan that are called like one of those that it was made from."""
    for name in plan.files:
        if Path(name).suffix.lower() in (".yaml", ".yml", ".pddl", ".xml", ".pks") and "/" not in name:
            for depth in DEPTHS:
                for folder in dict.fromkeys((path.parent, Path())):
                    yield from sorted(folder.glob(depth + name))


def _is_problem(path: Path) -> bool:
    return path.suffix.lower() in (".xml", ".pks", ".pddl") or kind_of_file(path) == "problem"


def _is_scene(path: Path) -> bool:
    return not is_imported(path) and kind_of_file(path) == "scene"
