"""A synthetic exploration of lifting bars: which grips are valid and what torque they give is known in closed form."""

from pathlib import Path

from kabo.exploration import Exploration, Space, Validity, halton

BALANCE = {"steel": 0.02, "wood": -0.03}  # m from the middle: where a bar hangs level
WEIGHT = 5.0  # N


def torque(bar: str, along: float) -> float:
    """The torque at the wrist [Nm] if a bar is held `along` metres from its middle."""
    return WEIGHT * (along - BALANCE[bar])


def is_valid(bar: str, along: float, force: float) -> bool:
    """Whether a grip holds: hard enough for where it is, and not so hard that the bar is crushed."""
    return 6.0 + 100.0 * abs(along - BALANCE[bar]) < force < 28.0


def explored(trials: int = 60, *, bars: tuple[str, ...] = ("steel",), scale: float = 0.12) -> Exploration:
    """An exploration with as many trials of each of some bars, spread evenly over the whole space."""
    space = Space(
        {"along": (-0.08, 0.08), "force": (1.0, 40.0)}, {"bar": ["steel", "wood"]}, {"along": "m", "force": "N"}
    )
    made = Exploration(space, ["torque"], validity=Validity(scale=scale), units={"torque": "Nm"}, name="bars")
    for bar in bars:
        for index in range(trials):
            parameters = space.named(space.rounded(halton(index, 2)[None])[0][0])
            valid = is_valid(bar, **parameters)
            outcomes = {"torque": torque(bar, parameters["along"])} if valid else None
            made.tell({"bar": bar}, parameters, valid, outcomes, "" if valid else "dropped")
    return made


def write_model(folder: Path, name: str = "model.jsonl", **options: object) -> Path:
    """The journal of such an exploration in a folder."""
    path = folder / name
    explored(**options).save(path)  # type: ignore[arg-type]
    return path


GANTRY = """<robot name="gantry">
  <link name="base"/>
  <link name="hand"><collision><geometry><box size="0.04 0.04 0.04"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="base"/><child link="hand"/><axis xyz="1 0 0"/>
    <limit lower="-0.5" upper="0.5" velocity="1" effort="1"/></joint>
</robot>
"""
SCENE = """scene: bench
epsilon: 0.01
robots:
  arm:
    urdf: gantry.urdf
    configurations: {home: [0]}
objects:
  wall: {box: [0.02, 0.4, 0.4], pose: {position: [0.3, 0, 0]}}
"""
DOMAIN = """domain: bars
types: [robot, bar]
predicates:
  above: [robot, bar]
actions:
  aim:
    parameters: {r: robot, b: bar}
    geometry: aim(r, b)
    effects:
      - add(Kf, above(r, b))
"""
PROBLEM = """problem: aim
domain: domain.yaml
scene: scene.yaml
objects:
  robot: [arm]
  bar: [steel, wood]
initial:
  - forall(robot r, bar b) add(Kf, not above(r, b))
goal:
  - K(above(arm, steel))
"""
AIM = """name: aim
properties:
  robot: {type: robot}
  bar: {type: name}
stages:
  - {name: start, stage: CurrentState}
  - name: where
    stage: LearnedParameters
    model: ../model.jsonl
    where: {bar: <PARENT:bar>}
    target: {torque: 0.0}
  - name: move
    stage: MoveRelative
    direction: {joints: {x: <INTERFACE:along>}}
"""


def write_domain(folder: Path, *, task: str = AIM, **options: object) -> Path:
    """The problem of moving a gantry to where a bar hangs level, with its domain, scene, task and model."""
    (folder / "tasks").mkdir(parents=True, exist_ok=True)
    texts = {"gantry.urdf": GANTRY, "scene.yaml": SCENE, "domain.yaml": DOMAIN, "tasks/aim.yaml": task}
    for name, text in texts.items():
        (folder / name).write_text(text)
    write_model(folder, **options)  # type: ignore[arg-type]
    path = folder / "problem.yaml"
    path.write_text(PROBLEM)
    return path
