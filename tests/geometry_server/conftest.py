"""The scenes of the domains, loaded once, and servers that share nothing but them."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from kabo.geometry_server import GeometryServer
from kabo.language import load_problem
from kabo.scene import Scene, load_scene

DOMAINS = Path(__file__).resolve().parent.parent.parent / "domains"


@cache
def scene_of(problem: str) -> Scene:
    """The scene of a problem file of the domains."""
    description = load_problem(DOMAINS / problem).scene
    assert description is not None
    return load_scene(description)


@pytest.fixture
def server() -> Callable[..., GeometryServer]:
    """Makes a new server, with no memory, for a problem of the domains."""
    return lambda problem, **options: GeometryServer(scene_of(problem), **options)
