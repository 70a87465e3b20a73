"""What the solutions of a random task are by definition: all combinations, plainly enumerated, without any scheduling.

A stage is asked once for every state that comes to it, whether that is of use or not. A state at the border of a serial
container is one outside, however many ways inside lead to it. What a container generates inside is made once, whoever
asks. Monitors are triggered by all successes of the stage that they monitor; as fallbacks may depend on that, all is
made again until the triggers are those that it was made with.
"""

from collections import Counter, defaultdict
from itertools import product
from typing import NamedTuple

from kabo.tasks.core import Alternatives, Fallbacks, Flow, Limit, Merger, Result, Serial, Wrapper
from tests.support.random_tasks import Watch, chance, outcomes, too_dear

ROUNDS = 8  # of triggers; where they do not settle, fallbacks depend on what they bring about themselves
MOST = 3_000  # solutions of all stages; a tree with more is compared with nothing


class Undefined(Exception):
    """There are too many to enumerate, or they depend on the order of jobs."""


def by_definition(task):
    """All solutions of a task as `canonical` gives them, counted; None if there are too many, or none are defined."""
    try:
        found, triggers, chosen = settled(task, {}, None)
        return found if settled(task, {}, chosen)[:2] == (found, triggers) else None
    except Undefined:
        return None


def settled(task, triggers, chosen):
    """Solutions, triggers, and which child each fallback came to; with `chosen`, fallbacks are told that before.

    Told so, triggers come from nothing but what came before them: what holds only because it holds is not found.
    """
    watches = [stage for stage in task.walk() if isinstance(stage, Watch)]
    shapes = {}
    for _ in range(ROUNDS if chosen is None else MOST):
        truth = Truth(triggers, shapes, chosen)
        found = Counter(s.told for s in truth.solutions(task, Flow.GENERATE))
        said = {watch: Counter(s.told for s in truth.book[watch.monitored]) for watch in watches}
        if said == triggers:
            return found, triggers, truth.came_to
        triggers = said
    raise Undefined


class Place:
    """A state: a scene, told apart from equal ones, and the pair of which fallbacks it is there for, if of any."""

    def __init__(self, scene, lane=None):
        self.scene, self.lane = scene, lane


class Found(NamedTuple):
    """A solution between two states, and what `canonical` says of it."""

    start: Place
    end: Place
    told: tuple

    @classmethod
    def of(cls, name, start, end, cost, parts=()):
        return cls(start, end, (name, start.scene, end.scene, cost, tuple(p.told for p in parts)))


class Truth:
    """One enumeration, with what monitors were triggered by."""

    def __init__(self, triggers, shapes, chosen):
        self.triggers, self.chosen, self.came_to = triggers, chosen, {}
        self.shapes = shapes  # of serial containers, their sections, connectors, and where each section generates
        self.book = defaultdict(list)  # all successes of each stage
        self.asked, self.made, self.inner, self.outer = {}, {}, {}, {}
        self.count = 0

    def solutions(self, stage, flow, start=None, end=None, lane=None):
        """All solutions of a stage: from a state, to one, between both, or from nothing."""
        key = stage, start, end, lane
        if key not in self.asked:
            found = self.every(stage, flow, start, end, lane)
            if stage.cost is not None:
                found = [s for s in found if not too_dear(s.told)]
            if isinstance(stage, Limit):
                most = stage.properties.value("max_solutions")
                if 0 < most < len(found):
                    raise Undefined  # which of them come first depends on the order of jobs
                found = found[:most]
            self.count += len(found)
            if self.count > MOST:
                raise Undefined
            self.book[stage] += found
            self.asked[key] = found
        return self.asked[key]

    def every(self, stage, flow, start, end, lane):
        """The same, without its cost term and its limit."""
        name = stage.name
        if isinstance(stage, Serial):
            return self.serial(stage, flow, self.into(stage, start, lane), self.into(stage, end, lane), start, end)
        if isinstance(stage, (Alternatives, Fallbacks)):
            if flow is not Flow.GENERATE:
                self.begin(stage, flow)
            if flow is Flow.CONNECT and isinstance(stage, Fallbacks):
                lane = stage, start, end, lane or start.lane or end.lane
            found = []
            key = stage, start and start.scene, end and end.scene
            for i, child in enumerate(stage.children):
                made = self.solutions(child, flow, start, end, lane)
                found += [Found.of(name, s.start, s.end, s.told[3], (s,)) for s in made]
                if not isinstance(stage, Fallbacks):
                    continue
                self.came_to[key] = i
                if self.chosen is None and found or self.chosen is not None and i == self.chosen.get(key):
                    break
            return found
        if isinstance(stage, Merger):
            near, found = start if flow is Flow.FORWARD else end, []
            for parts in product(*[self.solutions(c, flow, start, end) for c in stage.children]):
                for r in successes(outcomes(name, (near.scene, tuple(p.told for p in parts)), 2)):
                    found.append(self.away(name, flow, start, end, r.scene, r.scene, r.cost, parts))
            return found
        if isinstance(stage, Wrapper):
            found = []
            child, first, last = stage.children[0], self.into(stage, start, lane), self.into(stage, end, lane)
            for s in self.solutions(child, flow, first, last):
                _, before, after, cost, _ = s.told
                about = before, after, cost
                made = [Result(cost=0.0)] if isinstance(stage, Limit) else successes(outcomes(name, about, 2))
                found += [self.away(name, flow, start, end, before, after, r.cost + cost, (s,)) for r in made]
            return found
        return self.leaf(stage, flow, start, end)

    def leaf(self, stage, flow, start, end):
        name = stage.name
        if flow is Flow.GENERATE:
            given = self.triggers.get(stage, ()) if isinstance(stage, Watch) else None
            causes = [None] if given is None else [s[2] for s, n in dict(given).items() for _ in range(n)]
            found = [r for cause in causes for r in successes(outcomes(name, cause, 3 if given is None else 2))]
        elif flow is Flow.CONNECT:
            if chance(name, start.scene, end.scene, "fit").random() < 0.15:
                return []
            found = successes(outcomes(name, (start.scene, end.scene), 2))
        else:
            found = successes(outcomes(name, (start if flow is Flow.FORWARD else end).scene, 2))
        return [self.away(name, flow, start, end, r.scene, r.scene, r.cost) for r in found]

    @staticmethod
    def away(name, flow, start, end, before, after, cost, parts=()):
        """A solution whose states are those that were given, and else new."""
        lane = next((place.lane for place in (start, end) if place is not None), None)
        return Found.of(name, start or Place(before, lane), end or Place(after, lane), cost, parts)

    def into(self, stage, place, lane):
        """The counterpart inside a container of a state that comes to its border, one in each lane."""
        if place is None:
            return None
        lane = lane or place.lane
        return self.inner.setdefault((stage, place, lane), Place(place.scene, lane))

    def out(self, stage, place, lane):
        """The counterpart outside of a state at the border of a container, one in each lane."""
        return self.outer.setdefault((stage, place, lane), Place(place.scene, lane))

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

    def come(self, stage, side, place):
        """What is asked of a connecting stage for a state on one side, whether there is a partner or not."""
        if isinstance(stage, Serial):
            sections, connectors, _ = self.shape(stage)
            inner, ahead = self.into(stage, place, None), side is Flow.FORWARD
            for at, _ in self.chains(sections[0] if ahead else sections[-1][::-1], side, inner):
                self.come(connectors[0 if ahead else -1], side, at)
                if len(sections) > 2:  # its partners are generated inside
                    for row in self.generated(stage, 1 if ahead else len(sections) - 2):
                        for other, _ in row[0 if ahead else 2]:
                            pair = (at, other) if ahead else (other, at)
                            self.solutions(connectors[0 if ahead else -1], Flow.CONNECT, *pair)
        elif not isinstance(stage, Fallbacks):
            for child in stage.children:
                self.come(child, side, self.into(stage, place, None) if isinstance(stage, Wrapper) else place)

    def serial(self, stage, flow, start, end, before, after):
        """All ways through a container between states inside; where they are at a given border, outside."""
        self.begin(stage, flow)
        sections, connectors, _ = self.shape(stage)
        rows = []  # of each section: what it is made from, its ways to the left and to the right
        for i, section in enumerate(sections):
            side = self.reads(stage, flow, i)
            if side is None:
                rows.append(self.generated(stage, i))
            else:
                place = start if side is Flow.FORWARD else end
                way = self.chains(section if side is Flow.FORWARD else section[::-1], side, place)
                stay = [(place, ())]
                rows.append([(stay, (), way) if side is Flow.FORWARD else (way, (), stay)])
        links = {}
        for connector, here, there in zip(connectors, rows, rows[1:], strict=False):
            lefts = [t for row in here for t, _ in row[2]]
            rights = [u for row in there for u, _ in row[0]]
            for side, places in ((Flow.FORWARD, lefts), (Flow.BACKWARD, rights)):
                for place in places:
                    self.come(connector, side, place)
            for t, u in product(lefts, rights):
                links[connector, t, u] = self.solutions(connector, Flow.CONNECT, t, u)
        joined = [(s, t, (*left, *own, *right)) for a, own, b in rows[0] for s, left in a for t, right in b]
        for connector, row in zip(connectors, rows[1:], strict=True):
            joined = [
                (s, f, (*before, link, *left, *own, *right))
                for s, t, before in joined
                for a, own, b in row
                for u, left in a
                for link in links[connector, t, u]
                for f, right in b
            ]
            if len(joined) > MOST:
                raise Undefined
        lane = next((place.lane for place in (before, after) if place is not None), None)
        return [
            Found.of(
                stage.name,
                before or self.out(stage, s, lane),
                after or self.out(stage, f, lane),
                sum(p.told[3] for p in parts),
                parts,
            )
            for s, f, parts in joined
        ]

    def generated(self, stage, i):
        """A section with a generator, made once."""
        if (stage, i) not in self.made:
            self.made[stage, i] = []
            section, where = self.shape(stage)[0][i], self.shape(stage)[2][i]
            for child in section[:where]:
                self.begin(child, Flow.BACKWARD)
            for child in section[where + 1 :]:
                self.begin(child, Flow.FORWARD)
            found = self.solutions(section[where], Flow.GENERATE)
            firsts, lasts = dict.fromkeys(s.start for s in found), dict.fromkeys(s.end for s in found)
            lefts = {p: self.chains(section[:where][::-1], Flow.BACKWARD, p) for p in firsts}
            rights = {p: self.chains(section[where + 1 :], Flow.FORWARD, p) for p in lasts}
            self.made[stage, i] = [(lefts[s.start], (s,), rights[s.end]) for s in found]
        return self.made[stage, i]

    def chains(self, stages, flow, place):
        """The states to which the stages lead from one, with the ways there."""
        ways = [(place, ())]
        for stage in stages:
            grown = []
            for at, way in ways:
                if flow is Flow.FORWARD:
                    grown += [(s.end, (*way, s)) for s in self.solutions(stage, flow, start=at)]
                else:
                    grown += [(s.start, (s, *way)) for s in self.solutions(stage, flow, end=at)]
            ways = grown
        return ways


def successes(found):
    return [r for r in found if isinstance(r, Result)]
