"""What is foreseen of a scene as findings of `kabo check`, each at its place in the file."""

import logging
from collections.abc import Callable, Iterator, Sequence

from kabo.children import never
from kabo.errors import About, Diagnostic, MeshError
from kabo.geometry_server.foresight.contacts import idle_contacts
from kabo.geometry_server.foresight.measures import Measure, millimetres
from kabo.geometry_server.foresight.openings import too_wide
from kabo.geometry_server.foresight.regions import uncontained
from kabo.geometry_server.foresight.starts import StartFault, start_faults
from kabo.geometry_server.foresight.tipping import tipping
from kabo.geometry_server.preparation.preparing import Preparing, prepare
from kabo.geometry_server.server import GeometryServer
from kabo.language.formulas import Place
from kabo.language.scene_description import SceneDescription
from kabo.phases import phase
from kabo.scene import Body, Scene, load_scene

_LOG = logging.getLogger("kabo.geometry_server")


def start_findings(
    description: SceneDescription,
    scene: Scene | None = None,
    stop: Callable[[], bool] = lambda: False,
    preparing: Callable[[Preparing], None] | None = None,
    *,
    parts: bool = True,
) -> list[Diagnostic]:
    """Warnings about a scene that loads, whatever is planned in it; or errors of meshes that cannot be enclosed.

    Objects that overlap, stand inside others, are too near, hang in the air or tip over at the start; regions that can
    contain none of the objects; objects that no gripper can open for; permitted contacts that are never needed.

    Args:
        description: the scene as described in its file, with what a problem adds.
        scene: the loaded scene; None loads it.
        stop: called while convex parts are made; True ends that.
        preparing: told while convex parts are made.
        parts: whether convex parts may be made; without them nothing is said of things that are near, or of contacts.

    Raises:
        InputError: the scene does not load.
    """
    loaded = load_scene(description, never) if scene is None else scene
    server = GeometryServer(loaded, description.epsilon, 0, False, stop)
    if parts:
        try:
            prepare(server.surroundings.enclosures, told=preparing)
        except MeshError as error:
            return list(error.diagnostics)
    with phase("looking at the start", log=_LOG):
        faults = start_faults(server.surroundings, parts=parts)
    found = [*_at_the_start(description, faults), *_tipping(description, loaded)]
    found += [*_regions(description, loaded), *_grippers(description, loaded)]
    with phase("looking for contacts that are never needed", log=_LOG):
        idle = idle_contacts(description, server.surroundings) if parts else iter(())
        return found + [_contact(description, pair, said) for pair, said in idle]


def _at_the_start(description: SceneDescription, faults: Sequence[StartFault]) -> Iterator[Diagnostic]:
    for fault in faults:
        deep = fault.kind in ("overlap", "inside") and fault.metres is not None
        about = About(fault.things, -fault.metres if deep and fault.metres is not None else fault.metres)
        # A link of a robot has no line in the scene; of any two things at fault, one is an object of it.
        named = next(name for name in fault.things if name in description.bodies)
        yield _warning(description, description.bodies[named].place, fault.said, fault.hint, about)


def _tipping(description: SceneDescription, scene: Scene) -> Iterator[Diagnostic]:
    for each in tipping(scene):
        said = (
            f"{each.name} tips over at the start: the middle of its mass is {millimetres(each.metres)} beside "
            f"{' and '.join(each.carriers)}, if its mass is spread evenly"
        )
        hint = "move it so that its middle is above what it stands on"
        about = About((each.name, *each.carriers), each.metres)
        yield _warning(description, description.bodies[each.name].place, said, hint, about)


# ------------------------------------------------------------------------------------------------------ regions
def _regions(description: SceneDescription, scene: Scene) -> Iterator[Diagnostic]:
    """A warning for every region that can contain no object, and for every object that no region can contain."""
    proofs: dict[tuple[str, str], Measure | None] = {}
    wanted = [body for body in _distinct(scene) if _asks_inside(body)]
    for name, region in scene.regions.items():
        for body in wanted:
            proofs[name, body.name] = uncontained(scene, body, region, region.support)
        found = [proofs[name, body.name] for body in wanted]
        if found and all(proof is not None for proof in found):
            said = min((proof for proof in found if proof is not None), key=lambda proof: proof.missing)
            hint = "what is placed there has to lie inside, with all of its height and width"
            place = description.regions[name].place
            text = f'region "{name}" can contain no object: {said.text}'
            yield _warning(description, place, text, hint, About((name,), said.missing))


def _asks_inside(body: Body) -> bool:
    return any(c.kind == "inside" for family in body.placements.values() for c in family.constraints)


def _distinct(scene: Scene) -> list[Body]:
    """The movable bodies, one of each mesh and model."""
    found: dict[object, Body] = {}
    for body in scene.bodies.values():
        if body.movable:
            found.setdefault((body.mesh.digest, *body.placements, *body.grasps), body)
    return list(found.values())


# ----------------------------------------------------------------------------------------------------- grippers
def _grippers(description: SceneDescription, scene: Scene) -> Iterator[Diagnostic]:
    """A warning for every object that is wider than the grippers open, in every grasp of every robot."""
    for body in _distinct(scene):
        found = [each for robot in scene.robots.values() for each in _widths(scene, body, robot.name)]
        if found and all(each is not None for each in found):
            said = min((each for each in found if each is not None), key=lambda each: each.missing)
            hint = "`open` of the gripper may be more, as far as its joints' limits go; or scale the object"
            place = description.bodies[body.name].place
            about = About((body.name,), said.missing)
            yield _warning(description, place, f'nobody can grasp "{body.name}": {said.text}', hint, about)


def _widths(scene: Scene, body: Body, name: str) -> list[Measure | None]:
    """For every grasp family that a robot may use: how much wider the body is than its gripper opens, if it is."""
    robot = scene.robots[name]
    if robot.tool is None or robot.gripper is None:
        return []
    hand = tuple(robot.gripper.open.get(joint, 0.0) for joint in robot.gripper_joints)
    usable = [f for f in body.grasps.values() if f.robots is None or name in f.robots]
    return [too_wide(robot, body, family, hand) for family in usable]


# ----------------------------------------------------------------------------------------------------- contacts
def _contact(description: SceneDescription, pair: tuple[str, str], said: str) -> Diagnostic:
    text = f"the allowed contact of {pair[0]} and {pair[1]} is never needed: {said}"
    hint = "leave it out: it hides nothing but mistakes"
    return _warning(description, _place_of(description, pair), text, hint, About(pair))


def _place_of(description: SceneDescription, pair: tuple[str, str]) -> Place | None:
    """The line of the scene file that names both things of a pair, after the key `allowed_contacts`."""
    try:
        lines = description.path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return None
    begun = False
    for number, line in enumerate(lines, start=1):
        begun = begun or line.lstrip().startswith("allowed_contacts")
        if begun and all(name in line for name in pair):
            column = line.index(pair[0]) + 1
            return Place(str(description.path), number, column, len(pair[0]))
    return None


def _warning(description: SceneDescription, place: Place | None, text: str, hint: str, about: About) -> Diagnostic:
    at = place or Place(str(description.path), 1, 1)
    return Diagnostic(at.file, at.line, at.column, text, hint, at.length, severity="warning", about=about)
