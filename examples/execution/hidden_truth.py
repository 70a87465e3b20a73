"""BARTENDER in physics: nobody knows which bottles are empty, and the hands find out by their weight.

    python examples/execution/hidden_truth.py [SEED ...]

Needs `pip install "kabo[simulation]"`. For each seed other bottles are empty; the goal is looked for in the simulation.
"""

import sys
from pathlib import Path

import kabo
from kabo.execution import Log, SimulatedSensors, execute
from kabo.language import TruthDescription, load_sensors
from kabo.simulation import PhysicsInstruments, SimulatedRobot

FOLDER = Path(__file__).parent
EMPTY, FULL = 0.1, 0.45  # kg; the scene says 0.3


def carried_out(problem, plan, scene, sensors, masses, seed):
    """The run and the names of the bottles that stand in the dishwasher, in the simulation."""
    robot, log = SimulatedRobot(scene, masses=masses), Log()
    instruments = PhysicsInstruments(robot, sensors)
    sensor = SimulatedSensors(sensors, instruments, TruthDescription(masses=masses), seed, log)
    run = execute(plan, scene, robot, sensor, log=log)
    crate = robot.physics.pose("crate")[:3, 3]
    washed = {o for o, pose in robot.poses().items() if (abs(pose[:3, 3] - crate) < [0.16, 0.16, 0.05]).all()}
    return run, washed


def main(seeds):
    """Plans once, and carries the plan out in a world for each seed."""
    problem = kabo.load_problem(FOLDER / "problem.yaml")
    plan, scene = kabo.solve(problem).plan, kabo.load_scene(FOLDER / "problem.yaml")
    sensors = load_sensors(FOLDER / "sensors.yaml", problem)
    for seed in seeds:
        masses = {f"bottle_{k + 1}": EMPTY if seed >> k & 1 else FULL for k in range(4)}
        run, washed = carried_out(problem, plan, scene, sensors, masses, seed)
        right = washed == {bottle for bottle, mass in masses.items() if mass == EMPTY}
        looks = sum(record["looks"] for record in run.log.of("looked"))
        told = (
            f"seed {seed}: {run.reason}; {looks} looks, washed {sorted(washed)}: {'right' if right else 'WRONG'}"
        )
        sys.stdout.write(f"{told}\n")


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [0, 5, 9, 15])
