"""What the solutions of a random task are by definition: all combinations, plainly enumerated, without any scheduling.

A stage is asked for every state that comes to it, whether that is of use or not. What a container generates inside is
made once, whoever asks. Monitors are triggered by all successes of the stage that they monitor; as fallbacks may
depend on that, all is made again until the triggers are those that it was made with.
"""

from collections import Counter, defaultdict
from itertools import product

from kabo.tasks.core import Alternatives, Fallbacks, Flow, Limit, Merger, Result, Serial, Wrapper
from tests.random_tasks import Watch, chance, outcomes, too_dear

ROUNDS = 8  # of triggers; where they do not settle, fallbacks depend on what they bring about themselves
MOST = 3_000  # solutions of all stages; a tree with more is compared with nothing


class Undefined(Exception):
    """There are too many to enumerate, or they depend on the order of jobs."""


def by_definition(task):
    """All solutions of a task as `canonical` gives them, counted; None if there are too many, or none are defined."""
    triggers, shapes = {}, {}
    for _ in range(ROUNDS):
        truth = Truth(triggers, shapes)
        try:
            found = Counter(truth.solutions(task, Flow.GENERATE))
        except Undefined:
            return None
        said = {watch: Counter(truth.book[watch.monitored]) for watch in task.walk() if isinstance(watch, Watch)}
        if said == triggers:
            return found
        triggers = said
    return None


class Place:
    """A state: a scene, told apart from equal ones."""

    def __init__(self, scene):
        self.scene = scene


class Truth:
    """One enumeration, with what monitors were triggered by."""

    def __init__(self, triggers, shapes):
        self.triggers = triggers
        self.shapes = shapes  # of serial containers, their sections, connectors, and where each section generates
        self.book = defaultdict(list)  # all successes of each stage
        self.made, self.links = {}, {}
        self.count = 0

    def solutions(self, stage, flow, start=None, end=None):
        """All solutions of a stage: from a scene, to one, between both, or from nothing."""
        found = self.every(stage, flow, start, end)
        if stage.cost is not None:
            found = [s for s in found if not too_dear(s)]
        if isinstance(stage, Limit):
            most = stage.properties.value("max_solutions")
            if 0 < most < len(found):
                raise Undefined  # which of them come first depends on the order of jobs
            found = found[:most]
        self.count += len(found)
        if self.count > MOST:
            raise Undefined
        self.book[stage] += found
        return found

    def every(self, stage, flow, start, end):
        """The same, without its cost term and its limit."""
        name = stage.name
        if isinstance(stage, Serial):
            return self.serial(stage, flow, start, end)
        if isinstance(stage, (Alternatives, Fallbacks)):
            if flow is not Flow.GENERATE:
                self.begin(stage, flow)
            found = []
            for child in stage.children:
                found += [(name, s[1], s[2], s[3], (s,)) for s in self.solutions(child, flow, start, end)]
                if found and isinstance(stage, Fallbacks):
                    break
            return found
        if isinstance(stage, Merger):
            near, found = start if flow is Flow.FORWARD else end, []
            for parts in product(*[self.solutions(c, flow, start, end) for c in stage.children]):
                for r in successes(outcomes(name, (near, parts), 2)):
                    found.append(
                        (name, *((start, r.scene) if flow is Flow.FORWARD else (r.scene, end)), r.cost, parts)
                    )
            return found
        if isinstance(stage, Wrapper):
            inner, found = self.solutions(stage.children[0], flow, start, end), []
            for s in inner:
                made = [Result(cost=0.0)] if isinstance(stage, Limit) else successes(outcomes(name, s[1:4], 2))
                found += [(name, s[1], s[2], r.cost + s[3], (s,)) for r in made]
            return found
        return self.leaf(stage, flow, start, end)

    def leaf(self, stage, flow, start, end):
        name = stage.name
        if flow is Flow.GENERATE:
            given = self.triggers.get(stage, ()) if isinstance(stage, Watch) else None
            causes = [None] if given is None else [s[2] for s, n in dict(given).items() for _ in range(n)]
            most = 3 if given is None else 2
            found = [r for cause in causes for r in successes(outcomes(name, cause, most))]
            return [(name, r.scene, r.scene, r.cost, ()) for r in found]
        if flow is Flow.FORWARD:
            return [(name, start, r.scene, r.cost, ()) for r in successes(outcomes(name, start, 2))]
        if flow is Flow.BACKWARD:
            return [(name, r.scene, end, r.cost, ()) for r in successes(outcomes(name, end, 2))]
        if chance(name, start, end, "fit").random() < 0.15:
            return []
        return [(name, start, end, r.cost, ()) for r in successes(outcomes(name, (start, end), 2))]

    # ---------------------------------------------------------------------------------------- serial containers
    def shape(self, stage):
        if stage not in self.shapes:
            connectors = [c for c in stage.children if Flow.CONNECT in c.flows]
            sections = stage.sections()
            where = [
                next((k for k, s in enumerate(section) if Flow.GENERATE in s.flows), None) for section in sections
            ]
            self.shapes[stage] = sections, connectors, where
        return self.shapes[stage]

    def begin(self, stage, flow):
        """What is generated inside is generated even if no state ever comes to the stage."""
        if isinstance(stage, Serial):
            sections, connectors, _ = self.shape(stage)
            for i in range(len(sections)):
                if not self.reads(stage, flow, i):
                    self.generated(stage, i)
            for child in connectors:
                self.begin(child, Flow.CONNECT)
            for i, section in enumerate(sections):
                side = self.reads(stage, flow, i)
                for child in section if side else ():
                    self.begin(child, side)
        else:
            for child in stage.children:
                self.begin(child, flow)

    def reads(self, stage, flow, i):
        """Which way states flow through a section of a container; None if it generates."""
        if i == 0 and flow.reads_start:
            return Flow.FORWARD
        return Flow.BACKWARD if i == len(self.shape(stage)[0]) - 1 and flow.reads_end else None

    def serial(self, stage, flow, start, end):
        self.begin(stage, flow)
        sections, connectors, _ = self.shape(stage)
        rows = []  # of each section: what it is made from, its ways to the left and to the right
        for i, section in enumerate(sections):
            side = self.reads(stage, flow, i)
            if side is None:
                rows.append(self.generated(stage, i))
            else:
                place = Place(start if side is Flow.FORWARD else end)
                way = self.chains(section if side is Flow.FORWARD else section[::-1], side, place)
                stay = [(place, ())]
                rows.append([(stay, (), way) if side is Flow.FORWARD else (way, (), stay)])
        for connector, here, there in zip(connectors, rows, rows[1:], strict=False):
            for t in [t for row in here for t, _ in row[2]]:
                for u in [u for row in there for u, _ in row[0]]:
                    if (connector, t, u) not in self.links:
                        self.links[connector, t, u] = self.solutions(connector, Flow.CONNECT, t.scene, u.scene)
        joined = [(s, t, (*left, *own, *right)) for a, own, b in rows[0] for s, left in a for t, right in b]
        for connector, row in zip(connectors, rows[1:], strict=True):
            joined = [
                (s, f, (*before, link, *left, *own, *right))
                for s, t, before in joined
                for a, own, b in row
                for u, left in a
                for link in self.links[connector, t, u]
                for f, right in b
            ]
            if len(joined) > MOST:
                raise Undefined
        return [(stage.name, s.scene, f.scene, sum(p[3] for p in parts), parts) for s, f, parts in joined]

    def generated(self, stage, i):
        """A section with a generator, made once."""
        if (stage, i) not in self.made:
            self.made[stage, i] = []
            section, where = self.shape(stage)[0][i], self.shape(stage)[2][i]
            for child in section[:where]:
                self.begin(child, Flow.BACKWARD)
            for child in section[where + 1 :]:
                self.begin(child, Flow.FORWARD)
            for s in self.solutions(section[where], Flow.GENERATE):
                lefts = self.chains(section[:where][::-1], Flow.BACKWARD, Place(s[1]))
                rights = self.chains(section[where + 1 :], Flow.FORWARD, Place(s[2]))
                self.made[stage, i].append((lefts, (s,), rights))
        return self.made[stage, i]

    def chains(self, stages, flow, place):
        """The states to which the stages lead from one, with the ways there."""
        ways = [(place, ())]
        for stage in stages:
            grown = []
            for at, way in ways:
                if flow is Flow.FORWARD:
                    grown += [(Place(s[2]), (*way, s)) for s in self.solutions(stage, flow, start=at.scene)]
                else:
                    grown += [(Place(s[1]), (s, *way)) for s in self.solutions(stage, flow, end=at.scene)]
            ways = grown
        return ways


def successes(found):
    return [r for r in found if isinstance(r, Result)]
