"""Leaves of py_trees that carry out the nodes of a plan on the robots and sensors of `kabo.execution`."""

from py_trees.behaviour import Behaviour
from py_trees.common import Access, Status

from kabo.execution import ExecutionSettings, Robot, Run, Sensor
from kabo.exporting.stepping import Stepping
from kabo.plan import Plan
from kabo.scene import Scene


class PlanLeaves:
    """The leaves for a file of `kabo export --to py_trees`: `create_tree(PlanLeaves(plan, scene, robot, sensor))`.

    The executor of kabo does the work, and watches as in `kabo execute`: a surprise is a planned stop, and the leaf fails
    with its reason as `feedback_message`. A tick lasts as long as the time between two looks at most; tick again at once.

    Args:
        plan: a plan that was verified.
        scene: of its problem; None for a plan without motions.
        robot: all robots of the scene; None for a plan without motions.
        sensor: answers what the plan asks.
        settings: how it is carried out.
    """

    def __init__(
        self,
        plan: Plan,
        scene: Scene | None,
        robot: Robot | None,
        sensor: Sensor,
        settings: ExecutionSettings | None = None,
    ) -> None:
        self.plan = plan
        self.stepping = Stepping(plan, scene, robot, sensor, settings or ExecutionSettings())

    @property
    def run(self) -> Run | None:
        """How the run ended; None while it goes on."""
        return self.stepping.run

    def __call__(self, node: str) -> Behaviour:
        """The leaf of a node.

        Raises:
            KeyError: the plan has no such node: the tree is of another plan.
        """
        return _Leaf(node, bool(self.plan.nodes[node].branches), self.stepping)


class _Leaf(Behaviour):
    def __init__(self, node: str, branches: bool, stepping: Stepping) -> None:
        super().__init__(node)
        self.stepping = stepping
        self.key = f"outcome_{node}" if branches else None
        if self.key is not None:
            self.board = self.attach_blackboard_client(name=node)
            self.board.register_key(self.key, access=Access.WRITE)

    def update(self) -> Status:
        if self.stepping.node is None:
            self.stepping.step()  # up to the beginning of the root
        if self.stepping.node == self.name and self.stepping.run is None:
            self.stepping.step()
        run = self.stepping.run
        if run is not None and not run.reached_goal:
            self.feedback_message = run.reason
            return Status.FAILURE
        if self.stepping.node == self.name:
            return Status.RUNNING
        if self.key is not None:
            self.board.set(self.key, self.stepping.outcomes[self.name])
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.status == Status.RUNNING:
            self.stepping.abandon()
            self.feedback_message = "it was interrupted: the robots stop along their path"
