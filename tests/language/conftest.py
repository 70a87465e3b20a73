"""A small correct domain, scene and problem, and a way to spoil them at a marked place."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from kabo.language import check_files

DOMAIN = """\
domain: bar
types: [robot, bottle, location]
constants:
  location: [shelf]
predicates:
  hand_empty: [robot]
  grasped: [bottle]
  robot_grasps: [robot, bottle]
  at_location: [bottle, location]
  closed: []
functions:
  content: {arguments: [bottle], value: [water, wine]}
  home_of: {arguments: [bottle], value: location}
  fuel: {arguments: [], value: number}
update_rules:
  - forall(bottle b) (K(grasped(b)) => add(Kf, not at_location(b, shelf)))
actions:
  pick_up:
    parameters: {r: robot, o: bottle}
    preconditions:
      - K(hand_empty(r))
      - K(not grasped(o))
    geometry: pick(r, o, grasp = side)
    effects:
      - add(Kf, not hand_empty(r), grasped(o))
      - K(closed) => del(Kf, closed)
    sense: content(o)
    cost: fuel + 1
  carry:
    parameters: {r: robot, o: bottle}
    preconditions:
      - K(grasped(o))
    geometry: transfer(r, o, shelf, keep = upright)
"""

SCENE = """\
scene: bar
epsilon: 0.02
robots:
  left:
    model: arm
    base: {position: [0, 0.5, 0]}
robot_models:
  arm:
    urdf: arm.urdf
    gripper:
      urdf: gripper.urdf
      mount: tool0
      open: {finger_joint: 0.04}
      closed: {finger_joint: 0}
      touch_links: [left_finger, right_finger]
    tool:
      frame: tool0
      features:
        tcp: {point: [0, 0, 0.1]}
        approach: {line: {through: [0, 0, 0.1], along: [0, 0, 2]}}
    configurations:
      home: [0, -90 deg, 0.5]
models:
  bottle:
    mesh: bottle.stl
    scale: 0.001
    features:
      base: {plane: {through: [0, 0, 0], normal: [0, 0, 1]}}
      axis: {line: {through: [0, 0, 0], along: [0, 0, 1]}}
    grasps:
      side:
        constraints:
          - coincident(tool.tcp, this.axis)
          - height(tool.tcp, this.base) in [0.05, 0.12]
        approach: {along: tool.approach, distance: [0.05, 0.15]}
        lift: {along: world.up, distance: 0.1}
        fingers: {finger_joint: 0.03}
    placements:
      standing:
        constraints:
          - coincident(this.base, support.top)
          - inside(this, region)
objects:
  table: {box: [0.9, 1.6, 0.04], pose: {position: [0, 0, -0.02]}}
  tray: {cylinder: {radius: 0.2, height: 0.01}, pose: {frame: table, rpy: [0, 0, 90 deg]}}
regions:
  shelf:
    box: [0.8, 1.5, 0.4]
    pose: {frame: table, position: [0, 0, 0.17]}
    support: table
motion_constraints:
  upright:
    - angle(this.axis, world.up) <= 10 deg
allowed_contacts:
  - [left.base_link, table]
"""

PROBLEM = """\
problem: one_bottle
domain: domain.yaml
scene: scene.yaml
objects:
  robot: [left]
  bottle: [bottle_1]
bodies:
  bottle_1: {model: bottle, pose: {frame: table, position: [0, 0, 0.02]}}
initial:
  - add(Kf, hand_empty(left), fuel = 2)
  - forall(bottle b) add(Kf, not grasped(b))
goal:
  - K(grasped(bottle_1)) or K(content(bottle_1) = wine)
options: {search: breadth-first, seed: 3, budget: {seconds: 10}}
"""


@dataclass(frozen=True)
class Spoiled:
    """Files with one mistake, and where it is."""

    folder: Path
    file: str
    line: int
    column: int
    length: int


@dataclass(frozen=True)
class Kitchen:
    """Writes the three files into a folder."""

    folder: Path

    @property
    def problem(self) -> Path:
        return self.folder / "problem.yaml"

    def write(self, **changed: str) -> Path:
        """The correct files, some of them replaced; returns the problem's path."""
        texts = {"domain": DOMAIN, "scene": SCENE, "problem": PROBLEM} | changed
        for name, text in texts.items():
            (self.folder / f"{name}.yaml").write_bytes(text.encode())
        for name in ("arm.urdf", "gripper.urdf", "bottle.stl"):
            (self.folder / name).write_bytes(b"never opened")
        return self.problem

    def spoil(self, file: str, old: str, new: str) -> Spoiled:
        """The files with `old` in one of them replaced by `new`; «…» in `new` marks the mistake."""
        text = {"domain": DOMAIN, "scene": SCENE, "problem": PROBLEM}[file]
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {file}"
        text = text.replace(old, new)
        start, end = text.index("«"), text.index("»") - 1
        text = text.replace("«", "").replace("»", "")
        self.write(**{file: text})
        line = text.count("\n", 0, start) + 1
        column = start - text.rfind("\n", 0, start)
        return Spoiled(self.folder, str(self.folder / f"{file}.yaml"), line, column, end - start)

    def expect(self, file: str, old: str, new: str, message: str, hint: str | None) -> None:
        """Spoils the files and asserts that one finding says so, exactly at the mark."""
        spoiled = self.spoil(file, old, new)
        found = check_files([self.problem])
        assert [str(each) for each in found[1:]] == []
        assert found, "nothing was reported"
        one = found[0]
        assert (one.file, one.line, one.column, one.length) == (
            spoiled.file, spoiled.line, spoiled.column, max(1, spoiled.length)
        )  # fmt: skip
        assert one.message == message
        assert one.source is not None
        assert (one.hint or "").startswith(hint or "") and (one.hint is None) == (hint is None)


@pytest.fixture
def kitchen(tmp_path: Path) -> Kitchen:
    return Kitchen(tmp_path)


@pytest.fixture
def write(kitchen: Kitchen) -> Callable[..., Path]:
    return kitchen.write
