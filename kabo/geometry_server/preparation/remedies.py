"""Findings about links and bodies whose meshes cannot be enclosed: what they belong to, the cause, and what would help."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from kabo.errors import Diagnostic, MeshError
from kabo.meshes import Mesh, hull_of, repaired, require_closed
from kabo.scene import Element, Scene


@dataclass(frozen=True)
class Failure:
    """An element of a body or `robot.link` that cannot be enclosed, and why."""

    thing: str
    element: Element
    error: MeshError


def findings(scene: Scene, failures: Sequence[Failure]) -> list[Diagnostic]:
    """A finding for each failure: mesh file, body or robot and link, cause, and remedies that have been tried."""
    hulls = _lines_to_paste(scene, failures)
    found = []
    for failure in failures:
        robot, dot, _ = failure.thing.partition(".")
        for finding in failure.error.diagnostics:
            said = _with_path(finding.message, failure.element.path)
            ways = list(_ways(failure, finding, hulls.get(robot) if dot else None))
            told = replace(
                finding, message=f"{owner(failure.thing)}: {said}", hint="; or ".join(ways) or finding.hint
            )
            found.append(_at_its_place(told, failure.element))
    return found


def flat_hull(failure: Failure) -> MeshError:
    """The error for a link in `hulls` that lies in a plane."""
    told = (
        replace(finding, message=f"{owner(failure.thing)}: {_with_path(finding.message, failure.element.path)}")
        for finding in failure.error.diagnostics
    )
    return MeshError(_at_its_place(finding, failure.element) for finding in told)


def owner(thing: str) -> str:
    """A body or `robot.link` in words."""
    robot, dot, link = thing.partition(".")
    return f'link "{link}" of robot "{robot}"' if dot else f'body "{thing}"'


def _with_path(message: str, path: Path | None) -> str:
    """A message about a mesh with the whole path of its file, where it says `the mesh` or the file's name."""
    if path is None:
        return message
    return message.replace(f'mesh file "{path.name}"', f'mesh file "{path}"', 1).replace(
        "the mesh ", f'mesh file "{path}" ', 1
    )


def _at_its_place(finding: Diagnostic, element: Element) -> Diagnostic:
    """The finding where the scene or URDF names the mesh, with the line that does."""
    place = element.place
    if place is None:
        return finding
    source = _line(Path(place.file), place.line)
    return replace(
        finding, file=place.file, line=place.line, column=place.column, length=place.length, source=source
    )


def _line(path: Path, number: int) -> str | None:
    try:
        return path.read_text(errors="replace").splitlines()[number - 1]
    except (OSError, IndexError):
        return None


def _lines_to_paste(scene: Scene, failures: Sequence[Failure]) -> Mapping[str, str]:
    """For each robot, the key `hulls` with the links that have it already and those that fail, as far as hulls exist."""
    lines = {}
    for name, robot in scene.robots.items():
        failed = dict.fromkeys(
            each.thing.partition(".")[2] for each in failures if each.thing.startswith(f"{name}.")
        )
        links = [link for link in failed if _has_hull(robot.links[link].mesh)]
        if links:
            lines[name] = f"hulls: [{', '.join([*robot.hulls, *links])}]"
    return lines


def _has_hull(mesh: Mesh | None) -> bool:
    try:
        return mesh is not None and hull_of(mesh) is not None
    except MeshError:
        return False


def _ways(failure: Failure, finding: Diagnostic, hulls: str | None) -> Iterator[str]:
    """What would help, each as a part of a sentence."""
    robot = failure.thing.partition(".")[0]
    if hulls is not None:
        yield f'write `{hulls}` at robot "{robot}" in the scene, to take their convex hulls'
    path = failure.element.path
    name = "the mesh" if path is None else path.name
    if _closes(failure.element.mesh):
        yield finding.hint or "ask for a larger epsilon"
        return
    done = _repair(failure.element.mesh)
    if done is not None:
        yield (
            f"repair it: `kabo bound {name} --repair --epsilon 0.001 -o {Path(name).stem}.off` closes it "
            f"({', '.join(done)}); then name the new file"
        )
        return
    said = "give it a primitive shape" if hulls is not None else "give it a primitive shape, or close its holes"
    yield f"{said} (`--repair` does not close it)"


def _closes(mesh: Mesh) -> bool:
    try:
        require_closed(mesh)
    except MeshError:
        return False
    return True


def _repair(mesh: Mesh) -> list[str] | None:
    """What safe repairs did if they close a mesh; None if they do not."""
    made, done = repaired(mesh)
    return done if _closes(made) else None
