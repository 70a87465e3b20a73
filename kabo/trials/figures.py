"""Figures of a section: the validity and each outcome, with contours and the trials near the section."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape

import numpy as np

from kabo.arrays import Array
from kabo.exploration import INFERRED_ALPHA, Exploration, Trial
from kabo.trials.describing import described_reason, described_values
from kabo.trials.drawing import Axis, Bytes, Dot, colours, css_colour, curve, heat_map, number
from kabo.trials.maps import LEAST_NEARNESS, Section, nearness

KNOWN_FROM, WHOLE_FROM = 0.5, 0.7  # an outcome is transparent where V is below the first, opaque above the second
SURE = 1e-12  # V is clipped this far from 0 and 1, where its probit would be infinite
MARGIN = 0.04  # of the range of an outcome, above and below its values
LEAST_MARGIN = 1e-6  # of the outcome itself
HUGE = 1e300  # the ends of axes are clipped to it, so that their difference is finite
VALID_COLOUR = (13, 148, 136)  # of the map of V, whose opacity is V: it suits light and dark pages


@dataclass(frozen=True)
class _Scene:
    """The data that all figures of one section share."""

    axes: tuple[Axis, ...]
    section: Section
    near: tuple[tuple[Trial, float], ...]  # the trials to be drawn, each with its `nearness` to the section
    marks: Mapping[str, str]  # reason: its CSS colour
    units: Mapping[str, str]  # of outcomes
    parameter_units: Mapping[str, str]
    levels: tuple[tuple[float, str], ...]  # validity, and the CSS class of its contour


def figures(
    exploration: Exploration, case: Mapping[str, str], section: Section, marks: Mapping[str, str]
) -> Iterator[str]:
    """One figure of the validity, and one of each outcome, along one parameter or over two, as HTML.

    Args:
        exploration, case: whose trials are drawn.
        section: the values to be drawn.
        marks: reason: the CSS colour of trials that were invalid for it.
    """
    space = exploration.space
    where = f", where {described_values(section.through, space.units)}" if section.through else ""
    near = [(trial, nearness(exploration, trial, section)) for trial in exploration.trials_of(case)]
    scene = _Scene(
        tuple(Axis(_labelled(name, space.units.get(name, "")), *space.parameters[name]) for name in section.names),
        section,
        tuple(each for each in near if each[1] >= LEAST_NEARNESS),
        marks,
        exploration.units,
        space.units,
        ((exploration.alpha(case), "loose"), (INFERRED_ALPHA, "strict")),
    )
    for title, picture in (_curves if len(scene.axes) == 1 else _heat_maps)(scene):
        yield f"<figure>{picture}<figcaption>{title}{escape(where)}</figcaption></figure>\n"


def _labelled(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _dot(scene: _Scene, trial: Trial, x: float, y: float, colour: str | None = None, opacity: float = 1.0) -> Dot:
    """The mark of a trial; by default in the colour of its reason, or of valid trials."""
    said = described_values(trial.parameters, scene.parameter_units)
    if trial.valid:
        said += f": {described_values(trial.outcomes, scene.units)}"
    else:
        said += f": {described_reason(trial.reason)}"
    own = "var(--ink)" if trial.valid else scene.marks.get(trial.reason, "var(--dim)")
    return Dot(x, y, colour or own, said, cross=not trial.valid, opacity=opacity)


def _range(values: Array, label: str) -> Axis:
    """An axis over values (n,) with a margin; never of zero or infinite length."""
    lower, upper = np.clip([np.min(values), np.max(values)], -HUGE, HUGE).tolist()
    margin = max(MARGIN * (upper - lower), LEAST_MARGIN * max(abs(lower), abs(upper))) or 0.5
    return Axis(label, lower - margin, upper + margin)


# -------------------------------------------------------------------------------------------------- two parameters
def _heat_maps(scene: _Scene) -> Iterator[tuple[str, str]]:
    """Title and picture of the validity and of each outcome."""
    (x, y), validity = scene.axes, scene.section.validity
    lines = [(_probit(validity), float(_probit(np.array(level))), kind) for level, kind in scene.levels]
    dots = [_dot(scene, trial, *_place(scene, trial), opacity=opacity) for trial, opacity in scene.near]
    pixels = _pixels(np.broadcast_to(np.array(VALID_COLOUR, float), (*validity.shape, 3)), validity)
    yield (
        "probability of being valid",
        heat_map(x, y, pixels, lines, dots, f"validity over {x.label} and {y.label}"),
    )
    valid = [each for each in scene.near if each[0].valid]
    for name, (mean, _) in scene.section.outcomes.items():
        scale = _range(_shown_values(scene, name), name)
        shares = [scale.share(float(trial.outcomes[name])) for trial, _ in valid]
        dots = [
            _dot(scene, trial, *_place(scene, trial), css_colour(share), opacity)
            for (trial, opacity), share in zip(valid, shares, strict=True)
        ]
        opacities = np.clip((validity - KNOWN_FROM) / (WHOLE_FROM - KNOWN_FROM), 0.0, 1.0)
        pixels = _pixels(colours((mean - scale.lower) / (scale.upper - scale.lower)), opacities)
        title = f"{escape(_labelled(name, scene.units.get(name, '')))}: {_colour_key(scale)}"
        yield title, heat_map(x, y, pixels, lines, dots, f"{name} over {x.label} and {y.label}")


def _probit(validity: Array) -> Array:
    """The z of V = Φ(z), the cumulative normal: smoother than V near 0 and 1, so interpolated contours are smooth."""
    from scipy.special import ndtri  # with scikit-learn

    found: Array = ndtri(np.clip(validity, SURE, 1.0 - SURE))
    return found


def _place(scene: _Scene, trial: Trial) -> tuple[float, float]:
    first, second = scene.section.names
    return float(trial.parameters[first]), float(trial.parameters[second])


def _shown_values(scene: _Scene, name: str) -> Array:
    """The values over which an outcome's colours range: expected where V is above KNOWN_FROM, and of drawn trials."""
    mean = scene.section.outcomes[name][0]
    tried = [float(trial.outcomes[name]) for trial, _ in scene.near if trial.valid]
    known = mean[scene.section.validity > KNOWN_FROM]
    return np.concatenate([known, tried]) if known.size or tried else mean.ravel()


def _pixels(rgb: Array, opacity: Array) -> Bytes:
    """Bytes (rows, columns, 4) of colours from 0 to 255 and opacities from 0 to 1."""
    pixels: Bytes = np.rint(np.concatenate([rgb, 255.0 * opacity[..., None]], axis=-1)).astype(np.uint8)
    return pixels


def _colour_key(scale: Axis) -> str:
    """The colour bar of a scale with its two ends, as HTML."""
    stops = ", ".join(css_colour(k / 8) for k in range(9))
    bar = f'<b class="key" style="background-image:linear-gradient(90deg, {stops})"></b>'
    return f"{number(scale.lower)}{bar}{number(scale.upper)}"


# --------------------------------------------------------------------------------------------------- one parameter
def _curves(scene: _Scene) -> Iterator[tuple[str, str]]:
    """Title and picture of the validity and of each outcome."""
    (x,), (name,), (at,), section = scene.axes, scene.section.names, scene.section.values, scene.section
    dots = [_dot(scene, trial, float(trial.parameters[name]), float(trial.valid)) for trial, _ in scene.near]
    picture = curve(x, Axis("valid", 0.0, 1.0), at, section.validity, None, dots, scene.levels)
    yield "probability of being valid", picture
    valid = [trial for trial, _ in scene.near if trial.valid]
    known = section.validity > KNOWN_FROM
    for outcome, (mean, spread) in section.outcomes.items():
        mean = np.where(known, mean, np.nan)
        tried = [float(trial.outcomes[outcome]) for trial in valid]
        reach = np.concatenate([(mean - spread)[known], (mean + spread)[known], tried])
        y = _range(reach, _labelled(outcome, scene.units.get(outcome, "")))
        dots = [
            _dot(scene, trial, float(trial.parameters[name]), value)
            for trial, value in zip(valid, tried, strict=True)
        ]
        yield f"{escape(outcome)}, ± one standard deviation", curve(x, y, at, mean, spread, dots)
