"""Pictures of plans: a branch as a film strip or an animation, what a motion sweeps, the scene at a node."""

import logging
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.phases import phase
from kabo.pictures.drawing import Drawing, Label
from kabo.pictures.film import Film, Frame, described
from kabo.pictures.panels import captioned, framed, gif, grid, png, spread, titled
from kabo.pictures.rendering import Stage
from kabo.pictures.scenes import poses_in, scene_drawing
from kabo.pictures.views import View, ViewWishes, chosen_view, taken
from kabo.plan import Plan, branch_of
from kabo.scene import Scene

_LOG = logging.getLogger("kabo.pictures")
MAX_LOOKS = 4  # frames by which the side is chosen
STRIP_WIDTH, COLUMNS, MAX_PANELS, CAPTION_ROWS = 1200, (3, 4), 12, 3
ANIMATION_WIDTH, MAX_FRAMES, FRAME_STEP = 520, 90, 0.1  # pixels, frames, and [s] of plan time between two


def film_strip(plan: Plan, scene: Scene, branch: str | None, wishes: ViewWishes, file: str) -> bytes:
    """Key frames of a branch as PNG: the start, and the state after each motion, with what was sensed between.

    Raises:
        InputError: the branch does not exist, or nothing moves on it.
    """
    film = _film(plan, scene, branch, file)
    frames = list(film.key_frames())
    kept = spread(len(frames), MAX_PANELS)
    columns = _columns(len(kept))
    stage, view = _staged(film, frames, wishes, STRIP_WIDTH // columns)
    panels = []
    try:
        with phase("drawing", len(kept), "frames", log=_LOG) as step:
            for number in kept:
                frame = frames[number]
                stage.place(poses_in(scene, frame.state))
                drawing = _named(stage.drawing, film, frame, everything=number == 0)
                pixels = framed(taken(stage, view, labels=wishes.labels, font=13, drawing=drawing))
                lines = _caption(frames, kept, number)
                panels.append(captioned(pixels, lines, CAPTION_ROWS))
                step()
    finally:
        stage.close()
    title = f"{plan.problem}: {described(plan)}; shown: {_branch_text(film)}"
    return png(titled(grid(panels, columns), title))


def animation(plan: Plan, scene: Scene, branch: str | None, wishes: ViewWishes, file: str) -> bytes:
    """A branch as an animated GIF, in real time or faster.

    Raises:
        InputError: the branch does not exist, or nothing moves on it.
    """
    film = _film(plan, scene, branch, file)
    seconds = sum(film.duration(name) - plan.nodes[name].overlap for name in film.moving)
    step = max(
        FRAME_STEP, seconds / (MAX_FRAMES - 2 * len(film.moving)) if len(film.moving) < MAX_FRAMES // 4 else 0.5
    )
    frames = list(film.frames(step))
    stage, view = _staged(film, list(film.key_frames()), wishes, ANIMATION_WIDTH)
    found = []
    try:
        with phase("drawing", len(frames), "frames", log=_LOG) as drawn:
            for frame in frames:
                stage.place(poses_in(scene, frame.state))
                drawing = _named(stage.drawing, film, frame, everything=False)
                pixels = taken(stage, view, labels=wishes.labels, font=13, drawing=drawing)
                found.append(captioned(pixels, [frame.caption], 1))
                drawn()
    finally:
        stage.close()
    return gif(found, step)


def at_node(plan: Plan, scene: Scene, node: str, file: str) -> Drawing:
    """The scene as it is after a node, on the shortest branch that leads there.

    Raises:
        InputError: there is no such node.
    """
    require_node(plan, node, file)
    film = Film(plan, scene, branch_of(plan, node, file))
    return scene_drawing(scene, film.at(node, np.inf))


def require_node(plan: Plan, node: str, file: str) -> None:
    """Checks that a plan has a node.

    Raises:
        InputError: it has none of this name.
    """
    if node not in plan.nodes:
        hint = did_you_mean(node, plan.nodes) or f"its nodes are n0 to n{len(plan.nodes) - 1}"
        raise InputError([Diagnostic(file, 1, 1, f'the plan has no node "{node}"', hint)])


def _film(plan: Plan, scene: Scene, branch: str | None, file: str) -> Film:
    film = Film(plan, scene, branch_of(plan, branch, file))
    if not film.moving:
        hint = "draw its graph instead: -o FILE.svg"
        raise InputError([Diagnostic(file, 1, 1, "nothing moves on this branch", hint)])
    return film


def _staged(film: Film, frames: Sequence[Frame], wishes: ViewWishes, width: int) -> tuple[Stage, View]:
    """A stage for all frames, and a view that holds what moves in any of them."""
    drawing = scene_drawing(film.scene, film.start)
    stage = Stage(drawing, (width, width))
    # Every frame must fit, so the view is fitted to all of them; the side is that which shows most of a few.
    points = [_points(drawing, film, frame) for frame in frames]
    halfway = [film.at(name, film.duration(name) / 2.0) for name in film.moving]
    points += [drawing.moved(poses_in(film.scene, state)).points for state in halfway]
    shown = [poses_in(film.scene, frames[k].state) for k in spread(len(frames), MAX_LOOKS)]
    return stage, chosen_view(stage, np.concatenate(points), wishes, width, shown)


def _points(drawing: Drawing, film: Film, frame: Frame) -> Array:
    return drawing.moved(poses_in(film.scene, frame.state)).points


def _named(drawing: Drawing, film: Film, frame: Frame, *, everything: bool) -> Drawing:
    """The drawing with the names that matter in a frame: of robots, and of what its node is about."""
    if everything:
        return drawing
    about = {str(value) for value in film.plan.nodes[frame.node].arguments.values()}

    def matters(label: Label) -> bool:
        return label.text in about or label.text in film.scene.robots

    # What is hidden has moved from where the label of the start would point to.
    return replace(drawing, labels=tuple(replace(each, always=False) for each in drawing.labels if matters(each)))


def _caption(frames: Sequence[Frame], kept: Sequence[int], number: int) -> list[str]:
    """The lines under a panel: what was sensed and done since the panel before."""
    before = max((other for other in kept if other < number), default=-1)
    lines = frames[number].caption.split("\n")
    skipped = number - before - 1
    return [f"… {skipped} more …", *lines[-2:]] if skipped > 0 else lines


def _columns(count: int) -> int:
    """The number of panels in a row that leaves the fewest places of the last row empty."""
    if count in (1, 2, 4):
        return min(count, 2)
    return min(COLUMNS, key=lambda columns: -count % columns)


def _branch_text(film: Film) -> str:
    outcomes = [outcome for _, outcome in film.steps if outcome is not None]
    return "all of it" if not outcomes else f"the branch {', '.join(outcomes)}"
