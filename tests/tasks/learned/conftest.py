"""Tasks without robots, on a line: a step as long as a model says."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from kabo.exploration import Exploration
from kabo.tasks import load_task
from kabo.tasks.core import Task
from tests.support.bars import explored
from tests.tasks.files.conftest import write

explored_once = cache(explored)
HOLD = """name: hold
stages:
  - {name: start, stage: line/Start}
  - name: where
    stage: LearnedParameters
    model: model.jsonl
    where: {bar: steel}
    target: {torque: 0.0}
  - {name: step, stage: line/Step, by: <INTERFACE:along>}
"""


@pytest.fixture(scope="session")
def known() -> Exploration:
    """An exploration of bars of steel; those of wood were not tried."""
    return explored_once()


@pytest.fixture
def hold(tmp_path: Path, known: Exploration) -> Callable[..., Task]:
    """Makes the task in whose file some words are replaced by others."""

    def made(*changes: tuple[str, str], arguments: dict[str, Any] | None = None) -> Task:
        known.save(tmp_path / "model.jsonl")
        text = HOLD
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        return load_task(write(tmp_path, text), arguments)

    return made
