"""The geometry server: predicates and samples over one scene, as pure functions with cached results.

Only caches and counters change: the same arguments always give the same result.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from kabo.arrays import Array
from kabo.errors import CutOff
from kabo.geometry import Budget
from kabo.geometry_server.answers import GeometryStatistics
from kabo.geometry_server.context import ProcedureContext
from kabo.geometry_server.identifiers import IdentifierMap
from kabo.geometry_server.predicates import ScenePredicates
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.geometry_server.teams import Team, TeamStream
from kabo.geometry_server.workspace import Workspace
from kabo.given import require_flag, require_function, require_given
from kabo.language.scene_description import Constraint
from kabo.options import require_clearance, require_epsilon, require_seed
from kabo.scene import GeometricState, Scene
from kabo.streams import stream_key

BATCHES, BATCHES_GROWTH = 4, 4  # of candidates: at effort 0, and the factor of each further level
PATH_SAMPLES, PATH_SAMPLES_GROWTH = 400, 3  # of one path search, likewise

HASTY_PATH_SAMPLES = 60  # of a path search while other candidates are left: most paths that are found need fewer
# Candidates in a row that movable things block, at effort 0: these had better be moved. After n in a row, with 95 %
# confidence fewer than 3 / n are free (the rule of three): less than one in thirteen.
MAX_BLOCKED_IN_A_ROW = 40


@dataclass
class GeometryServer:
    """Predicates and samples for one scene, with accuracy epsilon [m] (None: the scene's) and random streams of `seed`.

    Bodies keep `clearance` [m] from each other, and what the scene says is uncertain.

    Raises:
        ArgumentError: an argument is of a wrong kind, or a number that nothing can be computed with.
    """

    scene: Scene
    epsilon: float | None = None
    seed: int = 0
    exact: bool = False
    stop: Callable[[], bool] = lambda: False
    statistics: GeometryStatistics = field(default_factory=GeometryStatistics)
    clearance: float = 0.0

    def __post_init__(self) -> None:
        require_given("scene", self.scene, Scene)
        require_epsilon(self.epsilon)
        self.seed, self.clearance = require_seed(self.seed), require_clearance(self.clearance)
        require_flag("exact", self.exact)
        require_function("stop", self.stop)
        self.budget = Budget.share(self.scene.epsilon if self.epsilon is None else self.epsilon)
        self.surroundings = SceneSurroundings(
            self.scene, self.budget, self.exact, self.statistics, clearance=self.clearance
        )
        self.surroundings.look = self.look
        self.identifiers = IdentifierMap()

    def __repr__(self) -> str:
        return f"<GeometryServer {self.scene.name}: epsilon {1000 * self.budget.epsilon:g} mm, seed {self.seed}>"

    def look(self) -> None:
        """Raises CutOff if time or budget is spent."""
        if self.stop():
            raise CutOff

    # ---------------------------------------------------------------------------------------------- predicates
    def collides(self, first: str, second: str | Sequence[float], state: GeometricState | None = None) -> bool:
        """Whether a robot at q (n,) may collide with anything, or two things (bodies, `robot.link`) may collide [K Def. 1].

        Args:
            first: the name of a robot or thing.
            second: the robot's configuration, or the name of the other thing.
            state: the poses of everything else; the scene's first state if None.
        """
        if isinstance(second, str):
            return self.predicates(state).collide(first, second)
        return self._workspace(first, state).first_hit(np.array(second, dtype=np.float64)) is not None

    def sweep_collides(
        self, robot: str, start: Sequence[float], goal: Sequence[float], state: GeometricState | None = None
    ) -> bool:
        """Whether a robot may collide with anything on the straight joint segment from `start` to `goal`, (n,) each."""
        ends = np.array(start, dtype=np.float64), np.array(goal, dtype=np.float64)
        return self._workspace(robot, state).segment_hit(*ends) >= 0

    def includes(self, container: str, body: str, state: GeometricState | None = None) -> bool:
        """Whether a body is proven to lie inside a region or another thing, in a state (the first one if None)."""
        return self.predicates(state).included(container, body)

    def visible(self, sensor: str, body: str, state: GeometricState | None = None) -> bool:
        """Whether a camera (`robot.sensor`) is proven to see all of a body, in a state (the first one if None)."""
        return self.predicates(state).visible(sensor, body)

    def predicates(self, state: GeometricState | None = None) -> ScenePredicates:
        """Predicates on things and motions by name, in a state (the first one if None)."""
        return ScenePredicates(self.surroundings, state or self.scene.start)

    def sample(
        self,
        constraints: Iterable[Constraint],
        robots: str | Sequence[str],
        this: str | None = None,
        state: GeometricState | None = None,
        *,
        names: Mapping[str, str] | None = None,
        free: Sequence[str] = (),
        batches: int = 1,
    ) -> Array:
        """Configurations (N, n) of one or several robots that fulfil constraints between any two frames.

        Args:
            constraints: between features of `world`, `robot.tool`, `robot.<link>`, bodies and regions, or of the
                roles in `names`. With one robot, `tool` is its tool.
            robots: one name, or several: then a row of the result holds their configurations one after another.
            this: the body in the role `this`.
            state: the poses of everything (the first one if None); objects attached to one of the robots move with
            it.
            names: {role: name of a thing}.
            free: bodies that may be anywhere; in a row, six values for each follow the robots' values.
            batches: the number of batches of 64 samples each; only valid samples are returned.

        Raises:
            ValueError: a name or feature does not exist, or a constraint has no meaning for its features.
        """
        chosen = (robots,) if isinstance(robots, str) else tuple(robots)
        team, roles = Team.of(self.scene, chosen, free), dict(names or {})
        if this is not None:
            roles["this"] = this
        key = stream_key(self.seed, "sample", *chosen, this or "")
        stream = TeamStream.of(team, tuple(constraints), state or self.scene.start, key, roles)
        found = [candidate.q for number in range(batches) for candidate in stream.batch(number)]
        return np.array(found).reshape(-1, team.tree.size)

    def _workspace(self, robot: str, state: GeometricState | None) -> Workspace:
        return Workspace.of(self.surroundings, robot, Situation.of(state or self.scene.start))

    # ------------------------------------------------------------------------------------------------- the map
    def identify(self, state: GeometricState) -> int:
        """The identifier of a geometric state [K Def. 5]."""
        return self.identifiers.identify(state)

    def state(self, identifier: int) -> GeometricState:
        """The geometric state of an identifier."""
        return self.identifiers.state(identifier)

    # -------------------------------------------------------------------------------------------------- effort
    def context(self, effort: int = 0, hasty: bool = False, coarse: bool = False) -> ProcedureContext:
        """The context of procedures and stages, with more batches and samples at each level of effort.

        `hasty`: path searches give up early, since there are other candidates. `coarse`: few parts are divided, or none.
        """
        batches = BATCHES * BATCHES_GROWTH**effort
        samples = HASTY_PATH_SAMPLES if hasty else PATH_SAMPLES * PATH_SAMPLES_GROWTH**effort
        patience = MAX_BLOCKED_IN_A_ROW if effort == 0 else None
        surroundings = self.surroundings.coarser if coarse else None
        return ProcedureContext(
            surroundings or self.surroundings, self.seed, batches, samples, self.stop, patience
        )
