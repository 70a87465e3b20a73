"""Pictures of a run that `kabo execute` draws when it has ended: an animation, or frames in a folder."""

import argparse
from pathlib import Path
from typing import Any

from kabo.cli import rooms
from kabo.cli.argument_types import bounded, output_file
from kabo.cli.terminal import tell
from kabo.errors import Diagnostic, InputError

USUAL_RATE = 10.0  # [Hz]


def add_filming(parser: argparse.ArgumentParser) -> None:
    """Adds the options of pictures of a run to the parser."""
    parser.add_argument(
        "--video", type=_gif_file, metavar="FILE.gif", help="draw where everything truly was, as an animation"
    )
    parser.add_argument(
        "--frames",
        type=Path,
        metavar="FOLDER",
        help="the same as single pictures, 0001.png and so on, in a new folder",
    )
    parser.add_argument(
        "--frame-rate",
        type=bounded(0.1, 50.0, "Hz"),
        metavar="HZ",
        help="frames a second of the run, shown in real time (default: 10; of long runs fewer, shown faster)",
    )


def _gif_file(text: str) -> Path:
    path = output_file(text)
    if path.suffix.lower() != ".gif":
        raise argparse.ArgumentTypeError(f"{text!r} does not end with .gif")
    return path


class Filming:
    """What is drawn of a run, if anything is asked for.

    Args:
        options: of the command.

    Raises:
        InputError: pictures cannot be drawn, or not be written there.
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self.video, self.frames, self.rate = options.video, options.frames, options.frame_rate
        self.wanted = self.video is not None or self.frames is not None
        self._witness: Any = None
        if not self.wanted:
            if self.rate is not None:
                raise _refusal(
                    "--frame-rate", "it is of --video and --frames", "give one of them, or leave it out"
                )
            return
        rooms.require_pictures("--frames" if self.video is None else "--video")
        if self.frames is not None:
            rooms.require_empty(self.frames)

    @property
    def log_rate(self) -> float:
        """How often the log must say where everything is [Hz]; 0 if nothing is drawn."""
        return (self.rate or USUAL_RATE) if self.wanted else 0.0

    def listener(self, robot: Any) -> Any:
        """What listens to the log; None if nothing is drawn.

        Raises:
            InputError: there is nothing to be drawn.
        """
        if not self.wanted:
            return None
        if robot is None:
            raise _refusal("--video", "nothing moves in this plan", "leave it out")
        self._witness = rooms.Witness(robot)
        return self._witness

    def draw(self, scene: "rooms.Scene") -> None:
        """Draws what was asked for, and says where it is."""
        if self._witness is None:
            return
        records, wishes = self._witness.records, rooms.ViewWishes()
        if self.video is not None:
            made = rooms.run_animation(records, scene, str(self.video), wishes, self.rate)
            rooms.write_atomically(self.video, made)
            tell(f"{self.video}: {len(made) / 1000:.0f} kB")
        if self.frames is not None:
            count = rooms.write_run_frames(records, scene, self.frames, wishes, self.rate)
            tell(f"{self.frames}: {rooms.counted(count, 'picture')}")


def _refusal(name: str, message: str, hint: str) -> InputError:
    return InputError([Diagnostic(name, 1, 1, message, hint)])
