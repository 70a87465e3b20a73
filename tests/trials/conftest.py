"""A task without robots that explorations plan: jumps that need the more tries, and thus jobs, the farther they go."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from kabo.tasks.core import Failure, Generator, Propagator, Property, Result
from kabo.tasks.files import register

TASK = """\
name: jump
properties:
  far: {type: number}
  ground: {type: name, default: grass}
  landing: {type: any, default: {at: [0, 0]}}
stages:
  - {name: tries, stage: jumping/Tries}
  - {name: jump, stage: jumping/Jump, far: <PARENT>, ground: <PARENT>, landing: <PARENT>}
"""
JUMPS = """\
exploration: jumps
trial:
  task: task.yaml
  jobs: 30
  properties: {landing: {at: [<PARAMETER:side>, 0]}}
parameters: {far: {from: 0, to: 4, unit: m}, side: {from: -1, to: 1}}
cases: {ground: [grass, ice]}
outcomes: {cost: {unit: J}}
start: {far: 0.5, side: 0}
"""


class Tries(Generator):
    """Thirty tries, one after the other."""

    def generate(self, scene: Any, properties: Mapping[str, Any], seed: int) -> Iterator[Any]:
        for number in range(30):
            yield Result(number)


def too_far(value: float) -> str | None:
    return None if value <= 4.0 else f"is at most 4, not {value:g}"


class Jump(Propagator):
    """Jumps with the first try that is good enough; one wide of the middle is refused, and ice takes more tries."""

    PROPERTIES = {"far": Property(float, wrong=too_far), "ground": Property(str), "landing": Property(dict)}

    def forward(self, scene: Any, properties: Mapping[str, Any], seed: int) -> Any:
        far, (side, _) = properties["far"], properties["landing"]["at"]
        if abs(side) > 0.5:
            return [Failure("beside", f"{side:g} beside the middle")]
        if scene < 10 * far - 5 + 3 * (properties["ground"] == "ice"):
            return [Failure("too_short", f"try {scene} is not enough")]
        return [Result(scene, cost=far + 0.01 * scene)]


for each in (Tries, Jump):
    register(each, f"jumping/{each.__name__}")


@pytest.fixture
def jumps(tmp_path: Path) -> Path:
    """The exploration file of jumps, with its task beside it."""
    (tmp_path / "task.yaml").write_text(TASK)
    path = tmp_path / "jumps.yaml"
    path.write_text(JUMPS)
    return path
