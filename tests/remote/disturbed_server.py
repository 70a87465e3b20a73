"""A robot server in whose world something happens to a body: `disturbed_server.py PROBLEM ENDPOINT KIND BODY WHEN`.

`pushed`: it is moved by 17 mm where it stands; `dropped`: a hand lets it fall, and it lies 0.15 m beside.
"""

import sys

import numpy as np

import kabo
from kabo.execution import KinematicRobot
from kabo.remote import RobotServer, RobotServerSettings
from kabo.scene import Attachment, Scene
from kabo.service import server_config

PUSHED, BESIDE = (0.014, -0.009), (0.0, -0.15)  # [m]


class DisturbedRobot(KinematicRobot):
    """A robot without forces; `when` counts seconds in which robots have moved."""

    def __init__(self, scene: Scene, kind: str, body: str, when: float) -> None:
        super().__init__(scene)
        self.kind, self.body, self.when, self.moved = kind, body, when, 0.0

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        self.moved += seconds if self.state().moving else 0.0
        held = self.world.objects[self.body].parent != "world"
        if self.moved < self.when or held != (self.kind == "dropped"):
            return
        self.when = np.inf
        if held:
            self._hang(self.body, "world")
        own, start = self.world.objects[self.body], self.scene.start.objects[self.body]
        x, y = np.add(own.position[:2], BESIDE if held else PUSHED).tolist()
        z, turn = (start.position[2], start.quaternion) if held else (own.position[2], own.quaternion)
        self.world = self.world.replace({self.body: Attachment("world", (x, y, z), turn)})
        sys.stderr.write(f"{self.body} was {self.kind}\n")


def main(problem: str, endpoint: str, kind: str, body: str, when: str) -> None:
    """Serves until it is killed."""
    scene = kabo.load_scene(problem)
    robot = DisturbedRobot(scene, kind, body, float(when))
    server = RobotServer(server_config([endpoint]), robot, scene, RobotServerSettings(20.0, 5.0))
    sys.stderr.write("serves\n")
    sys.stderr.flush()
    server.run(lambda: False)


if __name__ == "__main__":
    main(*sys.argv[1:])
