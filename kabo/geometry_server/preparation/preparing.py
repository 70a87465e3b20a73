"""Prepares a scene: makes the convex parts of all its links and bodies in parallel processes, and tells each of them."""

import os
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

from kabo.children import made_in_children, never
from kabo.compilation import usual_kernels_compiled
from kabo.displays import counted
from kabo.errors import CutOff, MeshError
from kabo.geometry import Budget, Enclosure
from kabo.geometry_server.preparation.enclosures import SceneEnclosures, made_parts
from kabo.geometry_server.preparation.remedies import Failure, findings
from kabo.meshes import Mesh
from kabo.scene import Scene

SHOWN_MISSING = 6  # things that are not prepared, named when preparation is cut off
SHOWN_NEXT = 3  # likewise, while it goes on
SMALL_TRIANGLES = 5_000  # of a mesh whose parts are read in some milliseconds


@dataclass(frozen=True)
class PreparedThing:
    """A body or `robot.link` with its parts, and the seconds that it took to make them; 0 if they were there."""

    name: str
    triangles: int
    parts: int
    vertices: int
    seconds: float

    def __str__(self) -> str:
        """The line that tells of it."""
        counts = f"{counted(self.triangles, 'triangle')}, {counted(self.parts, 'part')}"
        return f"{self.name}: {counts}, {counted(self.vertices, 'vertex', 'vertices')} ({self.seconds:.1f} s)"


@dataclass(frozen=True)
class Preparing:
    """The state of a preparation: how many things there are, which of them are not prepared yet, and a line to keep."""

    total: int
    missing: tuple[str, ...]
    line: str

    @property
    def fraction(self) -> float:
        """The share of things that are prepared."""
        return 1.0 - len(self.missing) / max(1, self.total)

    def __str__(self) -> str:
        """The state in words: `preparing geometry: 3 of 12 done, not yet r.link5, r.hand and 7 more`."""
        ready = self.total - len(self.missing)
        more = f", not yet {_few(self.missing, SHOWN_NEXT)}" if self.missing else ""
        return f"preparing geometry: {ready} of {self.total} done{more}"


class PreparationCutOff(CutOff):
    """Preparation was cut off; `details` say what is done, what is not, and that the former is kept."""

    def __init__(self, state: Preparing) -> None:
        ready = state.total - len(state.missing)
        self.details = (
            f"geometry was prepared for {ready} of {state.total} links and bodies, not for {_few(state.missing)}",
            "what is done is kept in the cache: the next run goes on from there",
        )
        super().__init__(f"it was cut off while preparing geometry: {'; '.join(self.details)}")


@dataclass(frozen=True)
class _Made:
    """What a process sends back: the parts, and the time that it took to compute them; 0 if they were read."""

    enclosure: Enclosure
    seconds: float
    refinable: bool

    @classmethod
    def of(cls, made: Enclosure, seconds: float) -> "_Made":
        """Parts as they are sent: without the tree that refines them, which may be large."""
        return cls(replace(made, finer=None), seconds, made.finer is not None)


class _NotStored(Exception):
    """A mesh is sound, but its parts stand in no file."""


def prepare_scene(
    scene: Scene,
    *,
    epsilon: float | None = None,
    processes: int | None = None,
    look: Callable[[], None] = never,
    told: Callable[[Preparing], None] | None = None,
) -> list[PreparedThing]:
    """As `prepare`, for a scene and epsilon [m] (None: the scene's); servers of the scene use these parts."""
    budget = Budget.share(scene.epsilon if epsilon is None else epsilon)
    enclosures = SceneEnclosures(scene, budget.geometry)
    enclosures.look = look
    return prepare(enclosures, processes=processes, told=told)


def read_prepared(enclosures: SceneEnclosures, *, processes: int | None = None) -> tuple[str, ...]:
    """The things of a scene that have no parts in any file, in its order; the parts of others are then known.

    As `prepare`, but nothing is made, and no unsound mesh raises an error.
    """
    return _Preparation(enclosures, lambda _: None).read(processes or cores())


def prepare(
    enclosures: SceneEnclosures,
    *,
    processes: int | None = None,
    told: Callable[[Preparing], None] | None = None,
) -> list[PreparedThing]:
    """All bodies and links of a scene with their parts, in its order; the parts are then known to `enclosures`.

    Parts are read, and where there are none made, in child processes, those of large meshes first. What comes out
    depends neither on the number of processes nor on their order. `enclosures.look` is called periodically; if it raises
    CutOff, the processes are killed. If meshes are unsound, nothing is made.

    Args:
        enclosures: the enclosures of the scene, which knows some of them perhaps.
        processes: how many at once; None: as many as there are processors.
        told: called when parts must be made, and with each thing for which they were.

    Raises:
        MeshError: some meshes cannot be enclosed; the error lists all of them, each with what would help.
        PreparationCutOff: time or memory was spent, or the run was interrupted.
    """
    return _Preparation(enclosures, told or (lambda _: None)).run(processes or cores())


def cores() -> int:
    """The number of processors that this process may use."""
    with suppress(AttributeError, OSError):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Preparation:
    def __init__(self, enclosures: SceneEnclosures, told: Callable[[Preparing], None]) -> None:
        self.enclosures, self.told = enclosures, told
        self.seconds: dict[str, float] = {}  # by digest of a mesh
        self.flat: list[Failure] = []  # links without a hull
        self.failed: dict[str, MeshError] = {}  # by digest
        self.missing: dict[str, set[str]] = {}  # for each thing, the digests of meshes that have no parts yet
        self.meshes: dict[str, Mesh] = {}
        self.prepared: dict[str, PreparedThing] = {}
        for name in enclosures.things:
            self._add(name)
        self.total = len(self.missing)

    def run(self, processes: int) -> list[PreparedThing]:
        self._finish_ready()
        try:
            self._read_small()
            self._in_children(_stored, list(self.meshes), processes)
            self._raise_failures()
            if self.meshes:
                self._make(processes)
            self.enclosures.look()
        except CutOff:
            raise PreparationCutOff(self._state()) from None
        return [self.prepared[name] for name in self.enclosures.things]

    def read(self, processes: int) -> tuple[str, ...]:
        self._finish_ready()
        self._read_small()
        self._in_children(_stored, list(self.meshes), processes)
        return tuple(name for name in self.enclosures.things if name not in self.prepared)

    def _make(self, processes: int) -> None:
        """Makes the parts that stand in no file, and tells of it."""
        began, missing = perf_counter(), len(self.missing)
        some = f"of {missing} of {self.total}" if missing < self.total else f"of all {self.total}"
        self._tell(f"preparing geometry: the convex parts {some} links and bodies; they are kept for later runs")
        if not usual_kernels_compiled():  # else each process compiles the same ones
            self._in_children(_made, [min(self.meshes, key=lambda digest: len(self.meshes[digest].faces))], 1)
        self._in_children(_made, list(self.meshes), processes)
        self._raise_failures()
        parts = counted(sum(each.parts for each in self.prepared.values()), "part")
        vertices = counted(sum(each.vertices for each in self.prepared.values()), "vertex", "vertices")
        self._tell(f"geometry is prepared: {parts}, {vertices} ({perf_counter() - began:.1f} s)")

    def _tell(self, line: str) -> None:
        self.told(self._state(line))

    def _add(self, name: str) -> None:
        """Notes which meshes of a thing have no parts yet; a hull that does not exist is a failure."""
        try:
            elements = self.enclosures.elements(name)
        except MeshError as error:
            self.missing[name] = set()
            robot, _, link = name.partition(".")
            self.flat.append(Failure(name, self.enclosures.scene.robots[robot].links[link].elements[0], error))
            return
        unknown = [each for each in elements if not self.enclosures.known(each)]
        self.missing[name] = {each.mesh.digest for each in unknown}
        self.meshes.update((each.mesh.digest, each.mesh) for each in unknown)

    def _read_small(self) -> None:
        """Takes the stored parts of small meshes in this process, which is as quick as to start another one."""
        for digest in [digest for digest, mesh in self.meshes.items() if len(mesh.faces) <= SMALL_TRIANGLES]:
            self.enclosures.look()
            with suppress(_NotStored):
                try:
                    self._take(digest, _stored(self.meshes[digest], self.enclosures.tolerance))
                except MeshError as error:
                    self._take(digest, error)

    def _in_children(self, make: Callable[[Mesh, float], _Made], digests: list[str], processes: int) -> None:
        """Takes the parts of meshes from processes; large meshes begin first, those of one size in the scene's order."""
        ordered = sorted(digests, key=lambda digest: -len(self.meshes[digest].faces))
        makes = [partial(make, self.meshes[digest], self.enclosures.tolerance) for digest in ordered]
        with closing(made_in_children(makes, processes, self.enclosures.look)) as found:
            for index, made in found:
                if not isinstance(made, _NotStored):
                    self._take(ordered[index], made)

    def _take(self, digest: str, made: "_Made | Exception") -> None:
        mesh = self.meshes.pop(digest)
        if isinstance(made, MeshError):
            self.failed[digest] = made
        elif isinstance(made, Exception):
            raise made
        else:
            self.seconds[digest] = made.seconds
            self.enclosures.keep(mesh, made.enclosure, made.refinable)
        for missing in self.missing.values():
            missing.discard(digest)
        self._finish_ready()

    def _finish_ready(self) -> None:
        """Notes, and tells, the things whose meshes all have parts, or have none because they cannot."""
        for name in [name for name, missing in self.missing.items() if not missing]:
            del self.missing[name]
            if not self._failures_of(name):
                self.prepared[name] = done = self._thing(name)
                if done.seconds:
                    self._tell(str(done))

    def _failures_of(self, name: str) -> list[Failure]:
        """The elements of a thing that cannot be enclosed, as far as that is known by now."""
        flat = [each for each in self.flat if each.thing == name]
        return flat or [
            Failure(name, each, self.failed[each.mesh.digest])
            for each in self.enclosures.elements(name)
            if each.mesh.digest in self.failed
        ]

    def _thing(self, name: str) -> PreparedThing:
        enclosure, elements = self.enclosures.of(name), self.enclosures.elements(name)
        seconds = [self.seconds.get(digest, 0.0) for digest in {each.mesh.digest for each in elements}]
        return PreparedThing(
            name,
            sum(len(each.mesh.faces) for each in elements if each.kind == "mesh"),
            len(enclosure.parts),
            sum(map(len, enclosure.parts)),
            sum(seconds),
        )

    def _state(self, line: str = "") -> Preparing:
        return Preparing(self.total, tuple(self.missing), line)

    def _raise_failures(self) -> None:
        """Raises all failures that are known: also those of things with other meshes that have no parts yet."""
        if self.flat or self.failed:
            failures = [failure for name in self.enclosures.things for failure in self._failures_of(name)]
            raise MeshError(findings(self.enclosures.scene, failures))


def _stored(mesh: Mesh, tolerance: float) -> _Made:
    """The parts of a mesh as they are stored; _NotStored if there are none: the maker looks before it begins."""

    def refuse() -> None:
        raise _NotStored

    return _Made.of(made_parts(mesh, tolerance, refuse), 0.0)


def _made(mesh: Mesh, tolerance: float) -> _Made:
    """The parts of a mesh, computed now."""
    began = perf_counter()
    made = made_parts(mesh, tolerance)
    return _Made.of(made, perf_counter() - began)


def _few(names: tuple[str, ...], shown: int = SHOWN_MISSING) -> str:
    more = f" and {len(names) - shown} more" if len(names) > shown else ""
    return ", ".join(names[:shown]) + more
