"""From where a drawing is looked at: chosen, unless somebody asks for a place, a thing to look at, or a size."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.pictures.cameras import Camera, fitted, natural_aspect
from kabo.pictures.drawing import Drawing
from kabo.pictures.labels import labelled, with_lines
from kabo.pictures.rendering import Pixels, Stage

WIDTH = 1200  # of a picture whose size nobody asked for [pixels]
AROUND = 0.25  # [m] to each side of a point that is looked at

Place = tuple[float, float, float]


@dataclass(frozen=True)
class ViewWishes:
    """What somebody asks for; None where the picture may choose.

    Args:
        camera: where the camera stands [m]. look_at: a point [m], or the name of a thing. size: width and height
            [pixels]. labels: whether names are written.
    """

    camera: Place | None = None
    look_at: Place | str | None = None
    size: tuple[int, int] | None = None
    labels: bool = True


@dataclass(frozen=True)
class View:
    """A camera, and the size of the picture that it takes [pixels]."""

    camera: Camera
    size: tuple[int, int]


def picture_of(drawing: Drawing, wishes: ViewWishes) -> Pixels:
    """The picture of a drawing (H, W, 3), with its names."""
    stage = Stage(drawing, wishes.size or (WIDTH, WIDTH))
    try:
        view = chosen_view(stage, drawing.points, wishes, WIDTH)
        return taken(stage, view, labels=wishes.labels)
    finally:
        stage.close()


def taken(
    stage: Stage, view: View, *, labels: bool = True, font: int = 15, drawing: Drawing | None = None
) -> Pixels:
    """The picture that a stage shows (H, W, 3), with the lines and names of a drawing, its own unless given."""
    shown = stage.drawing if drawing is None else drawing
    stage.resize(view.size)
    pixels, _ = stage.shot(view.camera)
    if shown.lines:
        pixels = with_lines(pixels, view.camera, shown.lines)
    if labels and shown.labels:
        pixels = labelled(pixels, stage.visible(view.camera), view.camera, shown, font)
    return pixels


def chosen_view(
    stage: Stage,
    points: Array,
    wishes: ViewWishes,
    width: int,
    states: Sequence[Mapping[str, Array]] = ({},),
) -> View:
    """The view of points (N, 3): as wished; else from the side that shows most, as near as shows all.

    Args:
        stage: shows the drawing. points: that must be seen [m]. wishes: what is asked for. width: of the picture
            where no size is asked for [pixels]; its height follows from what is seen. states: of a film: the poses
            (4, 4) of what moves at some of its moments.

    Raises:
        InputError: the thing to be looked at does not exist.
    """
    looked_at = _looked_at(stage.drawing, points, wishes.look_at)
    middle = (looked_at.min(axis=0) + looked_at.max(axis=0)) / 2.0
    if wishes.camera is None:
        away = stage.best_direction(looked_at, states)
    else:
        away = np.array(wishes.camera) - middle
        if not np.any(away):
            raise InputError(
                [Diagnostic("--camera", 1, 1, "the camera stands where it looks", "move one of both")]
            )
    size = wishes.size or _size(width, natural_aspect(looked_at, away))
    if wishes.camera is not None and wishes.look_at is not None:
        return View(Camera(np.array(wishes.camera), middle), size)
    return View(fitted(looked_at, away, size[0] / size[1]), size)


def _size(width: int, aspect: float) -> tuple[int, int]:
    return width, 2 * round(width / aspect / 2.0)


def _looked_at(drawing: Drawing, points: Array, wanted: Place | str | None) -> Array:
    """The points (N, 3) that the picture must hold."""
    if wanted is None:
        return points
    if not isinstance(wanted, str):
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
        return np.asarray(wanted) + AROUND * corners
    found = [s.world_points for s in drawing.everything if s.name == wanted or s.name.startswith(f"{wanted}.")]
    if not found:
        known = _names(solid.name for solid in drawing.everything)
        hint = did_you_mean(wanted, known) or f"there are {', '.join(known)}; or give a point: X,Y,Z"
        raise InputError([Diagnostic("--look-at", 1, 1, f'there is no "{wanted}" to look at', hint)])
    return np.concatenate(found)


def _names(solids: Iterable[str]) -> list[str]:
    """Robots and bodies, without the links."""
    return list(dict.fromkeys(name.partition(".")[0] for name in solids))
