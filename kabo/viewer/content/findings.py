"""What `kabo check` finds in a scene, with the place of each finding in the scene."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from kabo.errors import About, Diagnostic
from kabo.language import check_files
from kabo.language.scene_description import SceneDescription
from kabo.scene import Scene


def scene_findings(
    scene: Scene, description: SceneDescription, files: Iterable[Path], *, prepared: bool
) -> list[Diagnostic]:
    """The findings in files and in the scene that they describe, those that are errors first.

    Args:
        scene: the loaded scene.
        description: its description.
        files: the files that were given.
        prepared: whether all convex parts of the scene are there; if not, only what needs none of them is examined.
    """
    from kabo.geometry_server import robot_findings, start_findings  # needs kernels
    from kabo.scene.findings import findings_in_scene

    found = [
        *check_files(files),
        *findings_in_scene(description, scene),
        *robot_findings(description, scene=scene, configurations=prepared),
        *start_findings(description, scene, parts=prepared),
    ]
    return sorted(dict.fromkeys(found), key=lambda each: (each.severity, each.file, each.line, each.message))


def finding_view(finding: Diagnostic, scene: Scene) -> dict[str, Any]:
    """A finding in the view document; `place` is None if it is about nothing that could be shown."""
    return {
        "severity": finding.severity,
        "message": finding.message,
        "hint": finding.hint,
        "file": Path(finding.file).name,
        "line": finding.line,
        "column": finding.column,
        "place": None if finding.about is None else _place(finding.about, scene),
    }


def _place(about: About, scene: Scene) -> dict[str, Any]:
    """Where a finding is: the things, the pair if there are two, their distance [m], and the robots' values then."""
    names = set(scene.bodies) | set(scene.regions) | set(scene.robots)
    names |= {f"{robot.name}.{link}" for robot in scene.robots.values() for link in robot.links}
    robots = {}
    if about.values is not None:
        robot, q = about.values
        robots[robot] = dict(zip(scene.robots[robot].joint_names, q, strict=False))
    return {
        "things": [name for name in about.things if name in names],
        "pair": list(about.things) if len(about.things) == 2 else None,
        "region": next((name for name in about.things if name in scene.regions), None),
        "metres": about.metres,
        "robots": robots,
    }
