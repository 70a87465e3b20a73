"""Drawings of scenes as a simulation has them: the shapes that touch, wherever everything is.

What is drawn is what contacts are computed of: primitive shapes as they are, meshes as the hulls of their parts.
"""

from dataclasses import replace

import numpy as np

from kabo.meshes.hulls import hull_faces
from kabo.pictures.drawing import Drawing, Solid
from kabo.pictures.scenes import scene_drawing
from kabo.scene import GeometricState, Scene
from kabo.simulation.contact_shapes import contact_shapes
from kabo.simulation.settings import USUAL, PhysicsSettings


def simulated_drawing(
    scene: Scene, state: GeometricState | None = None, settings: PhysicsSettings = USUAL, *, labels: bool = True
) -> Drawing:
    """The drawing of the shapes that touch in a simulation of a scene.

    Args:
        scene: the scene. state: where everything is; None: as the scene begins. settings: of the simulation.
        labels: whether names are written.

    Raises:
        MeshError: a mesh has no volume, and no hull.
    """
    drawing = scene_drawing(scene, state, labels=labels)
    return replace(drawing, solids=tuple(_touching(scene, solid, settings) for solid in drawing.solids))


def _touching(scene: Scene, solid: Solid, settings: PhysicsSettings) -> Solid:
    """A solid as it touches: as it is, if all of it is primitive shapes."""
    hulls = [
        s.corners for s in contact_shapes(scene, solid.name, settings.contact_precision) if s.corners is not None
    ]
    if not hulls:
        return solid
    faces, count = [], 0
    for corners in hulls:
        faces.append(np.asarray(hull_faces(corners)) + count)
        count += len(corners)
    return replace(solid, vertices=np.concatenate(hulls), faces=np.concatenate(faces), smooth=False)
