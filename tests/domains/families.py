"""The families without a scene, and the rules by which their problems are made."""

import importlib.util
from collections.abc import Callable
from pathlib import Path

import kabo
from kabo.language.problem import Problem
from tests.domains.scenes import DOMAINS

FAMILIES = sorted(p.parent.name for p in DOMAINS.glob("*/generate.py") if not (p.parent / "scene.yaml").exists())


def rule(family: str) -> Callable[..., str]:
    """The generator of a family."""
    specification = importlib.util.spec_from_file_location(family, DOMAINS / family / "generate.py")
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module.problem


def generated(folder: Path, family: str, **settings: int | bool) -> Problem:
    """A problem of a family, written and read."""
    path = folder / "problem.yaml"
    path.write_text(rule(family)(**settings, home=f"{DOMAINS / family}/"))
    return kabo.load_problem(path)
