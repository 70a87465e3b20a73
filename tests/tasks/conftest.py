"""The scenes of the domains, loaded once, and procedures that share nothing but them."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from kabo.geometry_server import GeometryServer
from kabo.language import load_problem
from kabo.scene import Scene, load_scene
from kabo.tasks.procedures import GeometricProcedures

DOMAINS = Path(__file__).resolve().parent.parent.parent / "domains"


@cache
def scene_of(problem: str) -> Scene:
    """The scene of a problem file of the domains."""
    description = load_problem(DOMAINS / problem).scene
    assert description is not None
    return load_scene(description)


@pytest.fixture
def server() -> Callable[..., GeometricProcedures]:
    """Makes new procedures, with no memory, for a problem of the domains."""

    def made(problem: str, **options: object) -> GeometricProcedures:
        return GeometricProcedures(GeometryServer(scene_of(problem), **options), (DOMAINS / problem).parent)  # type: ignore[arg-type]

    return made
