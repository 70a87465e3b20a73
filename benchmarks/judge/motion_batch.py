"""Judges plans in one process: a JSON job a line comes in, its verdict goes out as a line.

    python motion_batch.py < jobs.jsonl

A job has `problem` (YAML) and `plan` (JSON), and may say `collisions: false` and `durations: true`. It needs numpy,
pinocchio, coal and PyYAML, for durations scipy and CasADi, and shares no code with kabo. Plans of the format
`kabo-plan/1` are taken as what they say: straight between way points at constant velocity.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from motion_collisions import NEAR, Collisions
from motion_limits import (
    JOIN,
    KINDS,
    RATE,
    SLACK,
    Fault,
    after_differs,
    borders,
    greatest,
    joined,
    joins,
    off_path,
    sampled_differences,
    tool,
)
from motion_scene import load
from motion_states import Motion, following, order, states

MOST_FAULTS = 200
DIFFERENCES = 0.01  # of a limit: what rounding may add to third differences of positions
PATH = 1e-9  # [rad or m] beyond the stated deviation: rounding of coefficients


class Verdict:
    """What is found about one plan."""

    def __init__(self) -> None:
        self.faults: list[Fault] = []
        self.worst: dict[str, float] = {}
        self.segments: list[dict[str, Any]] = []
        self.durations: list[dict[str, Any]] = []
        self.samples = self.asked = self.polynomials = 0

    def seen(self, kind: str, figure: float) -> None:
        """Notes a figure of which the greatest is told."""
        self.worst[kind] = max(self.worst.get(kind, 0.0), float(figure))

    def json(self) -> dict[str, Any]:
        """All of it, faults by kind counted, at most some of them told."""
        counts: dict[str, int] = {}
        for fault in self.faults:
            counts[fault.kind] = counts.get(fault.kind, 0) + 1
        return {
            "violations": counts,
            "worst": self.worst,
            "samples": self.samples,
            "distances_asked": self.asked,
            "segments_with_polynomials": self.polynomials,
            "segments": self.segments,
            "durations": self.durations,
            "faults": [fault.line() for fault in self.faults[:MOST_FAULTS]],
        }


def judge(job: dict[str, Any]) -> dict[str, Any]:
    """The verdict of one plan."""
    scene, plan = load(Path(job["problem"])), json.loads(Path(job["plan"]).read_text())
    found, verdict, collisions = states(plan), Verdict(), Collisions(scene)
    collisions.start(found[plan["root"]][0])
    for name in order(plan):
        node = plan["nodes"][name]
        if node.get("motion"):
            motion = Motion(scene, node, found[name][0])
            kinematic(verdict, motion, name, node)
            if job.get("collisions", True):
                colliding(verdict, motion, name, collisions, found[name])
                if node.get("overlap"):
                    early(verdict, plan, name, motion, collisions, scene, found)
            if job.get("durations", False):
                verdict.durations.append({"node": name, **durations(motion, node.get("overlap") or 0.0)})
    return {
        "format": plan["format"],
        "bytes": Path(job["plan"]).stat().st_size,
        "certificate_bytes": len(json.dumps(plan.get("certificate"), separators=(",", ":")))
        if "certificate" in plan
        else 0,
        "trajectory_bytes": _trajectory_bytes(plan),
        "longest_s": longest(plan),
        **verdict.json(),
    }


def kinematic(verdict: Verdict, motion: Motion, name: str, node: dict[str, Any]) -> None:
    """Limits, joins, rests, the path, and what a grip must hold."""
    for each in motion.curves:
        verdict.polynomials += each.polynomial
        shares = greatest(motion, each)
        for kind, share in shares.items():
            verdict.seen(kind, share.max())
            if share.max() > 1 + SLACK:
                verdict.faults.append(
                    Fault(name, each.number, kind, share.max(), 1.0, each.joints[int(share.argmax())])
                )
        verdict_joins(verdict, name, each.number, joins(each), "join")
        far, beyond = off_path(each)
        verdict.seen("off_path", far)
        if beyond > PATH:
            verdict.faults.append(
                Fault(name, each.number, "path", far, each.deviation, "distance to the way points")
            )
        positions(verdict, motion, name, each)
    for each, jumps, rests in borders(motion):
        verdict_joins(verdict, name, each.number, jumps, "rest" if rests else "join")
    for robot in sorted({each.robot for each in motion.curves}):
        for kind, (share, joint) in sampled_differences(motion, robot).items():
            verdict.seen(f"{kind}_by_differences", share)
            if share > 1 + DIFFERENCES:
                verdict.faults.append(Fault(name, -1, f"{kind}_by_differences", share, 1.0, f"{robot}.{joint}"))
    worst, doubt, faults = tool(motion, name)
    verdict.seen("tool", worst)
    verdict.seen("tool_doubt", doubt)
    verdict.faults += faults
    verdict.seen("after", after_differs(motion, node))


def verdict_joins(verdict: Verdict, node: str, number: int, jumps: Any, kind: str) -> None:
    """Jumps of position, velocity and acceleration at a border."""
    for what, jump in zip(("position", "velocity", "acceleration"), jumps, strict=True):
        verdict.seen(f"{kind}_{what}", jump)
        if jump > JOIN * (1 + 1e-3):
            verdict.faults.append(Fault(node, number, kind, float(jump), JOIN, what))


def positions(verdict: Verdict, motion: Motion, name: str, each: Any) -> None:
    """Whether a joint ever leaves its limits."""
    ends = [motion.scene.robots[each.robot].positions.get(joint, (-np.inf, np.inf)) for joint in each.joints]
    low, high = np.array(ends).T
    at = np.arange(each.ends[0], each.ends[1], 1 / RATE)
    rows = each.at(np.append(at, each.ends[1]))
    beyond = np.maximum(low - rows, rows - high).max(axis=0)
    verdict.seen("position_beyond", max(0.0, beyond.max()))
    if beyond.max() > 2e-9:
        verdict.faults.append(
            Fault(name, each.number, "position", beyond.max(), 0.0, each.joints[int(beyond.argmax())])
        )


def colliding(verdict: Verdict, motion: Motion, name: str, collisions: Collisions, found: Any) -> None:
    """Collisions of each stretch, and the least distance of each segment."""
    for stretch in motion.stretches():
        least = collisions.least(motion, stretch, found)
        verdict.samples += least.samples
        verdict.asked += least.asked
        number = stretch.under_way[0].number
        verdict.segments.append(
            {
                "node": name,
                "segments": [each.number for each in stretch.under_way],
                "least": None if least.distance > NEAR else least.distance,
                "between": least.between,
            }
        )
        for first, second, at in least.collisions:
            verdict.faults.append(Fault(name, number, "collision", at, 0.0, f"{first} {second}"))


def durations(motion: Motion, early: float) -> dict[str, float]:
    """How long a node's motion lasts, and bounds: its phases and its motions from rest to rest, and straight lines.

    A phase is a segment; a motion is a row of them without a rest. Of robots that move at once the slowest counts;
    robots that wait for each other add up. Standing still is what a plan asks for (a sensor that takes its time) and
    no motion can shorten it: it lasts as long as it is stated.
    What begins `early` [s] lasts from the end of what came before it: only that time is added to a branch.
    """
    from motion_durations import least, line  # noqa: PLC0415 - CasADi is not needed for anything else

    whole = dict.fromkeys(("phases", "phases_without_jerk", "motions", "lines"), 0.0)
    for together in at_once(motion):
        found: dict[str, dict[str, float]] = {}
        for row in together:
            sums = found.setdefault(row[0].robot, dict.fromkeys(whole, 0.0))
            limits = motion.scene.robots[row[0].robot].limits
            bounds = {kind: np.array([limits[name][kind] for name in row[0].joints]) for kind in KINDS}
            stood = sum(each.ends[1] - each.ends[0] for each in row if stands(each))
            for each in row:
                with_jerk, without = least(each.waypoints, bounds)
                sums["phases"] += with_jerk
                sums["phases_without_jerk"] += without
            points = np.concatenate([each.waypoints for each in row])
            sums["motions"] += least(points, bounds)[0]
            sums["lines"] += line(points, bounds)
            for kind in sums:
                sums[kind] += stood
        slowest = max(found.values(), key=lambda sums: sums["phases"])
        whole = {kind: whole[kind] + slowest[kind] for kind in whole}
    return {"lasts": motion.end - early, "early": early, **whole}


def stands(each: Any) -> bool:
    """Whether a segment's path stays where it is."""
    return bool(np.ptp(each.waypoints, axis=0).max() == 0.0)


def at_once(motion: Motion) -> list[list[list[Any]]]:
    """Rows of all robots in groups that follow each other in time: within a group rows overlap."""
    robots = sorted({each.robot for each in motion.curves})
    rows = [row for robot in robots for row in chains(motion, [e for e in motion.curves if e.robot == robot])]
    groups: list[list[list[Any]]] = []
    until = -np.inf
    for row in sorted(rows, key=lambda row: row[0].ends[0]):
        if row[0].ends[0] < until - 1e-9:
            groups[-1].append(row)
        else:
            groups.append([row])
        until = max(until, row[-1].ends[1])
    return groups


def chains(motion: Motion, own: list[Any]) -> list[list[Any]]:
    """Segments of a robot in rows without a rest."""
    rows: list[list[Any]] = []
    for each in sorted(own, key=lambda each: each.ends):
        before = joined(motion, each, each.ends[0], 1) if each.ends[0] > 0.0 else None
        if before is not None and rows and rows[-1][-1] is before:
            rows[-1].append(each)
        else:
            rows.append([each])
    return rows


def early(
    verdict: Verdict,
    plan: dict[str, Any],
    name: str,
    motion: Motion,
    collisions: Collisions,
    scene: Any,
    found: Any,
) -> None:
    """Collisions of a motion that begins early with the end of the one before it, at the times that the plan says."""
    for other, node in plan["nodes"].items():
        if name in following(node):
            before = Motion(scene, node, found[other][0])
            for least in collisions.meeting(before, motion, plan["nodes"][name]["overlap"]):
                verdict.samples += least.samples
                verdict.asked += least.asked
                for first, second, at in least.collisions:
                    verdict.faults.append(Fault(name, -1, "collision", at, 0.0, f"{first} {second}, begun early"))


def _bytes(content: Any) -> int:
    return len(json.dumps(content, separators=(",", ":")))


def _trajectory_bytes(plan: dict[str, Any]) -> int:
    segments = [segment for node in plan["nodes"].values() for segment in node.get("motion") or ()]
    return sum(_bytes(each["trajectory"]) for each in segments if each.get("trajectory"))


def longest(plan: dict[str, Any]) -> float:
    """The time of the longest branch [s]."""
    lasts = {}
    for name in reversed(order(plan)):
        node = plan["nodes"][name]
        own = max((each["times"][-1] for each in node.get("motion") or ()), default=0.0) - node.get("overlap", 0.0)
        lasts[name] = own + max((lasts[after] for after in following(node)), default=0.0)
    return lasts[plan["root"]]


if __name__ == "__main__":
    for line in sys.stdin:
        job = json.loads(line)
        try:
            print(json.dumps({"plan": job["plan"], **judge(job)}), flush=True)
        except Exception as error:  # noqa: BLE001 - a plan that cannot be judged is told, and the next one judged
            print(json.dumps({"plan": job["plan"], "error": f"{type(error).__name__}: {error}"}), flush=True)
