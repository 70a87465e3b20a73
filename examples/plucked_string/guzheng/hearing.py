"""The sense of hearing: onsets by spectral flux over semitones, their notes by harmonic sums, their loudness [T 4.2.3].

Loudness is that of the fundamental in dB above the noise of the room, A-weighted. The noise is listened to once.
"""

from dataclasses import dataclass

import numpy as np

from guzheng.sound import RATE, noise

HOP, WINDOW = 256, 2048  # of the flux: 12 ms and 93 ms
LONG = 8192  # of the window in which a note is told [samples]
LOWEST, SEMITONES = 38, 72  # from D2 to D6, and two octaves of harmonics
LAG = 4  # frames between which flux is measured
APART = 0.1  # a second onset within this time is one [s]
MARGIN = 2.0  # standard deviations of a band's rise in silence that count for nothing
LOUDER = 1.4  # than the largest flux of silence: an onset
NOTICED = 0.46  # where in its window a sound begins that raises flux most
RELATIVE = 0.1  # of the largest flux of a recording: an onset
HARMONICS = ((0, 1.0), (12, 0.8), (19, 0.6), (24, 0.5), (28, 0.4), (31, 0.3))  # semitones up, weight
SECOND = 0.2  # of the strongest note's sum: another note sounds too


@dataclass(frozen=True)
class Onset:
    """A sound that begins."""

    time: float  # [s] from the start of the recording
    notes: tuple[int, ...]  # MIDI numbers, the strongest first
    loudness: float  # of the strongest note's fundamental [dB above noise, A-weighted]


class Ear:
    """Ears that know the noise of the room: what they heard while nothing was played is what onsets are measured by."""

    def __init__(self, seed: int = 0) -> None:
        silence = noise(30 * RATE, np.random.default_rng(seed))
        self._floor = _semitones(_frames(silence, WINDOW, HOP)).mean(0)
        self._noise = self._rises(silence).std(0)
        self._threshold = LOUDER * self._flux(silence).max()
        self._long_floor = _semitones(_frames(silence, LONG, LONG)).mean(0)

    def onsets(self, sound: np.ndarray) -> list[Onset]:
        """The onsets of a recording in the order of time."""
        flux = self._flux(sound)
        threshold = max(self._threshold, RELATIVE * flux.max())
        times: list[float] = []
        for frame in np.argsort(-flux):
            time = ((frame + LAG) * HOP + NOTICED * WINDOW) / RATE
            if flux[frame] < threshold:
                break
            if all(abs(time - other) >= APART for other in times):
                times.append(float(time))
        return [self._onset(sound, time) for time in sorted(times)]

    def _flux(self, sound: np.ndarray) -> np.ndarray:
        """How much the bands rise within LAG frames beyond what noise does, for each frame (N,) [Böck and Widmer 2013].

        The excess is squared, so that a soft high note, which raises few bands, stands out.
        """
        excess = np.maximum(self._rises(sound) / self._noise - MARGIN, 0.0)
        return np.asarray((excess**2).sum(1))

    def _rises(self, sound: np.ndarray) -> np.ndarray:
        """How much each band rises within LAG frames (N, SEMITONES), in nepers."""
        levels = np.log1p(_semitones(_frames(sound, WINDOW, HOP)) / self._floor)
        return np.asarray(levels[LAG:] - levels[:-LAG])

    def _onset(self, sound: np.ndarray, time: float) -> Onset:
        """The onset at a time, heard for as long as its window, or to the end of the recording."""
        first = min(int(time * RATE), len(sound) - LONG)
        bands = _semitones(_frames(sound[first : first + LONG], LONG, LONG))[0] / self._long_floor
        notes = _notes(bands)
        return Onset(time, notes, float(20.0 * np.log10(bands[notes[0] - LOWEST])) + a_weight(notes[0]))


def a_weight(note: int) -> float:
    """The A-weighting at a note's frequency [dB]."""
    f = 440.0 * 2.0 ** ((note - 69) / 12)
    high = (f**2 + 20.6**2) * np.sqrt((f**2 + 107.7**2) * (f**2 + 737.9**2)) * (f**2 + 12194.0**2)
    return float(20.0 * np.log10(12194.0**2 * f**4 / high) + 2.0)


def _frames(sound: np.ndarray, window: int, hop: int) -> np.ndarray:
    """The magnitudes (N, window / 2 + 1) of overlapping windows."""
    pieces = np.lib.stride_tricks.sliding_window_view(sound, window)[::hop]
    return np.abs(np.fft.rfft(pieces * np.hanning(window), axis=1))


def _semitones(spectra: np.ndarray) -> np.ndarray:
    """The largest magnitudes (N, SEMITONES) within half a semitone of each note, of spectra (N, window / 2 + 1).

    Where a window cannot tell low notes apart, they share a magnitude.
    """
    edges = 440.0 * 2.0 ** ((np.arange(LOWEST, LOWEST + SEMITONES + 1) - 69.5) / 12)
    bins = np.rint(edges / (RATE / 2) * (spectra.shape[1] - 1)).astype(int)
    return np.asarray(np.maximum.reduceat(spectra[:, : bins[-1]], bins[:-1], axis=1))


def _notes(bands: np.ndarray) -> tuple[int, ...]:
    """The note with the largest sum over its harmonics; a second one if what the first leaves has a large sum, too."""
    strengths = np.sqrt(np.maximum(bands - 4.0, 0.0))  # what does not stand out of the noise is none
    sums = _harmonic_sums(strengths)
    first = int(np.argmax(sums))
    rest = strengths.copy()
    for n in range(1, 25):
        at = first + round(12 * np.log2(n))
        rest[max(0, at - 1) : at + 2] = 0.0
    others = _harmonic_sums(rest)
    second = int(np.argmax(others))
    if others[second] > SECOND * sums[first] > 0.0:
        return first + LOWEST, second + LOWEST
    return (first + LOWEST,)


def _harmonic_sums(strengths: np.ndarray) -> np.ndarray:
    padded = np.concatenate([strengths, np.zeros(max(up for up, _ in HARMONICS))])
    return np.asarray(sum(weight * padded[up : up + SEMITONES] for up, weight in HARMONICS))
