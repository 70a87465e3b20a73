"""Runs in physics that are disturbed: does each end at its goal, or in a safe stop with a reason?

Everything is drawn from the seed: the kind of a fault, when it comes, how large it is, which body or joint it meets. A run
is judged by the simulator's own state, by its contacts (`ContactJudge`), and by an independent watcher that replays its log
(`execution_faults_watched.py`). Runs that stop are compared with an omniscient replanner, which knows the true state of the
world (`execution_faults_omniscient.py`): `solvable` are those that reached the goal, or for which it finds a plan. In the
first table `goal` are runs at whose end every body that the last plan has moved is within 3 mm and 1 degree of its place,
and `near` those at whose end one of them is farther away, though within what is proven to be free; `stop` are stops after
which all robots stand. `wrong` is everything else, and has to be 0.

    python benchmarks/execution_faults.py                         # 600 runs
    python benchmarks/execution_faults.py --runs 60 --only displaced --problem stacked_n2
"""

import argparse
import multiprocessing
import traceback
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from math import gcd, inf
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from execution_faults_made import KINDS, SENSING, Disturbance, Fault, FaultySensor
from execution_faults_omniscient import SECONDS, solvable, without_sensors
from execution_faults_watched import Watcher
from table import ROOT, Table, finish, percentile

import kabo
from kabo.arrays import Array
from kabo.execution import Answer, ExecutionSettings, Interruption, Log, Margins, Run, Surprise, execute
from kabo.plan import Plan, state_after
from kabo.recovery import Replanner
from kabo.scene import Scene, beginning_at, world_T
from kabo.simulation import ContactJudge, SimulatedRobot

PROBLEMS = {
    "stacked_n2": "domains/stacked/n2.yaml",
    "stacked_n4": "domains/stacked/n4.yaml",
    "bartender": "domains/bartender/four_bottles.yaml",
    "force_sensing_n2": "domains/force_sensing/n2.yaml",
    "circular_n2": "domains/circular_rearrange/n2.yaml",
    "circular_n3": "domains/circular_rearrange/n3.yaml",
    "two_cans": "examples/two_cans/problem.yaml",
}
LONGEST = 400.0  # [s] of simulated time; a run that lasts longer never ends
PLACED, TURNED = 3e-3, np.deg2rad(1.0)
STANDS = 0.02  # [rad/s or m/s]
AFTERWARDS = 0.5  # [s] that robots have to stand still, after the end
SETTINGS = ExecutionSettings(log_rate=100.0)  # of every look: the watcher reads what is logged


@dataclass
class Judged:
    """What became of one run; `fault` is what disturbed it."""

    fault: Fault
    end: str = "wrong"  # goal, near, stop or wrong
    reason: str = ""
    came: bool = False  # whether the fault came before the end
    answers: list[str] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)  # of the processor, of each answer
    contacts: list[str] = field(default_factory=list)  # that no segment permits, after the fault was noticed
    early: list[str] = field(default_factory=list)  # before
    least: float = 0.0  # [m] proven at the start
    lasted: float = 0.0  # [s] of simulated time
    told: list[str] = field(default_factory=list)  # by the watcher
    stops: list[str] = field(default_factory=list)  # why, with the answers' reasons
    solvable: str | None = None  # from which state an omniscient replanner finds a plan


@lru_cache
def solved(name: str) -> tuple[Any, Scene, Plan, kabo.Memo]:
    """A problem, its scene, its plan, and what the solve has kept."""
    problem, memo = kabo.load_problem(ROOT / PROBLEMS[name]), kabo.Memo()
    plan = kabo.solve(problem, memo=memo).plan
    if plan is None:
        raise ValueError(f"{name} was not solved")
    return problem, kabo.load_scene(problem.scene), plan, memo


class TimedReplanner(Replanner):
    """Counts answers and the processor's seconds; keeps the plans that are carried out, and where it was asked first."""

    def begin(self, judged: Judged, plan: Plan, disturbance: Disturbance) -> "TimedReplanner":
        """Counts for a run."""
        self.judged, self.plan, self.disturbance = judged, plan, disturbance
        self.plans: list[tuple[str, Plan]] = [("first", plan)]
        self.first: tuple[Interruption, dict[str, Array]] | None = None  # after the fault, with true poses
        return self

    def answer(self, interruption: Interruption) -> Answer:
        """The answer, timed."""
        if self.first is None and self.disturbance.came and self.disturbance.robot is not None:
            self.first = interruption, dict(self.disturbance.robot.poses())
        began = process_time()
        found = super().answer(interruption)
        self.judged.seconds.append(process_time() - began)
        self.judged.answers.append(found.kind)
        if found.plan is not None:
            self.plans.append((found.kind, found.plan))
        if found.plan is not None and found.kind in ("repair", "replan"):
            self.plan = found.plan
        return replace(
            found, report=None
        )  # by least clearances, as the watcher judges: no tolerances by direction


def judged(fault: Fault) -> Judged:
    """Makes one run."""
    found = Judged(fault)
    try:
        _run(fault, found)
    except Exception as error:  # noqa: BLE001 - whatever it is, it is a finding
        found.end, found.reason = "wrong", "".join(traceback.format_exception_only(error)).strip()
    return found


def _run(fault: Fault, found: Judged) -> None:
    _, scene, plan, _ = solved(fault.problem)
    disturbance = Disturbance(fault, plan, scene)
    try:
        _run_with(disturbance, found)
    finally:
        disturbance.end()


def _run_with(disturbance: Disturbance, found: Judged) -> None:
    fault = disturbance.fault
    problem, scene, plan, memo = solved(fault.problem)
    robot = SimulatedRobot(scene, disturb=disturbance)
    disturbance.robot = robot
    judge = ContactJudge(scene)
    robot.judge = judge.look
    before: dict[tuple[str, str], float] = {}

    def noticed(record: dict[str, Any]) -> None:
        if record["event"] == "stopping" and not before:
            before.update(judge.faults)

    sensor = FaultySensor(disturbance, seed=fault.seed, poses=robot.poses)
    recovery = TimedReplanner(problem, scene, {"timeout": SECONDS}, replace(memo)).begin(found, plan, disturbance)
    log = Log(listener=noticed)
    late = lambda: robot.physics.time > LONGEST  # noqa: E731
    run = execute(plan, scene, robot, sensor, SETTINGS, log=log, stop=late, recovery=recovery)
    found.came, found.least = disturbance.came, Margins(plan).of_rest(plan.root)
    found.lasted, found.reason = robot.physics.time, run.reason
    stopped = any(True for _ in log.of("stopping"))
    found.early = [" and ".join(pair) for pair in (before if stopped else judge.faults)]
    found.contacts = [" and ".join(pair) for pair in judge.faults if pair not in before] if stopped else []
    found.told = Watcher(scene, recovery.plans).replay(log.records)
    found.stops = [each["reason"] for each in log.records if each["event"] in ("stopping", "answer")]
    robot.wait(AFTERWARDS)
    found.end = _end(run, recovery.plan, scene, robot, found)
    if found.end in ("goal", "near"):
        found.solvable = "reached"
    elif found.came:
        found.solvable = _solvable(problem, scene, run, recovery, sensor)


def _solvable(problem: Any, scene: Scene, run: Run, recovery: TimedReplanner, sensor: FaultySensor) -> str | None:
    """From which state an omniscient replanner would go on."""
    if recovery.first is None:  # the run ended at once
        surprise = run.surprise or Surprise("sensor", run.reason, "", 0.0, 0.0)
        there = Interruption(recovery.plan, run.state, (), (), surprise, run.state.geometry)
        assert recovery.disturbance.robot is not None
        recovery.first = there, dict(recovery.disturbance.robot.poses())
    known = without_sensors(problem) if sensor.broken else problem
    return solvable(known, scene, *recovery.first)


def _end(run: Run, plan: Plan, scene: Scene, robot: SimulatedRobot, found: Judged) -> str:
    """How the run has ended."""
    measured = robot.state().velocities
    arms = (np.abs(measured[name][: own.planned]).max(initial=0.0) for name, own in scene.robots.items())
    speed = max(arms)
    if speed > STANDS:
        found.told.append(f"robots do not stand, but move by {speed:.3g}")
    if robot.physics.time > LONGEST:
        found.told.append("it does not end")
    if found.told:
        return "wrong"
    if not run.reached_goal:
        return "stop" if run.reason else "wrong"
    worst = _farthest(run, plan, scene, robot)
    if worst is None:
        return "goal"
    name, off, least = worst
    found.reason = f"{name} is {1000 * off:.1f} mm from its place, {1000 * least:.1f} mm are proven"
    return "near" if off <= least else "wrong"


def _farthest(run: Run, plan: Plan, scene: Scene, robot: SimulatedRobot) -> tuple[str, float, float] | None:
    """The body that is farthest from where the last plan has put it, if one is too far [m], and what was proven."""
    roots = [number for number, (node, _) in enumerate(run.history) if node == plan.root]
    tail = run.history[roots[-1] :] if roots and plan.nodes[plan.root].kind != "goal" else ()
    # A plan is followed to its end, and comes to its root once.
    state = state_after(plan, tail).geometry
    if state is None:
        return None
    there, true = beginning_at(scene, state), robot.poses()
    moved = {name for node, _ in tail if (after := plan.nodes[node].after) is not None for name in after.objects}
    worst, least = None, Margins(plan).of_rest(plan.root)
    for name in sorted(moved):
        wanted, pose = world_T(there, there.start, name), true[name]
        off = float(np.linalg.norm(wanted[:3, 3] - pose[:3, 3]))
        cosine = min(1.0, 0.5 * (np.trace(wanted[:3, :3].T @ pose[:3, :3]) - 1.0))
        if (off > PLACED or np.arccos(cosine) > TURNED) and (worst is None or off > worst[1]):
            worst = name, off, least
    return worst


def drawn(runs: int, seed: int, only: str | None = None, problem: str | None = None) -> list[Fault]:
    """The faults of all runs: kinds and problems in turn."""
    kinds = [kind for kind in KINDS if only in (None, kind)]
    problems = [name for name in PROBLEMS if problem in (None, name)]
    pairs = [(kind, name) for name in problems for kind in kinds if kind not in SENSING or name in senses()]
    each, rest = divmod(runs, len(pairs))
    spread = len(pairs) * np.arange(rest) // max(1, rest)
    numbered = [(k, pair) for pair in pairs for k in range(each)] + [(each, pairs[k]) for k in spread]
    return [Fault.drawn(kind, name, 1000 * seed + k) for k, (kind, name) in numbered]


def senses() -> Sequence[str]:
    """The problems whose plans sense something."""
    return ("bartender", "force_sensing_n2")


def faults(
    runs: int = 600, seed: int = 1, workers: int = 2, minutes: float = inf, **which: str | None
) -> list[Table]:
    """The tables: ends by kind, ends by problem, answers, stops with their reasons.

    Runs come in an order that mixes kinds and problems, so that those that are made within `minutes` are of all of them.
    """
    asked, began = drawn(runs, seed, **which), perf_counter()
    step = next(k for k in range(int(0.618 * len(asked)), 2 * len(asked) + 2) if gcd(k, len(asked)) == 1)
    asked = [asked[step * k % len(asked)] for k in range(len(asked))]
    made = []
    with multiprocessing.get_context("spawn").Pool(workers) as pool:
        for each in pool.imap(judged, asked):
            made.append(each)
            print(told(each), flush=True)
            if perf_counter() - began > 60.0 * minutes:
                break
        pool.terminate()
    return [table for table in (*_ends(made), _answers(made), _reasons(made)) if table.rows]


def told(each: Judged) -> str:
    """One run, in some lines."""
    fault = each.fault
    drawn = (
        f"share {fault.share:.2f}, {1000 * fault.size:.1f} mm, choice {fault.choice:.2f}, lasts {fault.lasts:.2f}"
    )
    first = f"{fault.problem} {fault.kind} {fault.seed} ({drawn}): {each.end} after {each.lasted:.1f} s, came {each.came}"
    rest = [
        f"solvable {each.solvable}, answers {each.answers}; {each.told}",
        f"touched {each.early} before, {each.contacts} after",
        *each.stops,
        each.reason,
    ]
    return "\n    ".join([first, *rest])


def _ends(made: list[Judged]) -> list[Table]:
    tables = []
    for title, key in (("Ends by kind of fault", "kind"), ("Ends by problem", "problem")):
        table = Table(title)
        names = dict.fromkeys(asdict(each.fault)[key] for each in made)
        for name in [*names, "all"]:
            own = [each for each in made if name in (asdict(each.fault)[key], "all")]
            count = Counter(each.end for each in own)
            answers = Counter(kind for each in own for kind in each.answers)
            ends: dict[str, Any] = {end: count[end] for end in ("goal", "near", "stop", "wrong")}
            kinds = {kind: answers[kind] for kind in ("finish", "undo", "repair", "replan", "none")}
            ends["solvable"] = able = sum(each.solvable is not None for each in own)
            ends["of these"] = (count["goal"] + count["near"]) / able if able else None
            touched = sum(len(each.contacts) for each in own)
            came = sum(each.came for each in own)
            table.add(name, runs=len(own), came=came, **ends, contacts=touched, **kinds)
        tables.append(table)
    return tables


def _answers(made: list[Judged]) -> Table:
    table = Table("Processor seconds of an answer")
    for kind in ("finish", "undo", "repair", "replan", "none"):
        seconds = [s for each in made for s, own in zip(each.seconds, each.answers, strict=True) if own == kind]
        if seconds:
            figures = {"median": percentile(seconds, 0.5), "p90": percentile(seconds, 0.9), "most": max(seconds)}
            table.add(kind, answers=len(seconds), **figures)
    within = [each for each in made if each.fault.kind == "displaced" and each.came]
    within = [each for each in within if each.fault.size <= each.least]
    asked = sum(bool(each.answers) for each in within)
    table.add("displaced within what is proven", answers=len(within), asked=asked)
    return table


def _reasons(made: list[Judged]) -> Table:
    table = Table("Runs that did not reach the goal, or touched something")
    for each in made:
        if each.end in ("stop", "wrong") or each.contacts:
            name = f"{each.fault.problem} {each.fault.kind} {each.fault.seed}"
            table.add(
                name,
                end=each.end,
                solvable=each.solvable,
                contacts=", ".join(each.contacts) or None,
                reason=each.reason.strip(),
            )
    return table


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--minutes", type=float, default=inf, help="after which no run begins any more")
    parser.add_argument("--only", choices=KINDS)
    parser.add_argument("--problem", choices=PROBLEMS)
    parser.add_argument("--output", type=Path)
    given = parser.parse_args()
    tables = faults(given.runs, given.seed, given.workers, given.minutes, only=given.only, problem=given.problem)
    minutes = given.minutes if given.minutes < inf else None
    finish(tables, given.output, runs=given.runs, seed=given.seed, minutes=minutes)


if __name__ == "__main__":
    main()
