"""The convex parts of the links and bodies of a scene: unions of what encloses their elements, each computed once."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from kabo import geometry
from kabo.children import never
from kabo.content_cache import ContentCache
from kabo.errors import MeshError
from kabo.geometry import Enclosure
from kabo.geometry_server.preparation.remedies import Failure, findings, flat_hull
from kabo.meshes import Mesh
from kabo.scene import Element, Scene, with_hulls

_ENCLOSURES: ContentCache[Enclosure] = ContentCache(16 << 20, lambda made: made.nbytes)


class SceneEnclosures:
    """The enclosures of one scene within a tolerance [m]; `look` is called while parts are made, and may raise."""

    def __init__(self, scene: Scene, tolerance: float) -> None:
        self.scene, self.tolerance = scene, tolerance
        self.look: Callable[[], None] = never
        # The scene keeps parts, since each seed has a server of its own.
        self._made: dict[str, Enclosure] = scene.memory.setdefault(("enclosures", tolerance), {})
        self._united: dict[str, Enclosure] = scene.memory.setdefault(("united enclosures", tolerance), {})
        self._hulls: dict[str, tuple[Element, ...]] = scene.memory.setdefault("hulls", {})

    @property
    def things(self) -> list[str]:
        """The bodies and links (`robot.link`) that have geometry, in the order of the scene."""
        links = [
            f"{robot.name}.{link.name}"
            for robot in self.scene.robots.values()
            for link in robot.links.values()
            if link.elements
        ]
        return [*links, *self.scene.bodies]

    def elements(self, name: str) -> tuple[Element, ...]:
        """The elements of which a body or `robot.link` consists for bounded predicates: hulls in links of `hulls`.

        Raises:
            MeshError: such a link is flat, and has no hull.
        """
        robot, dot, link = name.partition(".")
        if not dot:
            return self.scene.bodies[name].elements
        own = self.scene.robots[robot].links[link]
        if link not in self.scene.robots[robot].hulls or not own.elements:
            return own.elements
        if name not in self._hulls:
            try:
                self._hulls[name] = with_hulls(own.elements)
            except MeshError as error:
                raise flat_hull(Failure(name, own.elements[0], error)) from None
        return self._hulls[name]

    def of(self, name: str) -> Enclosure:
        """The enclosure of a body or `robot.link`, in its own frame.

        Raises:
            MeshError: elements cannot be enclosed; each is named, with what would help.
        """
        if name not in self._united:
            own, failures = [], []
            for element in self.elements(name):
                try:
                    own.append(self.of_element(element))
                except MeshError as error:
                    failures.append(Failure(name, element, error))
            if failures:
                raise MeshError(findings(self.scene, failures))
            self._united[name] = geometry.united(own)
        return self._united[name]

    def of_element(self, element: Element) -> Enclosure:
        """The enclosure of an element, in its owner's frame.

        Raises:
            MeshError: its mesh cannot be enclosed.
        """
        exact = exact_enclosure(element)
        if exact is not None:
            return exact
        digest = element.mesh.digest
        if digest not in self._made:
            self._made[digest] = _ENCLOSURES.get_or_make(
                self._key(element.mesh), lambda: made_parts(element.mesh, self.tolerance, self.look)
            )
        return self._made[digest]

    def keep(self, mesh: Mesh, made: Enclosure, refinable: bool) -> None:
        """Keeps parts of a mesh that were made in another process; if `refinable`, they are refined in this one."""
        made = replace(made, finer=_Refinement(mesh, self.tolerance)) if refinable else made
        self._made[mesh.digest] = _ENCLOSURES.get_or_make(self._key(mesh), lambda: made)

    def known(self, element: Element) -> bool:
        """Whether the enclosure of an element is there already, or takes no time."""
        return element.mesh.digest in self._made or exact_enclosure(element) is not None

    def _key(self, mesh: Mesh) -> tuple[object, ...]:
        return mesh.digest, geometry.digest_beside(mesh.path), self.tolerance


@dataclass(frozen=True)
class _Refinement:
    """Refines the parts of a mesh, which it reads when this is first asked for: a tree is large, and is asked seldom."""

    mesh: Mesh
    tolerance: float
    read: list[Enclosure] = field(default_factory=list)

    def __call__(self, part: int) -> Enclosure:
        """The enclosure in which a part has children."""
        if not self.read:
            self.read.append(made_parts(self.mesh, self.tolerance))
        finer = self.read[0].finer
        if finer is None:
            raise ValueError(f"part {part} of an enclosure has no finer one")
        return finer(part)


def exact_enclosure(element: Element) -> Enclosure | None:
    """The enclosure of a primitive shape, which is that shape: one part; None for a mesh."""
    if element.corners is None:
        return None
    return Enclosure((element.corners,), 0.0, () if element.rounding is None else (element.rounding,))


def made_parts(mesh: Mesh, tolerance: float, look: Callable[[], None] = never) -> Enclosure:
    """The parts of a mesh, read from a file or made; `look` is called while they are made.

    Raises:
        MeshError: the mesh cannot be enclosed.
    """
    return geometry.enclosing_parts(mesh, tolerance, look=look)
