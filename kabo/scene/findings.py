"""Findings in a scene's meshes and URDFs: errors of loading it, and warnings about sizes and inverted meshes."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from kabo.errors import About, Diagnostic, InputError
from kabo.language.files import geometry_files
from kabo.language.scene_description import SceneDescription
from kabo.meshes import FORMATS, load_mesh, outwards, units_warning
from kabo.scene.elements import Element
from kabo.scene.holding import weak_grippers
from kabo.scene.scene import Scene, load_scene


def findings_in_scene(description: SceneDescription, scene: Scene | None = None) -> tuple[Diagnostic, ...]:
    """The errors of loading a scene; if there are none, warnings about sizes, turned meshes, weak grippers.

    `scene` is the loaded scene; None loads it.
    """
    try:
        scene = scene or load_scene(description)
    except InputError as error:
        return error.diagnostics
    return (
        *_unit_warnings(scene, description),
        *_turned_warnings(scene, description),
        *weak_grippers(scene, description),
    )


def _turned_warnings(scene: Scene, description: SceneDescription) -> Iterator[Diagnostic]:
    """Warnings about mesh files with components that are inside out; loading turns them."""
    owners: dict[Path, list[str]] = {}
    for name, elements in _things(scene):
        for path in {each.path for each in elements if each.path is not None}:
            owners.setdefault(path, []).append(name)
    for path in dict.fromkeys(geometry_files(description)):
        if path.suffix.lower().removeprefix(".") in FORMATS:
            done = outwards(load_mesh(path))[1]
            if done is not None:
                fix = "export it with its normals outwards; kabo plans and verifies with the turned mesh"
                about = About(tuple(owners[path])) if path in owners else None
                yield Diagnostic(str(path), 1, 1, done, fix, severity="warning", about=about)


def _things(scene: Scene) -> Iterator[tuple[str, tuple[Element, ...]]]:
    """The bodies and links (`robot.link`) with their elements."""
    yield from ((name, body.elements) for name, body in scene.bodies.items())
    for name, robot in scene.robots.items():
        yield from ((f"{name}.{link.name}", link.elements) for link in robot.links.values())


def _unit_warnings(scene: Scene, description: SceneDescription) -> tuple[Diagnostic, ...]:
    """Warnings about meshes of bodies and robots that are so large that they may be in millimetres."""
    found = [
        _of(units_warning(body.mesh, description.bodies[name].shape.place), name)
        for name, body in scene.bodies.items()
        if body.mesh.path is not None
    ]
    found += [
        _of(
            units_warning(
                link.mesh,
                next(
                    (each.place for each in link.elements if each.place is not None),
                    description.robots[name].place,
                ),
                named=f'link "{link_name}" of robot "{name}"',
                fix='then scale it in the URDF: <mesh scale="0.001 0.001 0.001" …/>',
            ),
            f"{name}.{link_name}",
        )
        for name, robot in scene.robots.items()
        for link_name, link in robot.links.items()
        if link.mesh is not None
    ]
    return tuple(warning for warning in found if warning is not None)


def _of(warning: Diagnostic | None, thing: str) -> Diagnostic | None:
    return None if warning is None else replace(warning, about=About((thing,)))
