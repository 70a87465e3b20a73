"""Random task trees over numbers; what their solutions are by definition is in oracles_tasks.py."""

import random
import zlib

from kabo.tasks.core import (
    Alternatives,
    Connector,
    Failure,
    Fallbacks,
    Flow,
    Generator,
    Limit,
    Merger,
    Monitor,
    Propagator,
    Result,
    Serial,
    Task,
    Wrapper,
)


def chance(*what) -> random.Random:
    return random.Random(zlib.crc32(repr(what).encode()))


def brief(scene):
    """A scene, or what stands for one that takes long to write down."""
    text = repr(scene)
    return scene if len(text) < 100 else f"{zlib.crc32(text.encode()):x}-{zlib.adler32(text.encode()):x}"


def outcomes(name, scene, most, *, likely=0.92):
    """Some results and failures, decided by the name of the stage and the scene alone."""
    dice = chance(name, scene)
    found = []
    for i in range(dice.choice([0, *[1] * 5, *range(1, most + 1)])):
        if dice.random() < likely:
            found.append(Result((name, brief(scene), i), cost=float(dice.randint(0, 9))))
        else:
            found.append(Failure("bad luck"))
    return found


class Gen(Generator):
    def generate(self, scene, properties, seed):
        yield from outcomes(self.name, None, 3)


class Watch(Monitor):
    def generate(self, scene, properties, seed):
        return outcomes(self.name, scene, 2)


class Move(Propagator):
    def forward(self, scene, properties, seed):
        yield from outcomes(self.name, scene, 2)

    def backward(self, scene, properties, seed):
        return outcomes(self.name, scene, 2)


class Join(Connector):
    def mismatch(self, start, end, properties):
        return "odd" if chance(self.name, start, end, "fit").random() < 0.15 else None

    def connect(self, start, end, properties, seed):
        return [r if isinstance(r, Failure) else Result(cost=r.cost) for r in outcomes(self.name, (start, end), 2)]


class Change(Wrapper):
    def transform(self, solution, properties, seed):
        found = outcomes(self.name, (solution.start.scene, solution.end.scene, solution.cost), 2)
        yield from (r if isinstance(r, Failure) else Result(cost=r.cost + solution.cost) for r in found)


class Both(Merger):
    def merge(self, scene, solutions, properties, seed):
        return outcomes(self.name, (scene, tuple(canonical(s) for s in solutions)), 2)


def dear(solution):
    """A cost term that refuses some solutions, and leaves the costs of others."""
    return float("inf") if too_dear(canonical(solution)) else solution.cost


def too_dear(solution):
    return chance("dear", solution).random() < 0.2


class Trees:
    """Makes trees whose stages fit together."""

    def __init__(self, seed: int, *, monitors: bool, depth: int = 2) -> None:
        self.dice = random.Random(seed)
        self.monitors = monitors
        self.depth = depth
        self.count = 0

    def name(self, kind):
        self.count += 1
        return f"{kind}{self.count}"

    def task(self):
        task = Task("task", *self.section_list(Flow.GENERATE, self.depth))
        if self.monitors:
            self.watch(task)
        return task

    def section_list(self, flow, depth):
        """The children of a serial container that runs in `flow`."""
        connectors = self.dice.choice([0, 1, 1, 2]) if flow is Flow.GENERATE else self.dice.choice([0, 0, 1])
        if flow is Flow.CONNECT:
            connectors = 1 + (self.dice.random() < 0.2)
        children = []
        for i in range(connectors + 1):
            if i:
                children.append(self.stage(Flow.CONNECT, depth - 1))
            reads_start = i == 0 and flow.reads_start
            reads_end = i == connectors and flow.reads_end
            children += self.section(reads_start, reads_end, depth - 1)
        return children or [self.stage(flow, depth - 1)]

    def section(self, reads_start, reads_end, depth):
        few = self.dice.randint(0, 2)
        if reads_start or reads_end:
            return [self.stage(Flow.FORWARD if reads_start else Flow.BACKWARD, depth) for _ in range(few)]
        before = [self.stage(Flow.BACKWARD, depth) for _ in range(few)]
        after = [self.stage(Flow.FORWARD, depth) for _ in range(self.dice.randint(0, 2))]
        return [*before, self.stage(Flow.GENERATE, depth), *after]

    KINDS = "leaf", "leaf", "serial", "any", "first", "change"

    def stage(self, flow, depth):
        kinds = ["leaf", "leaf"] if depth <= 0 else list(self.KINDS)
        if depth > 0 and flow in (Flow.FORWARD, Flow.BACKWARD):
            kinds.append("both")
        kind = self.dice.choice(kinds)
        how = {"cost": dear} if self.dice.random() < 0.15 else {}
        if kind == "serial":
            return Serial(self.name("serial"), *self.section_list(flow, depth), **how)
        if kind == "change":
            return Change(self.name("change"), self.stage(flow, depth - 1), **how)
        if kind != "leaf":
            holder = {"any": Alternatives, "first": Fallbacks, "both": Both}[kind]
            inside = [self.stage(flow, depth - 1) for _ in range(self.dice.randint(1, 3))]
            return holder(self.name(kind), *inside, **how)
        leaf = {Flow.GENERATE: Gen, Flow.CONNECT: Join}.get(flow, Move)(self.name("leaf"))
        if (
            flow is Flow.GENERATE and self.dice.random() < 0.2
        ):  # elsewhere it depends on the order what comes first
            return Limit(self.name("limit"), leaf, max_solutions=self.dice.randint(0, 3), **how)
        return leaf

    def watch(self, task):
        """Lets some generators monitor a stage that comes before them in time."""
        stages = [stage for stage in task.walk() if stage is not task]
        for stage in list(stages):
            if isinstance(stage, Gen) and not isinstance(stage.parent, Limit) and self.dice.random() < 0.5:
                earlier = [s for s in stages[: stages.index(stage)] if stage not in getattr(s, "children", ())]
                # how often a limit asks its child depends on the order of jobs
                earlier = [s for s in earlier if not inside(stage, s) and not isinstance(s.parent, Limit)]
                if earlier:
                    parent = stage.parent
                    index = parent.children.index(stage)
                    parent.remove(stage)
                    watch = Watch(stage.name, self.dice.choice(earlier))
                    parent.add(watch, index)
                    stages[stages.index(stage)] = watch


class Rich(Trees):
    """Trees in which fallbacks are nested with everything, and often have to go on."""

    KINDS = "leaf", "serial", "serial", "first", "first", "first", "any", "change"


def inside(stage, container):
    while stage is not None:
        if stage is container:
            return True
        stage = stage.parent
    return False


def canonical(solution):
    """A solution as nested tuples."""
    parts = tuple(canonical(part) for part in solution.parts)
    return solution.stage.name, solution.start.scene, solution.end.scene, solution.cost, parts
