"""What a solve keeps for later ones of the same problem, which begin in states of its run.

Grounding and the scene are kept as they are, since neither depends on where a plan begins. Of the plan are kept its
continuations: in a state that it has foreseen, the rest of it is the plan; in another one, its rest is the first skeleton
whose motions are looked for.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from kabo.knowledge import GroundedTask
from kabo.language import file_of
from kabo.language.problem import Problem
from kabo.options import Options
from kabo.plan import Done, Node, Plan, State, StateChange, state_after, topological_order
from kabo.plan.writing import rounded_state
from kabo.planner.continuing import action_key, require_of
from kabo.planner.geometry.evaluation import Variant
from kabo.planner.search.skeleton import Skeleton, SkeletonNode
from kabo.scene import Scene
from kabo.whole_files import file_hash


@dataclass
class Memo:
    """Knowledge of former solves: give the same one to each solve of a problem; it is empty at first.

    A solve of another problem, or with other options, begins it anew.

    Example:
        >>> problem, memo = kabo.load_problem("domains/stacked/n2.yaml"), kabo.Memo()
        >>> plan = kabo.solve(problem, memo=memo).plan
        >>> state = kabo.after(problem, plan, [(plan.root, None)])
        >>> kabo.solve(problem, start=state, memo=memo)
        <Result solved: 3 nodes, 1 outcome, 2 actions at most>
    """

    problem: Problem | None = field(default=None, repr=False)
    options: Mapping[str, object] | None = field(default=None, repr=False)  # those on which plans depend
    task: GroundedTask | None = field(default=None, repr=False)
    scene: Scene | None = field(default=None, repr=False)
    plan: Plan | None = None
    skeletons: dict[str, SkeletonNode] = field(default_factory=dict, repr=False)
    continued: bool = False  # whether the last plan does the actions of the rest of the one before
    outdated: str | None = (
        None  # a file that has changed since the plan was made: only its actions are tried again
    )

    @classmethod
    def of_plan(cls, problem: Problem, plan: Plan) -> "Memo":
        """What a plan tells that was made by another process, with the options of its header.

        Raises:
            InputError: it is a plan of another problem.
        """
        require_of(problem, plan)
        return cls(problem, dict(plan.options), plan=plan, outdated=_changed_file(problem, plan))

    def begin(self, problem: Problem, options: Options) -> None:
        """Forgets everything, unless it is of this problem and these options."""
        depends = _without_quality(options.written())
        if self.problem is not problem or _without_quality(self.options or {}) != depends:
            self.problem, self.options, self.task, self.scene = problem, depends, None, None
            self.plan, self.skeletons, self.outdated = None, {}, None

    def keep(self, plan: Plan, variants: tuple[Variant, ...]) -> None:
        """Keeps the continuations of a plan, whose variants are given; the first one is its root."""
        self.plan, self.skeletons, self.outdated = plan, {}, None
        waiting = [(plan.root, variants[0])]
        while waiting:
            name, variant = waiting.pop()
            if name not in self.skeletons:
                self.skeletons[name] = variant.node
                node = plan.nodes[name]
                for outcome, after in variant.following.items():
                    waiting.append((str(node.next if outcome is None else node.branches[outcome]), after))

    def rest(self, state: State) -> Plan | None:
        """The rest of the plan, if the state is one that it has foreseen."""
        found = self._reached(state)
        if found is None or self.plan is None or self.outdated is not None:
            return None
        name, foreseen = found
        if foreseen.geometry is None or state.geometry is None:
            same = foreseen.geometry is state.geometry
        else:
            same = rounded_state(foreseen.geometry) == rounded_state(state.geometry)
        if not same or self.plan.nodes[name].overlap > 0.0:
            return None
        return _from(self.plan, name, state)

    def foreseen(self, state: State) -> tuple[StateChange, tuple[Done, ...]] | None:
        """Where the plan has everything after what was done, events aside, and those events.

        None if there is no plan, it has no geometry or is of other files, or what was done is no way through it.
        """
        events = () if self.problem is None else self.problem.domain.events
        before = 0 if self.plan is None else len(self.plan.done or ())
        happened = tuple(step for step in state.done[before:] if step.action in events)
        steps = (step for step in state.done[before:] if step.action not in events)
        found = self._reached(replace(state, done=(*state.done[:before], *steps)))
        if found is None or found[1].geometry is None or self.outdated is not None:
            return None
        return found[1].geometry, happened

    def not_compared(self) -> str | None:
        """Why a state in which `foreseen` finds nothing cannot be compared with the plan; None if there is no plan."""
        if self.plan is None:
            return None
        if self.outdated is not None:
            return f"the former plan is of other files ({self.outdated} has changed since)"
        if self.plan.start is None:
            return "the former plan has no geometry"
        return "what was done is no way through the former plan"

    def skeleton(self, state: State) -> Skeleton | None:
        """The continuation of the plan after what was done, whatever has become of the geometry."""
        found = self._reached(state)
        if found is None or self.plan is None or self.task is None:
            return None
        if not self.skeletons:
            self.skeletons = _skeletons_of(self.plan, self.task)
        return Skeleton(self.skeletons[found[0]]) if found[0] in self.skeletons else None

    def _reached(self, state: State) -> tuple[str, State] | None:
        """The node of the plan to which what was done leads, and the state in which the plan is there."""
        plan = self.plan
        before = () if plan is None else plan.done or ()
        if plan is None or state.done[: len(before)] != before:
            return None
        name, history = plan.root, []
        for step in state.done[len(before) :]:
            node = plan.nodes[name]
            if not _is(node, step):
                return None
            history.append((name, step.outcome))
            following = node.next if step.outcome is None else node.branches.get(step.outcome)
            if following is None:
                return None
            name = following
        return name, state_after(plan, history)


def _changed_file(problem: Problem, plan: Plan) -> str | None:
    """The first of the files of which a plan was made that is not as it was; None if all are."""
    for name, digest in sorted(plan.files.items()):
        try:
            now = problem.files.get(name) or file_hash(file_of(name, problem.path.parent))
        except OSError:
            return name
        if now != digest:
            return name
    return None


def _without_quality(options: Mapping[str, object]) -> dict[str, object]:
    """Options without that for how long motions are made faster: a good plan's actions are as well the first to try."""
    return {name: value for name, value in options.items() if name != "quality"}


def _is(node: Node, step: Done) -> bool:
    return (node.action, dict(node.arguments), node.on) == (step.action, dict(step.arguments), step.on)


def _skeletons_of(plan: Plan, task: GroundedTask) -> dict[str, SkeletonNode]:
    """The continuations of a plan that another process made, as far as the problem has its actions."""
    actions = {action_key(action.name, action.arguments): action for action in task.actions}
    found: dict[str, SkeletonNode] = {}
    for name in reversed(topological_order(plan) or []):
        node = plan.nodes[name]
        action = None if node.action is None else actions.get(action_key(node.action, node.arguments))
        if (node.action is not None and action is None) or any(after not in found for after in node.successors):
            continue
        outcomes = tuple((outcome, found[after]) for outcome, after in node.branches.items())
        following = None if node.next is None else found[node.next]
        found[name] = SkeletonNode(action, 0, node.on, outcomes, following, node.delivers)
    return found


def _from(plan: Plan, root: str, state: State) -> Plan:
    """The part of a plan that is reached from a node, which begins in a state; its nodes keep their names."""
    names, waiting = {root}, [root]
    while waiting:
        more = set(plan.nodes[waiting.pop()].successors) - names
        names |= more
        waiting += more
    nodes = {name: node for name, node in plan.nodes.items() if name in names}
    certificate = plan.certificate
    if certificate is not None:
        segments = tuple(each for each in certificate.segments if each.node in names)
        proofs = tuple(each for each in certificate.proofs if each.node in names)
        certificate = replace(certificate, segments=segments, proofs=proofs)
    start = None if state.geometry is None else rounded_state(state.geometry)
    return replace(plan, root=root, nodes=nodes, start=start, done=state.done, certificate=certificate)
