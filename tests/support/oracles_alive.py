"""What can run in a run of a task, found out from scratch: every state looked at anew, nothing remembered.

`audit` is called after every job (`Task(audit=…)`) and compares: what the scheduler calls dead must be dead, and what it
parked must be of no use. At the end (`at_rest`) both must be equal, and every job that is left parked.
"""

from kabo.tasks.core.model.solutions import LEFT, RIGHT
from kabo.tasks.core.run.fallbacks import ConnectingFallbacksNode, PropagatingFallbacksNode
from kabo.tasks.core.run.groups import ParallelNode, SerialNode
from kabo.tasks.core.run.job_queues import Leaf
from kabo.tasks.core.run.leaves import ConnectorNode, PropagatorNode
from kabo.tasks.core.run.wrappers import WrapperNode


def audit(run):
    """Nothing that is of use was given up."""
    scratch = Scratch(run)
    for state in scratch.states:
        for side in (LEFT, RIGHT):
            assert state.alive[side] or not scratch.alive(state, side), f"{state} was given up too early"
    for node, job in scratch.parked():
        assert not scratch.runnable(node, job), f"{node.stage.path}: a job was parked that can run"


def at_rest(run):
    """Nothing is left to do, and nothing is taken for alive that is dead."""
    audit(run)
    scratch = Scratch(run)
    for node in run.order:
        if isinstance(node, Leaf) and not node.closed and getattr(node, "_started", True):
            assert set(node.jobs) == set(node.parked), f"{node.stage.path}: a job that can run was left"
    for state in scratch.states:
        for side in (LEFT, RIGHT):
            assert state.alive[side] == scratch.alive(state, side), f"{state} is taken for alive"


class Scratch:
    """One look at a run."""

    def __init__(self, run):
        self.run = run
        self.known = {}
        found = {}
        for node in run.order:
            for solution in node.solutions:
                for state in (solution.start, solution.end):
                    if state is not None and state.level is not None:
                        found[state] = None
        waiting = list(found)
        while waiting:
            for inner in waiting.pop().inside:
                if inner not in found:
                    found[inner] = None
                    waiting.append(inner)
        self.states = list(found)

    def parked(self):
        return [
            (n, job) for n in self.run.order if isinstance(n, Leaf) and not n.closed for job in n.parked.values()
        ]

    def runnable(self, node, job):
        """Whether all states are alive that a job does not compute."""
        if isinstance(node, ConnectorNode):
            return self.alive(job.subject[0], LEFT) and self.alive(job.subject[1], RIGHT)
        if isinstance(node, PropagatorNode):
            return self.alive(job.subject, LEFT if node.reads[LEFT] else RIGHT)
        ends = (job.subject.start, job.subject.end) if isinstance(node, WrapperNode) else (job.subject[0],) * 2
        return all(self.alive(ends[side], side) for side in (LEFT, RIGHT) if node.reads[side])

    def alive(self, state, side):
        if (state, side) not in self.known:
            self.known[state, side] = self.leads_on(state, side)
        return self.known[state, side]

    def leads_on(self, state, side):
        level = state.level
        if level is None:
            return True
        if any(self.alive(edge.end if side == RIGHT else edge.start, side) for edge in state.edges[side]):
            return True
        place = state.position if side == RIGHT else state.position - 1
        if not 0 <= place < len(level.children):
            waits = isinstance(level.owner, WrapperNode) and level.owner.works_at_border(state)
            if level.top or level.owner.kept or not state.outside or waits:
                return True
            return any(self.alive(outer, side) for outer in state.outside)
        node = level.children[place]
        if node.reads[1 - side]:
            return self.works(node, state, side)
        near = [
            inner for inner in state.inside if inner.position == (len(inner.level.children) if side == LEFT else 0)
        ]
        return any(self.alive(inner, side) for inner in near)

    def works(self, node, state, side):
        """Whether a node may still lead on from a state."""
        if node.closed:
            return False
        if isinstance(node, PropagatorNode):
            return state in node.jobs
        if isinstance(node, ConnectorNode):
            partners = [subject[side] for subject in node.jobs if subject[1 - side] is state]
        elif isinstance(node, ConnectingFallbacksNode):
            lanes = [lane for found in node._pairs.values() for lane in found]
            pairs = [(lane.start, lane.end) for lane in lanes]
            partners = [pair[side] for pair in pairs if pair[1 - side] is state]
        elif isinstance(node, PropagatingFallbacksNode):
            return node._left(state) or any(self.works(child, state, side) for child in node._had(state))
        elif isinstance(node, (SerialNode, WrapperNode)):
            return any(self.alive(inner, side) for inner in state.inside if inner.level is node.inner)
        elif isinstance(node, ParallelNode):
            return any(self.works(child, state, side) for child in node.children)
        else:
            return node.works_on(state, side)
        return node.parent.delivers_to(node, side) or any(self.alive(partner, side) for partner in partners)
