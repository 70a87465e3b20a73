"""An exploration whose valid set is known: a disc, or two of them, with a smooth outcome and two reasons why not."""

from math import hypot
from pathlib import Path

from kabo.exploration import Exploration, Space

FILE = """\
exploration: disc
trial: tests/Disc
parameters:
  along: {from: -0.08, to: 0.08, unit: m}
  force: {from: 1, to: 40, unit: N}
cases: {bar: [steel, wood]}
outcomes: {torque: {unit: Nm}}
start: {along: 0.0, force: 20}
retry: {dropped: {force: 2}}
"""
STAGES = """\
import random
from math import hypot
from kabo.trials import Invalid, Valid, register

def disc(case, parameters, seed):
    along, force = parameters["along"], parameters["force"]
    if hypot((along - 0.01) / 0.05, (force - 22) / 12) > 1:
        return Invalid("dropped" if force < 22 else "crushed")
    return Valid({"torque": 60 * (along - 0.01) + random.Random(seed).gauss(0, 0.02)})

register(disc, "tests/Disc")
"""


def write_files(folder: Path) -> None:
    """Writes `disc.yaml`, and `disc.py` with its trial function."""
    (folder / "disc.yaml").write_text(FILE)
    (folder / "disc.py").write_text(STAGES)


def explored(trials: int = 60, names: tuple[str, ...] = ("along", "force"), outcomes: int = 1) -> Exploration:
    """An exploration of a ball of radius 0.35 in the middle of the unit cube, without cases."""
    space = Space(dict.fromkeys(names, (0.0, 1.0)), units={names[0]: "m"})
    told = [f"torque_{k}" if k else "torque" for k in range(outcomes)]
    made = Exploration(space, told, start=dict.fromkeys(names, 0.5), units={"torque": "Nm"}, name="ball")
    for _ in range(trials):
        parameters = made.ask().parameters
        if hypot(*(value - 0.5 for value in parameters.values())) > 0.35:
            made.tell({}, parameters, False, reason="dropped" if parameters[names[0]] < 0.5 else "crushed")
        else:
            made.tell({}, parameters, True, {name: parameters[names[0]] + k for k, name in enumerate(told)})
    return made
