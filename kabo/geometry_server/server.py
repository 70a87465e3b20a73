"""The geometry server: procedures and predicates over one scene, as pure functions with a memory.

Nothing here changes but caches and counters: the same question has the same answer, whenever and however often it
is asked.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from kabo.geometry import Budget
from kabo.geometry_server.answers import Answer, Failure, Statistics, Success
from kabo.geometry_server.candidates import Stream
from kabo.geometry_server.context import Context
from kabo.geometry_server.frames import WORLD, rows, standing_frame, tool_frame
from kabo.geometry_server.identifiers import IdentifierMap
from kabo.geometry_server.predicates import ScenePredicates
from kabo.geometry_server.procedures import PROCEDURES, Signature
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.workspace import Surroundings, Workspace
from kabo.kinematics import stream_key
from kabo.language.formulas import GroundCall
from kabo.language.scene_description import Constraint
from kabo.scene import GeometricState, Scene, world_T

Array = npt.NDArray[np.float64]

BATCHES, MORE_BATCHES = 4, 4  # of candidates: at effort 0, and by which factor more at each further level
PATH_SAMPLES, MORE_PATH_SAMPLES = 400, 3  # of one path search, in the same way


@dataclass(frozen=True)
class Bound:
    """A ground call bound to its signature: arguments by name, and the components it moves and reads."""

    signature: Signature
    arguments: Mapping[str, str]
    moves: tuple[str, ...]
    reads: tuple[str, ...]


@dataclass
class GeometryServer:
    """Answers geometric questions about a scene, within epsilon [m] (None: the scene's), from streams of `seed`."""

    scene: Scene
    epsilon: float | None = None
    seed: int = 0
    exact: bool = False
    stop: Callable[[], bool] = lambda: False
    statistics: Statistics = field(default_factory=Statistics)

    def __post_init__(self) -> None:
        self.budget = Budget.share(self.scene.epsilon if self.epsilon is None else self.epsilon)
        self.surroundings = Surroundings(self.scene, self.budget, self.exact, self.statistics)
        self.identifiers = IdentifierMap()
        self._bound: dict[GroundCall, Bound] = {}
        self._answers: dict[tuple[object, ...], Answer] = {}

    # ---------------------------------------------------------------------------------------------- procedures
    def bind(self, call: GroundCall) -> Bound:
        """The signature of a call with its arguments by name."""
        if call not in self._bound:
            signature = PROCEDURES[call.procedure]
            names = (*signature.parameters, *signature.optional)
            arguments = dict(signature.optional) | dict(zip(names, map(str, call.arguments), strict=False))
            arguments |= {name: str(value) for name, value in call.options}
            components = {*self.scene.robots, *self.scene.movable}
            moves = tuple(arguments[p] for p in signature.moves if arguments[p] in components)
            reads = tuple(arguments[p] for p in signature.reads if arguments[p] in components)
            self._bound[call] = Bound(signature, arguments | {"procedure": call.procedure}, moves, reads)
        return self._bound[call]

    def single(self, call: GroundCall, situation: Situation) -> tuple[str, ...]:
        """The components that must have one value before a call: what it moves, carries and refers to, sorted."""
        bound = self.bind(call)
        robots = [name for name in bound.moves if name in self.scene.robots]
        held = {name for robot in robots for name in situation.carried(robot)}
        return tuple(sorted({*bound.moves, *bound.reads, *held}))

    def call(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> Answer:
        """The answer of a procedure for every value that the situation leaves open, remembered."""
        key = (call, attempt, effort, situation.key)
        if key not in self._answers:
            bound = self.bind(call)
            answer = bound.signature.run(self.context(effort), bound.arguments, situation, attempt)
            self.statistics.record(call.procedure, answer)
            self._answers[key] = answer
            if isinstance(answer, Success):
                self.identify(situation.replace(answer.changes).first)
        return self._answers[key]

    @property
    def states_met(self) -> int:
        """How many distinct geometric states procedures have led to."""
        return len(self.identifiers)

    # ---------------------------------------------------------------------------------------------- predicates
    def collides(self, first: str, second: str | Sequence[float], state: GeometricState | None = None) -> bool:
        """Whether a robot at q (n,) may hit anything, or two things (bodies, `robot.link`) each other [K Def. 1].

        Args:
            first: a robot, or a thing. second: the robot's configuration, or the other thing.
            state: where everything else is; the first one if None.
        """
        if isinstance(second, str):
            return self.predicates(state).collide(first, second)
        return self._workspace(first, state).first_hit(np.array(second, dtype=np.float64)) is not None

    def sweep_collides(
        self, robot: str, start: Sequence[float], goal: Sequence[float], state: GeometricState | None = None
    ) -> bool:
        """Whether a robot may hit anything on the straight joint segment from `start` to `goal` (n,) each."""
        ends = np.array(start, dtype=np.float64), np.array(goal, dtype=np.float64)
        return self._workspace(robot, state).segment_hit(*ends) >= 0

    def includes(self, container: str, body: str, state: GeometricState | None = None) -> bool:
        """Whether a body is proven to lie inside a region or another thing, in a state (the first one if None)."""
        return self.predicates(state).included(container, body)

    def predicates(self, state: GeometricState | None = None) -> ScenePredicates:
        """Predicates on things and motions by name, in a state (the first one if None)."""
        return ScenePredicates(self.surroundings, state or self.scene.start)

    def sample(
        self,
        constraints: Iterable[Constraint],
        robot: str,
        this: str | None = None,
        state: GeometricState | None = None,
        *,
        batches: int = 1,
    ) -> Array:
        """Configurations (N, n) of a robot that fulfil constraints between `tool`, `world` and an object `this`."""
        chosen, now = self.scene.robots[robot], state or self.scene.start
        roles = {"tool": tool_frame(chosen), "world": WORLD}
        if this is not None:
            roles["this"] = standing_frame(self.scene.bodies[this], world_T(self.scene, now, this))
        hand = tuple(now.robots[robot][chosen.planned :])
        stream = Stream(chosen, rows(constraints, roles), stream_key(self.seed, "sample", robot, this or ""), hand)
        found = [candidate.q for number in range(batches) for candidate in stream.batch(number)]
        return np.array(found).reshape(-1, chosen.tree.size)

    def _workspace(self, robot: str, state: GeometricState | None) -> Workspace:
        return Workspace.of(self.surroundings, robot, Situation.of(state or self.scene.start))

    # ------------------------------------------------------------------------------------------------- the map
    def identify(self, state: GeometricState) -> int:
        """The identifier of a geometric state [K Def. 5]."""
        return self.identifiers.identify(state)

    def state(self, identifier: int) -> GeometricState:
        """The geometric state of an identifier."""
        return self.identifiers.state(identifier)

    # -------------------------------------------------------------------------------------------------- proofs
    def refuted(self, call: GroundCall) -> Failure | None:
        """Why a call fails wherever what it reads is as at the start, if that can be told before any search."""
        bound = self.bind(call)
        refute = bound.signature.refute
        return None if refute is None else refute(self.context(0), bound.arguments, Situation.of(self.scene.start))

    def context(self, effort: int = 0) -> Context:
        """What procedures and stages are given to work with, with more to try at each level of effort."""
        batches, samples = BATCHES * MORE_BATCHES**effort, PATH_SAMPLES * MORE_PATH_SAMPLES**effort
        return Context(self.surroundings, self.seed, batches, samples, self.stop)
