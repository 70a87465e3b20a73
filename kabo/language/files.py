"""The files that a problem depends on: texts, meshes, URDFs, and the meshes that the URDFs name."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree  # noqa: S405  expat of every supported Python limits entity expansion

from kabo.language.problem import Problem
from kabo.language.robot_files.packages import SCHEME, package_folder
from kabo.language.scene_description import SceneDescription


def files_of(problem: Problem) -> Iterator[Path]:
    """Every file that solving a problem reads: its text files, URDFs, meshes, and convex parts of meshes."""
    folder = problem.path.parent
    yield problem.path
    yield from (folder / name for name in problem.files)
    if problem.scene is not None:
        for path in geometry_files(problem.scene):
            yield path
            parts = path.with_name(path.name + ".parts")
            if parts.is_file():
                yield parts


def geometry_files(scene: SceneDescription) -> Iterator[Path]:
    """The meshes, URDFs and SRDFs of a scene, and the meshes that the URDFs name."""
    for shape in (*(body.shape for body in scene.bodies.values()), *(r.shape for r in scene.regions.values())):
        if shape.path is not None:
            yield shape.path
    yield from (body.srdf for body in scene.bodies.values() if body.srdf is not None)
    for robot in scene.robots.values():
        if robot.semantics is not None:
            yield robot.semantics.path
        own = None if robot.gripper is None else robot.gripper.urdf
        for urdf in (robot.urdf, own):
            if urdf is not None:
                yield urdf
                yield from meshes_of(urdf, scene.packages)


def meshes_of(urdf: Path, packages: Mapping[str, Path]) -> Iterator[Path]:
    """The mesh files that a URDF names; none if the file is not a URDF, which loading the scene reports."""
    try:
        root = ElementTree.parse(urdf).getroot()  # noqa: S314
    except (ElementTree.ParseError, OSError, UnicodeDecodeError):
        return
    for element in root.iter("mesh"):
        name = element.get("filename", "")
        if name.startswith(SCHEME):
            package, _, rest = name.removeprefix(SCHEME).partition("/")
            folder = package_folder(package, packages, urdf)
            if folder is not None:
                yield folder / rest
        elif name:
            yield urdf.parent / name.removeprefix("file://")
