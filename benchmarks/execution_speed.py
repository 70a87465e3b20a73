"""How fast is carrying out? Sections `speed`, `late` and `repair` of benchmarks/execution.py; seconds are of the processor.

`speed`: simulated seconds in one second at 1 kHz, watching at 100 Hz and the judge of contacts included, at best of some
runs, beside the steps of MuJoCo alone. `late`: runs of robots that follow late, or of which one motor has half its torque,
unknown to the executor. `repair`: answers after one body was pushed, beside a fresh solve of the state that was answered.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from table import ROOT, Table, percentile

import kabo
from kabo.execution import Answer, Interruption, KinematicRobot, KnownTruth, Run, execute
from kabo.plan import Plan
from kabo.recovery import Replanner
from kabo.scene import Scene
from kabo.simulation import ContactJudge, Physics, SimulatedRobot

PROBLEMS = (
    "domains/stacked/n2.yaml",
    "domains/stacked/n4.yaml",
    "domains/force_sensing/n2.yaml",
    "domains/circular_rearrange/n3.yaml",
    "domains/bartender/four_bottles.yaml",
    "examples/two_cans/problem.yaml",
)
PUSHES = ((0.02, 0.01), (-0.015, 0.02))  # [m]
SINCE = (0.0, 2.0)  # [s]
WEAK = 1, 2  # motors: of a shoulder and an elbow, which bear most
DELAYS = (0.01, 0.02, 0.04)  # [s]


def _solved(path: Path, **more: Any) -> tuple[Any, Scene, Plan]:
    problem = kabo.load_problem(path)
    plan = kabo.solve(problem, **more).plan
    if plan is None:
        raise ValueError(f"{path} was not solved")
    return problem, kabo.load_scene(problem.scene), plan


def _paths(options: argparse.Namespace) -> list[Path]:
    return [ROOT / name for name in options.problems or PROBLEMS]


def speed(options: argparse.Namespace) -> Table:
    """A row for each problem: real-time factors."""
    table = Table("Real-time factor at 1 kHz")
    for path in _paths(options):
        problem, scene, plan = _solved(path)
        factors, run = [], None
        for _ in range(options.rounds):
            robot, judge = SimulatedRobot(scene), ContactJudge(scene)
            robot.judge = judge.look
            begun, clock = process_time(), robot.physics.time
            run = execute(plan, scene, robot, KnownTruth(poses=robot.poses))
            factors.append((robot.physics.time - clock) / (process_time() - begun))
        model = robot.physics.model
        sizes = {
            "arms": len(scene.robots),
            "bodies": int(model.nbody),
            "geoms": int(model.ngeom),
            "dof": int(model.nv),
        }
        alone = _alone(robot)
        table.add(
            problem.name, **sizes, goal=run is not None and run.reached_goal, factor=max(factors), mujoco=alone
        )
    return table


def _alone(robot: SimulatedRobot, steps: int = 2000) -> float:
    """The real-time factor of MuJoCo's steps alone, where the run has ended."""
    physics, best = robot.physics, np.inf
    for _ in range(3):
        begun = process_time()
        for _ in range(steps):
            physics._mujoco.mj_step(physics.model, physics.data)
        best = min(best, process_time() - begun)
    return float(steps * physics.model.opt.timestep / best)


def late(options: argparse.Namespace) -> Table:
    """A row for each problem and fault: how runs of late or weak robots end, with recovery, and without slowing down."""
    table = Table("Late controllers and weak motors, unknown to the executor")
    for path in _paths(options):
        problem, scene, plan = _solved(path)
        for delay in DELAYS:
            run, robot = _disturbed(problem, scene, plan, delay=delay)
            table.add(f"{problem.name}, {1000 * delay:g} ms late", **_ended(run, robot))
        for number in WEAK:
            weak = _Weak(number)
            run, robot = _disturbed(problem, scene, plan, disturb=weak)
            table.add(f"{problem.name}, {weak.name} has half its torque", **_ended(run, robot))
    return table


class _Weak:
    """Half the torque of one motor, from a second on."""

    def __init__(self, number: int) -> None:
        self.number, self.name = number, ""

    def __call__(self, physics: Physics) -> None:
        if not self.name and physics.time > 1.0:
            self.name = physics.motors[self.number].name
            physics.model.actuator_gainprm[self.number, 0] *= 0.5


def _disturbed(problem: Any, scene: Scene, plan: Plan, **how: Any) -> tuple[Run, SimulatedRobot]:
    robot = SimulatedRobot(scene, **how)
    memo = kabo.Memo.of_plan(problem, plan)
    recovery = Replanner(problem, scene, memo=memo)
    return execute(plan, scene, robot, KnownTruth(poses=robot.poses), recovery=recovery), robot


def _ended(run: Run, robot: SimulatedRobot) -> dict[str, Any]:
    shares = [each["share"] for each in run.log.of("followed")]
    paces = [each["rate"] for each in run.log.of("pace")]
    stops = len(list(run.log.of("stopping")))
    more = {"slowest": min(paces, default=1.0), "changes": len(paces), "most_of_proven": max(shares, default=0.0)}
    return {"goal": run.reached_goal, "stops": stops, **more, "seconds": robot.physics.time}


class _Pushed(KinematicRobot):
    """Somebody pushes a body along the horizontal, at a time or later, as soon as it stands."""

    def __init__(self, scene: Scene, body: str, offset: tuple[float, float], since: float) -> None:
        super().__init__(scene)
        self.body, self.offset, self.since = body, offset, since

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        own = self.world.objects[self.body]
        if self.time >= self.since and own.parent == "world":
            x, y, z = own.position
            moved = replace(own, position=(x + self.offset[0], y + self.offset[1], z))
            self.world, self.since = self.world.replace({self.body: moved}), np.inf


class _Timed(Replanner):
    """Keeps the seconds of each answer, and what was asked."""

    def __init__(self, *given: Any, **more: Any) -> None:
        super().__init__(*given, **more)
        self.asked: list[tuple[Interruption, Answer, float]] = []

    def answer(self, interruption: Interruption) -> Answer:
        begun = process_time()  # until the first motion is proven; the rest comes while robots move
        found = super().answer(interruption)
        self.asked.append((interruption, found, process_time() - begun))
        return found


def repair(options: argparse.Namespace) -> Table:
    """A row for each problem: seconds of answers by kind, and their ratio to a fresh solve of the same state."""
    table = Table("Answers after one body was pushed")
    for path in _paths(options):
        problem, scene, plan = _solved(path)
        report = kabo.verify(problem, plan, scene=scene)
        seconds: dict[str, list[float]] = {}
        ratios: list[float] = []
        for body in sorted(scene.movable)[:2]:
            for offset, since in zip(PUSHES, SINCE, strict=True):
                robot = _Pushed(scene, body, offset, since)
                recovery = _Timed(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
                execute(plan, scene, robot, KnownTruth(poses=robot.poses), recovery=recovery, report=report)
                for asked, answer, took in recovery.asked:
                    seconds.setdefault(answer.kind, []).append(took)
                    if answer.kind in ("repair", "replan"):
                        ratios.append(took / _fresh(problem, asked))
        figures = {kind: percentile(each, 0.5) for kind, each in sorted(seconds.items())}
        least = {f"{kind}_most": max(each) for kind, each in sorted(seconds.items())}
        count = sum(map(len, seconds.values()))
        table.add(
            problem.name, answers=count, **figures, **least, of_fresh=percentile(ratios, 0.5) if ratios else None
        )
    return table


def _fresh(problem: Any, asked: Interruption) -> float:
    """Seconds of a solve of the state, with its verification, by a process that has kept nothing of the run."""
    begun = process_time()
    found = kabo.solve(kabo.load_problem(problem.path), start=asked.state, timeout=60.0).plan
    if found is not None:
        kabo.verify(problem, found, start=asked.state)
    return process_time() - begun
