"""Soundness of `kabo verify`: plans and scenes spoilt at random, judged by it and by dense sampling.

    python benchmarks/verification.py [--colliding 200] [--seconds 3600] [--seed 0] [--cases NAME ...] [--output FILE]

Right plans are made for a few scenarios and spoilt (tests/support/motion_mutations.py) until so many mutants collide by the
oracle: many moments of the spoilt motions, exact meshes, python-fcl (tests/support/oracles_motions.py). Every one of these
must be refused; and of what is refused for a collision, the two bodies must come nearer than twice epsilon. Every
twentieth mutant is also verified whole, from the problem; the verdicts must agree.

The second checker is asked for the certificate of the right plan, carried along and mended so far that it is not
refused for its form (benchmarks/carried.py): it must refuse what collides, and all that the first finds to collide.
Of a pair that collides it is also asked alone. `--plans` names a folder that plans are read from and written to.
"""

import argparse
import signal
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import process_time
from typing import Any

from carried import Verdict, second_opinion
from table import Table, finish

import kabo
from kabo.plan import Plan, plan_from_json, plan_to_json
from kabo.scene import Scene, load_scene
from kabo.verify import Finding, verify_plan
from kabo.verify.motion.calls import Calls
from kabo.verify.motion.collision import Tally
from kabo.verify.motion.components import Components
from kabo.verify.motion.motions import check_motion
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.situation import check_start
from kabo.verify.motion.surfaces import Surface
from kabo.verify.structure import check_structure

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.support.motion_mutations import Case, Mutant, mutants  # noqa: E402
from tests.support.oracles_motions import Hit, Judge, replay_of, states_of  # noqa: E402

CASES = {
    "force sensing": "force_sensing/n2.yaml",
    "force sensing n3": "force_sensing/n3.yaml",
    "bartender": "bartender/four_bottles.yaml",
    "stacked": "stacked/n3.yaml",
    "stacked n4": "stacked/n4.yaml",
    "circular rearrange": "circular_rearrange/n3.yaml",
    "assembly": "assembly/gearbox.yaml",
}
WHOLE = 20  # every so many mutants the whole plan is verified


class SharedWorld(SceneModel):
    """A world that shares its surfaces with others."""

    made: dict[bytes, Surface] = {}

    def __init__(self, scene: Scene, models: Mapping[str, str | None] | None = None) -> None:
        super().__init__(scene, models)
        self._surfaces = self.made


@dataclass
class Outcome:
    """What both said of one mutant."""

    mutant: Mutant
    hit: Hit | None
    findings: list[Finding]
    nearest: float | None = None  # [m] of the bodies that are said to collide, the farthest such pair
    whole: bool | None = None  # whether the whole plan was refused
    seconds: float = 0.0
    certificate: Verdict | None = None  # of the second checker

    @property
    def touching(self) -> list[Finding]:
        """The findings that speak of a collision."""
        return [f for f in self.findings if len(f.bodies) == 2 and _says_contact(f.message)]

    @property
    def overlooked(self) -> bool:
        """Whether the second checker proves free what collides; contact that is granted is none of its business."""
        verdict = self.certificate
        if verdict is None:
            return False
        granted = {frozenset(pair) for pair in verdict.granted_pairs}
        seen = self.hit is not None or any(frozenset(f.bodies) not in granted for f in self.touching)
        return bool(verdict.accepted_pairs) or (seen and not verdict.refused)

    @property
    def colliding_pairs(self) -> list[tuple[str, str]]:
        """The pairs that the oracle or the findings say collide."""
        hit = [] if self.hit is None else [self.hit.pair]
        found = [(f.bodies[0], f.bodies[1]) for f in self.touching]
        return list({frozenset(pair): pair for pair in [*hit, *found]}.values())


def _says_contact(message: str) -> bool:
    return any(text in message for text in (" collide", "inside the other", "cannot be decided, closer"))


@dataclass
class Totals:
    """Outcomes by kind of mutation."""

    rows: dict[str, list[Outcome]] = field(default_factory=lambda: defaultdict(list))

    def table(self, title: str, epsilon: float) -> Table:
        """The figures of each kind, and of all."""
        table = Table(title)
        everything = [outcome for outcomes in self.rows.values() for outcome in outcomes]
        for name, outcomes in [*sorted(self.rows.items()), ("all", everything)]:
            table.add(name, **_figures(outcomes, epsilon))
        return table


def _figures(outcomes: list[Outcome], epsilon: float) -> dict[str, Any]:
    colliding = [o for o in outcomes if o.hit is not None]
    whole = [o for o in outcomes if o.whole is not None]
    return {
        "mutants": len(outcomes),
        "colliding (oracle)": len(colliding),
        "of these refused": sum(bool(o.findings) for o in colliding),
        "as collisions": sum(bool(o.touching) for o in colliding),
        "missed": sum(not o.findings for o in colliding),
        "refused, not colliding": sum(bool(o.findings) for o in outcomes if o.hit is None),
        "called colliding beyond 2 eps": sum(o.nearest is not None and o.nearest > 2 * epsilon for o in outcomes),
        "verified whole": len(whole),
        "whole disagrees": sum(o.whole is not bool(o.findings) for o in whole if o.findings or o.whole),
        **_second(outcomes),
        "seconds": sum(o.seconds for o in outcomes),
    }


def _second(outcomes: list[Outcome]) -> dict[str, int]:
    """The figures of the second checker."""
    asked = [(o, o.certificate) for o in outcomes if o.certificate is not None]
    colliding = [verdict for o, verdict in asked if o.hit is not None]
    free = [(o, verdict) for o, verdict in asked if o.hit is None and not o.touching]
    return {
        "certificate asked": len(asked),
        "colliding, asked": len(colliding),
        "certificate refused": sum(verdict.refused for verdict in colliding),
        "certificate missed": sum(not verdict.refused for verdict in colliding),
        "accepts what meshes collide": sum(o.overlooked for o, _ in asked),
        "accepts a colliding pair": sum(bool(verdict.accepted_pairs) for _, verdict in asked),
        "pair granted, measured only": sum(bool(verdict.granted_pairs) for _, verdict in asked),
        "free, both accept": sum(not verdict.refused and not o.findings for o, verdict in free),
        "free, certificate alone refuses": sum(verdict.refused and not o.findings for o, verdict in free),
    }


def judged(case: Case, right: Plan, mutant: Mutant, whole: bool) -> Outcome:
    """What the verifier, by its two ways, and the oracle say of a mutant of a right plan."""
    assert mutant.problem.scene is not None
    scene = load_scene(mutant.problem.scene)
    world = SharedWorld(scene, {name: body.model for name, body in mutant.problem.scene.bodies.items()})
    began, tally = process_time(), Tally()
    findings = list(findings_of(mutant, world, tally))
    seconds = process_time() - began
    outcome = Outcome(mutant, first_hit(case, mutant, scene), findings, seconds=seconds)
    outcome.certificate = second_opinion(
        right, mutant.plan, mutant.nodes, world, tally.stretches, outcome.colliding_pairs
    )
    if outcome.touching:
        outcome.nearest = max(nearest(mutant, scene, finding) for finding in outcome.touching)
    if whole:
        report = verify_plan(mutant.problem, mutant.plan)
        outcome.whole = any(f.node in mutant.nodes or f.node is None for f in report.findings)
    return outcome


def findings_of(mutant: Mutant, world: SceneModel, tally: Tally) -> Iterator[Finding]:
    """What the verifier finds at the nodes that were spoilt, by measuring."""
    order, _ = check_structure(mutant.plan)
    calls, components = Calls(mutant.problem), Components(mutant.plan, world.scene, order)
    yield from check_start(components)
    for name in mutant.nodes:
        yield from check_motion(name, mutant.plan.nodes[name], calls, world, components, tally)


def first_hit(case: Case, mutant: Mutant, scene: Any) -> Hit | None:
    """The first collision that the oracle sees."""
    judge, states = Judge(scene), states_of(mutant.plan, scene)
    for name in mutant.nodes:
        for state in states[name]:
            replay = replay_of(scene, state, mutant.plan.nodes[name], case.plan.nodes[name])
            for hit in judge.hits(name, replay):
                return hit
    return None


def nearest(mutant: Mutant, scene: Any, finding: Finding) -> float:
    """How near two bodies come that are said to collide [m], in the state where they come nearest."""
    judge, states, name = Judge(scene), states_of(mutant.plan, scene), str(finding.node)
    first, second = finding.bodies
    return min(
        judge.least((first, second), replay_of(scene, state, mutant.plan.nodes[name])) for state in states[name]
    )


def right_plan(name: str, file: str, folder: Path) -> tuple[Case, Plan]:
    """The case of a scenario, and its plan with the certificate; the plan is made if the folder has none."""
    problem = kabo.load_problem(ROOT / "domains" / file)
    kept = folder / f"{file.replace('/', '_').removesuffix('.yaml')}.json"
    if not kept.exists():
        plan = kabo.solve(problem, seed=0).plan
        if plan is None:
            raise SystemExit(f"no plan for {file}")
        kept.write_bytes(plan_to_json(plan))
    plan = plan_from_json(kept.read_bytes())
    return Case(name, problem, replace(plan, certificate=None)), plan


def main() -> None:
    """Spoils, judges, prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--colliding", type=int, default=200, help="how many mutants must collide")
    parser.add_argument("--seconds", type=float, default=3600.0, help="of the processor, after which it ends")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES))
    parser.add_argument("--plans", type=Path, help="a folder with plans, and for those that are made")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        folder = options.plans or Path(made)
        cases = [right_plan(name, CASES[name], folder) for name in options.cases]
    kinds, scenarios, epsilon = Totals(), Totals(), min(case.scene.epsilon for case, _ in cases)
    streams = [(case, right, mutants(case, options.seed)) for case, right in cases]
    colliding = count = 0
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with suppress(KeyboardInterrupt):  # whoever ends it early gets what there is
        while colliding < options.colliding and process_time() < options.seconds:
            case, right, stream = streams[count % len(streams)]
            count += 1
            outcome = judged(case, right, next(stream), count % WHOLE == 0)
            colliding += outcome.hit is not None
            kinds.rows[outcome.mutant.kind].append(outcome)
            scenarios.rows[case.name].append(outcome)
            _tell(case, outcome, epsilon)
            if count % 10 == 0:
                print(f"{count} mutants, {colliding} collide", flush=True)
    tables = [kinds.table("By mutation", epsilon), scenarios.table("By scenario", epsilon)]
    finish(tables, options.output, seed=options.seed, colliding=options.colliding, cases=options.cases)


def _tell(case: Case, outcome: Outcome, epsilon: float) -> None:
    """Prints what must not be."""
    if outcome.hit is not None and not outcome.findings:
        print(f"MISSED: {case.name}, {outcome.mutant.kind}: {outcome.hit}")
    if outcome.nearest is not None and outcome.nearest > 2 * epsilon:
        print(f"FREE: {case.name}, {outcome.mutant.kind}: {outcome.nearest:.3g} m, {outcome.touching[0]}")
    told = outcome.certificate
    if told is not None and outcome.overlooked:
        pairs = ", ".join(" and ".join(pair) for pair in told.accepted_pairs)
        print(f"PROVEN: {case.name}, {outcome.mutant.kind}, {outcome.mutant.nodes}: {pairs} | {outcome.hit}")


if __name__ == "__main__":
    main()
