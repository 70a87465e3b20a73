"""Pictures of runs: an animation, frames in a folder, a film strip of where everything was.

They are drawn as all pictures are, from what the log, or a `Witness` of the simulation, says of robots and bodies: so
they need no display, and no renderer of the simulation.
"""

import logging
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from kabo.errors import Diagnostic, InputError
from kabo.phases import phase
from kabo.pictures.drawing import Drawing
from kabo.pictures.panels import captioned, framed, gif, grid, png, spread, titled
from kabo.pictures.rendering import Pixels, Stage
from kabo.pictures.run_frames import Record, RunFrame, frames_of_run, key_frames_of_run, step_of_run
from kabo.pictures.scenes import poses_in, scene_drawing
from kabo.pictures.views import View, ViewWishes, chosen_view, taken
from kabo.scene import Scene

_LOG = logging.getLogger("kabo.pictures")
FILM_WIDTH, STRIP_WIDTH, COLUMNS, MAX_PANELS, CAPTION_ROWS = 520, 1200, 3, 12, 2  # pixels; panels
MAX_LOOKS, MAX_FITTED = 3, 12  # frames by which the side is chosen, and to which the view is fitted


def run_animation(
    records: Sequence[Record], scene: Scene, file: str, wishes: ViewWishes, rate: float | None = None
) -> bytes:
    """A run as an animated GIF, in real time if a rate is asked for; else as fast as a few frames show it.

    Args:
        records: of the log. scene: of its problem. file: the name of the log, for messages. wishes: the view.
        rate: frames a second of the run [Hz].

    Raises:
        InputError: the log has no states, or is of another scene.
    """
    step, shown = step_of_run(records, rate)
    frames = frames_of_run(records, scene, step, file)
    return gif(list(_drawn(frames, scene, wishes, FILM_WIDTH, step / shown)), shown)


def write_run_frames(
    records: Sequence[Record],
    scene: Scene,
    folder: Path,
    wishes: ViewWishes,
    rate: float | None = None,
) -> int:
    """Writes the frames of a run as PNG, `0001.png` and so on, into a folder, and says how many: all or none.

    Raises:
        InputError: the log has no states or is of another scene, or the folder holds something.
        OSError: the folder cannot be written.
    """
    require_empty(folder)
    frames = frames_of_run(records, scene, step_of_run(records, rate)[0], str(folder))
    made = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.absolute().parent))
    try:
        made.chmod(0o755)
        for number, pixels in enumerate(_drawn(frames, scene, wishes, FILM_WIDTH, 1.0), 1):
            (made / f"{number:04d}.png").write_bytes(png(pixels))
        made.replace(folder.absolute())
    finally:
        shutil.rmtree(made, ignore_errors=True)
    return len(frames)


def require_empty(folder: Path) -> None:
    """Checks that a folder can be filled: it is empty, or is not there and can be made.

    Raises:
        InputError: it cannot be; says why.
    """
    if folder.is_dir() and not any(folder.iterdir()):
        return
    if folder.exists() or folder.is_symlink():
        said = "it holds something" if folder.is_dir() else "it is no folder"
        raise InputError(
            [Diagnostic(str(folder), 1, 1, f"frames are not written there: {said}", "name a new one")]
        )
    if not folder.absolute().parent.is_dir():
        said = f"there is no folder {folder.absolute().parent}"
        raise InputError([Diagnostic(str(folder), 1, 1, f"frames are not written there: {said}", "make it first")])


def run_strip(records: Sequence[Record], scene: Scene, file: str, wishes: ViewWishes) -> bytes:
    """Key frames of a run as PNG: the start, where each motion ended, and what happened then.

    Raises:
        InputError: the log has no states, or is of another scene.
    """
    frames = key_frames_of_run(records, scene, file)
    kept = [frames[k] for k in spread(len(frames), MAX_PANELS)]
    columns = min(COLUMNS, len(kept))
    panels = list(_drawn(kept, scene, wishes, STRIP_WIDTH // columns, 1.0))
    end = kept[-1]
    return png(titled(grid(panels, columns), f"{file}: {end.time:.1f} s, {end.told or end.doing}"))


def _drawn(
    frames: Sequence[RunFrame], scene: Scene, wishes: ViewWishes, width: int, speed: float
) -> Iterator[Pixels]:
    """Each frame as pixels over its caption; `speed` is how much faster than real time they are shown."""
    stage, view = _staged(frames, scene, wishes, width)
    faster = "" if speed < 1.05 else f"  ×{speed:.2g}"
    try:
        with phase("drawing", len(frames), "frames", log=_LOG) as step:
            for frame in frames:
                stage.place(poses_in(scene, frame.state))
                drawing = _named(stage.drawing, scene, frame)
                pixels = framed(taken(stage, view, labels=wishes.labels, font=13, drawing=drawing))
                lines = [f"{frame.time:.1f} s{faster}  {frame.doing}", frame.told]
                yield captioned(pixels, lines, CAPTION_ROWS)
                step()
    finally:
        stage.close()


def _staged(frames: Sequence[RunFrame], scene: Scene, wishes: ViewWishes, width: int) -> tuple[Stage, View]:
    """A stage for all frames, and a view that holds what moves in some of them."""
    drawing = scene_drawing(scene, frames[0].state)
    stage = Stage(drawing, (width, width))
    fitted = [poses_in(scene, frames[k].state) for k in spread(len(frames), MAX_FITTED)]
    points = np.concatenate([drawing.moved(poses).points for poses in fitted])
    looks = [fitted[k] for k in spread(len(fitted), MAX_LOOKS)]
    return stage, chosen_view(stage, points, wishes, width, looks)


def _named(drawing: Drawing, scene: Scene, frame: RunFrame) -> Drawing:
    """The drawing with the names of robots, and of what is being done something with."""
    labels = (each for each in drawing.labels if each.text in frame.about or each.text in scene.robots)
    return replace(drawing, labels=tuple(replace(each, always=False) for each in labels))
