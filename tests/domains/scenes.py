"""The problems under domains/, and their scenes."""

from functools import cache
from pathlib import Path

import kabo
from kabo.language.problem import Problem
from kabo.scene import Scene

DOMAINS = Path(__file__).resolve().parents[2] / "domains"
PROBLEMS = sorted(path for path in DOMAINS.glob("*/*.yaml") if path.stem not in {"domain", "scene"})
WITH_SCENE = [path for path in PROBLEMS if (path.parent / "scene.yaml").exists()]


@cache
def problem_of(path: Path) -> Problem:
    """A problem of the repository."""
    return kabo.load_problem(path)


@cache
def scene_of(path: Path) -> Scene:
    """Its scene."""
    description = problem_of(path).scene
    assert description is not None
    return kabo.load_scene(description)
