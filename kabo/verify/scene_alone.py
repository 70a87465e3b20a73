"""A scene without a problem: plans made of tasks are judged in it by their motion alone, as nothing is known or wanted."""

import hashlib
from dataclasses import dataclass

from kabo.language.formulas import Number, ProcedureCall
from kabo.language.problem import Action, Domain, Problem
from kabo.language.scene_description import SceneDescription
from kabo.plan import Plan


@dataclass(frozen=True)
class SceneAlone(Problem):
    """A problem that is no more than its scene: every action of the plan is a task, which may move all that moves.

    The plan's own start counts: a task may begin elsewhere than the scene does.
    """

    @property
    def moved(self) -> dict[str, tuple[str, ...]]:
        """What tasks may move: all robots and movable bodies of the scene."""
        assert self.scene is not None
        movable = tuple(name for name, body in self.scene.bodies.items() if body.movable)
        return {"robot": tuple(self.scene.robots), "body": movable, "region": ()}


def scene_alone(scene: SceneDescription, plan: Plan) -> SceneAlone:
    """The problem in which a plan of tasks is judged in a scene.

    Raises:
        OSError: the scene's file does not exist any more.
    """
    names = dict.fromkeys(str(node.action) for node in plan.nodes.values() if node.action is not None)
    actions = {name: Action(name, (), (), ProcedureCall(name), (), (), Number(1.0)) for name in names}
    domain = Domain("tasks", {}, {}, {}, {}, (), actions)
    digest = "sha256:" + hashlib.sha256(scene.path.read_bytes()).hexdigest()
    return SceneAlone(plan.problem, domain, {}, (), (), {}, scene, scene.path, {scene.path.name: digest})
