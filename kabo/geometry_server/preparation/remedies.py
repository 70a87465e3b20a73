"""Findings about links and bodies whose meshes cannot be enclosed: what they belong to, the cause, and what would help."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from kabo.errors import About, Diagnostic, MeshError, by_place
from kabo.meshes import Mesh, hull_of, repaired, require_closed
from kabo.scene import Element, Scene

_MESH = re.compile(r'mesh file "[^"]*"|the mesh(?= )')
AS_ABOVE = "hulls"  # in place of a line to paste that an earlier finding shows


@dataclass(frozen=True)
class Failure:
    """An element of a body or `robot.link` that cannot be enclosed, and why."""

    thing: str
    element: Element
    error: MeshError


def findings(scene: Scene, failures: Sequence[Failure]) -> list[Diagnostic]:
    """A finding for each failure: mesh file, body or robot and link, cause, and remedies that have been tried.

    They are sorted by place. The line `hulls` with all links to paste stands in the first finding of each robot only.
    """
    helped = _links_with_hulls(scene, failures)
    found, shown = [], set()
    for told, failure in sorted(_placed(failures), key=lambda each: by_place(each[0])):
        robot, dot, link = failure.thing.partition(".")
        line = None
        if dot and link in helped[robot]:
            named = ", ".join([*scene.robots[robot].hulls, *helped[robot]])
            line = AS_ABOVE if robot in shown else f"hulls: [{named}]"
            shown.add(robot)
        hint = "; or ".join(_ways(failure, told, line)) or told.hint
        found.append(replace(told, hint=hint, about=About((failure.thing,))))
    return found


def _placed(failures: Sequence[Failure]) -> Iterator[tuple[Diagnostic, Failure]]:
    """What is said of each failure, where the file of the scene or robot names the mesh."""
    for failure in failures:
        for finding in failure.error.diagnostics:
            said = f"{owner(failure.thing)}: {_with_path(finding.message, failure.element.path)}"
            yield _at_its_place(replace(finding, message=said), failure.element), failure


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
    """A message about a mesh with the whole path of its file; equal meshes of several files share one message."""
    return message if path is None else _MESH.sub(lambda _: f'mesh file "{path}"', message, count=1)


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


def _links_with_hulls(scene: Scene, failures: Sequence[Failure]) -> Mapping[str, Sequence[str]]:
    """For each robot, the links that fail, are not in `hulls`, and have hulls."""
    failed = dict.fromkeys(each.thing for each in failures)
    return {
        name: [
            link
            for link in robot.links
            if f"{name}.{link}" in failed and link not in robot.hulls and _has_hull(robot.links[link].mesh)
        ]
        for name, robot in scene.robots.items()
    }


def _has_hull(mesh: Mesh | None) -> bool:
    try:
        return mesh is not None and hull_of(mesh) is not None
    except MeshError:
        return False


def _ways(failure: Failure, finding: Diagnostic, hulls: str | None) -> Iterator[str]:
    """What would help, each as a part of a sentence."""
    robot = failure.thing.partition(".")[0]
    if hulls is not None:
        yield (
            "its convex hull, as above"
            if hulls == AS_ABOVE
            else f'write `{hulls}` at robot "{robot}" in the scene, to take the convex hulls of such meshes'
        )
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
