"""Stages that need no robot: scenes are numbers on a line, or tuples of them; registered once as `line/…`."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from kabo.tasks.core import (
    Connector,
    Failure,
    Generator,
    Monitor,
    Propagator,
    Property,
    Result,
    Wrapper,
    forward,
)
from kabo.tasks.files import register

Values = Mapping[str, Any]


class Start(Generator):
    """The first scene as it is."""

    def generate(self, scene: Any, properties: Values, seed: int) -> Any:
        return [Result(scene)]


class Points(Generator):
    """A scene for each of some numbers; negative ones are refused."""

    PROPERTIES = {"points": Property(list), "label": Property(str, "point")}

    def generate(self, scene: Any, properties: Values, seed: int) -> Iterator[Any]:
        for point in properties["points"]:
            if point < 0:
                yield Failure("below_zero", f"{properties['label']} {point} is below zero")
            else:
                yield Result(
                    point, cost=point / 10, comment=f"{properties['label']} {point}", properties={"goal": point}
                )


class Near(Monitor):
    """A scene near the end of what it monitors."""

    PROPERTIES = {"by": Property(float, 1.0)}

    def generate(self, scene: Any, properties: Values, seed: int) -> Any:
        return [Result(scene + properties["by"], properties={"goal": scene + properties["by"]})]


class Step(Propagator):
    """Goes on by a step, either way."""

    PROPERTIES = {
        "by": Property(float, 1.0),
        "flag": Property(bool, False),
        "mode": Property((str, float), "any"),
        "note": Property(default=""),
        "pair": Property(tuple, ()),
        "table": Property(dict, {}),
        "count": Property(int, 1),
    }

    def forward(self, scene: Any, properties: Values, seed: int) -> Any:
        return [Result(scene + properties["by"], cost=abs(properties["by"]), comment=f"by {properties['by']}")]

    def backward(self, scene: Any, properties: Values, seed: int) -> Any:
        return [Result(scene - properties["by"], cost=abs(properties["by"]))]


class Way(Connector):
    """Joins what is no farther apart than `reach`."""

    PROPERTIES = {"reach": Property(float, 100.0)}

    def mismatch(self, start: Any, end: Any, properties: Values) -> str | None:
        return "too far apart" if abs(start - end) > properties["reach"] else None

    def connect(self, start: Any, end: Any, properties: Values, seed: int) -> Any:
        return [Result(cost=abs(end - start))]


class Below(Wrapper):
    """Lets through what ends below a limit."""

    PROPERTIES = {"limit": Property(float)}

    def transform(self, solution: Any, properties: Values, seed: int) -> Any:
        if solution.end.scene > properties["limit"]:
            return [Failure("too_high", f"{solution.end.scene} is above {properties['limit']}")]
        return [Result(cost=solution.cost, comment=solution.comment)]


@forward(by=2.0)
def double(scene: Any, properties: Values, seed: int) -> Any:
    """Doubles."""
    return [Result(scene * properties["by"])]


for kind in (Start, Points, Near, Step, Way, Below, double):
    register(kind, f"line/{kind.__name__}")

TASK = """\
name: line
properties:
  by: {type: number, default: 1.5}
  target: {type: any}
  mode: {type: name, default: slow}
max_solutions: 3
timeout: 20
stages:
  - name: start
    stage: line/Start
  - name: go
    stage: line/Way
    reach: 50
  - name: grasp
    stage: SerialContainer
    depth: 0.25
    stages:
      - name: approach
        stage: line/Step
        by: <PARENT>
        mode: <PARENT>
      - name: low enough
        stage: line/Below
        limit: 40
        wrapped:
          name: pose
          stage: line/Points
          points: <PARENT:target>
          label: place
      - name: lift
        stage: line/Step
        by: <PARENT:depth>
        note: [<INTERFACE:goal>, {deep: <PARENT:by>}, "1.0", off]
"""


def write(folder: Path, text: str = TASK, name: str = "task.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path
