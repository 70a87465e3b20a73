"""Scenes of tasks, and what every test of stages needs."""

from collections.abc import Callable
from pathlib import Path

import pytest

from kabo.geometry_server import GeometryServer
from kabo.language import load_problem
from kabo.scene import Scene, load_scene
from kabo.tasks.robots import TaskScene

DOMAINS = Path(__file__).resolve().parent.parent.parent.parent / "domains"
_SCENES: dict[str, Scene] = {}


def first(problem: str, *, seed: int = 0, effort: int = 0) -> TaskScene:
    """The first scene of a problem of the domains; the scene's files are read once."""
    if problem not in _SCENES:
        description = load_problem(DOMAINS / problem).scene
        assert description is not None
        _SCENES[problem] = load_scene(description)
    scene = _SCENES[problem]
    return TaskScene.of(GeometryServer(scene, seed=seed).context(effort), scene.start)


@pytest.fixture
def first_scene() -> Callable[..., TaskScene]:
    """Makes the first scene of a problem of the domains."""
    return first
