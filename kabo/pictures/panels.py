"""Puts pictures together: titles, captions, panels side by side, bars of colours; and writes PNG and GIF."""

from collections.abc import Iterable, Sequence
from io import BytesIO
from typing import Any

import numpy as np

from kabo.pictures.labels import INK, font
from kabo.pictures.rendering import DISTANCE_COLOURS, Pixels

PAPER, GREY, RULE = "#ffffff", "#6a7079", "#d5d9de"
GAP = 14  # between panels, and around them [pixels]
TITLE, CAPTION = 20, 14  # sizes of fonts [pixels]
LARGEST_PNG = 290_000  # bytes: larger pictures are written with a palette
GIF_COLOURS = 256


def titled(pixels: Pixels, title: str) -> Pixels:
    """The picture under a line of text, which is shortened where it would not fit."""
    bar = _text_block([title], pixels.shape[1], TITLE, INK, above=10, below=6, left=GAP)
    return np.concatenate([bar, pixels])


def captioned(pixels: Pixels, lines: Sequence[str], rows: int) -> Pixels:
    """The picture over lines of text, with room for so many rows."""
    shown = [*lines, *[""] * (rows - len(lines))][:rows]
    return np.concatenate([pixels, _text_block(shown, pixels.shape[1], CAPTION, INK, above=4, below=8, left=6)])


def grid(panels: Sequence[Pixels], columns: int) -> Pixels:
    """Panels (H, W, 3) of one size in rows, from left to right, with gaps between."""
    high, wide, _ = panels[0].shape
    rows = -(-len(panels) // columns)
    sheet = np.full((GAP + rows * (high + GAP), GAP + columns * (wide + GAP), 3), 255, np.uint8)
    for number, panel in enumerate(panels):
        top, left = GAP + number // columns * (high + GAP), GAP + number % columns * (wide + GAP)
        sheet[top : top + high, left : left + wide] = panel
    return sheet


def spread(count: int, most: int) -> list[int]:
    """Numbers below `count`, no more than `most`, the first and the last among them."""
    if count <= most:
        return list(range(count))
    return sorted({round(k * (count - 1) / (most - 1)) for k in range(most)})


def framed(pixels: Pixels) -> Pixels:
    """The picture with a thin line around it."""
    found: Pixels = pixels.copy()
    colour = [int(RULE[k : k + 2], 16) for k in (1, 3, 5)]
    found[[0, -1]] = colour
    found[:, [0, -1]] = colour
    return found


def distance_bar(width: int, greatest: float) -> Pixels:
    """A bar of the colours that mean distances from 0 to `greatest` [m]: (H, width, 3)."""
    from matplotlib.colors import LinearSegmentedColormap
    from PIL import Image, ImageDraw

    height, left, right = 64, round(0.2 * width), round(0.8 * width)
    sheet = np.full((height, width, 3), 255, np.uint8)
    colours = LinearSegmentedColormap.from_list("distance", DISTANCE_COLOURS)(np.linspace(0.0, 1.0, right - left))
    sheet[12:28, left:right] = np.rint(255.0 * colours[:, :3])
    image = Image.fromarray(sheet)
    draw = ImageDraw.Draw(image)
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        text = f"{1000.0 * share * greatest:.3g}"
        x = left + share * (right - left)
        draw.text((x, 32), text, font=font(CAPTION), fill=INK, anchor="ma")
    draw.text((left - 12, 20), "distance [mm]", font=font(CAPTION), fill=INK, anchor="rm")
    return np.asarray(image)


def png(pixels: Pixels) -> bytes:
    """The picture as a PNG file; large ones with 256 colours."""
    from PIL import Image

    image = Image.fromarray(pixels)
    found = _saved(image, "PNG", optimize=True)
    if len(found) > LARGEST_PNG:
        found = _saved(image.quantize(256, dither=Image.Dither.NONE), "PNG", optimize=True)
    return found


def gif(frames: Iterable[Pixels], seconds: float) -> bytes:
    """An animation that begins again at its end; each frame is shown so many seconds, the last ten times as long."""
    from PIL import Image

    images = [Image.fromarray(frame) for frame in frames]
    # One palette for all frames: what does not move then does not flicker, and is not written again.
    sheet = Image.fromarray(
        np.concatenate([np.asarray(images[k]) for k in {0, len(images) // 2, len(images) - 1}])
    )
    palette = sheet.quantize(GIF_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    first, *others = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    each = max(20, 10 * round(100.0 * seconds))
    durations = [each] * len(others) + [max(each, 1500)]
    return _saved(first, "GIF", save_all=True, append_images=others, duration=durations, loop=0, optimize=False)


def _saved(image: Any, form: str, **options: Any) -> bytes:
    file = BytesIO()
    image.save(file, form, **options)
    return file.getvalue()


def _text_block(
    lines: Sequence[str], width: int, size: int, colour: str, *, above: int, below: int, left: int
) -> Pixels:
    from PIL import Image, ImageDraw

    step = round(1.35 * size)
    image = Image.new("RGB", (width, above + step * len(lines) + below), PAPER)
    draw = ImageDraw.Draw(image)
    for number, line in enumerate(lines):
        text = _shortened(line, width - 2 * left, size)
        draw.text((left, above + number * step), text, font=font(size), fill=colour)
    return np.asarray(image)


def _shortened(text: str, width: int, size: int) -> str:
    if font(size).getlength(text) <= width:
        return text
    while text and font(size).getlength(text + "…") > width:
        text = text[:-1]
    return text + "…"
