"""The simulated strings of examples/plucked_string: physics against plain formulas, senses against what happened."""

import re
import shlex
import shutil
import sys
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from kabo.cli import main
from kabo.exploration import fit_line, load_exploration
from kabo.trials import Invalid, Valid

sys.path.append(str(Path(__file__).resolve().parents[2] / "examples" / "plucked_string"))

import plucked_string
import string_lines
from guzheng import DIRECTIONS, RATE, Bias, Ear, Finger, Release, drops, guzheng, path, pluck, recording, touch
from guzheng import finger as fingers

EXAMPLE = Path(plucked_string.__file__).parent
EXACT = Finger(repeatability=0.0, placing=0.0)
CASES = [{"string": string, "direction": d} for string in ("a3", "d4", "fs4", "b4", "fs5") for d in DIRECTIONS]


@cache
def ear() -> Ear:
    return Ear()


def exact(instrument, string, direction, eta, deflection):
    """The releases of a pluck without errors that differ from pluck to pluck."""
    return pluck(instrument, EXACT, string, direction, eta, deflection, np.random.default_rng(0))[0]


def biased(string, direction, across, up):
    """The instrument with the string elsewhere than the arm takes it to be [m]."""
    instrument = guzheng()
    return replace(instrument, biases={**instrument.biases, (string, direction): Bias((across,), (up,))})


@pytest.mark.parametrize("deflection", [-0.008, 0.0, 0.005, 0.014])
def test_a_path_passes_its_waypoint_with_its_velocity_and_dives_below_it_before(deflection):
    way = path(deflection)
    at = round(fingers.DIVE / fingers.STEP)
    assert way[at] == pytest.approx([deflection, fingers.DEPTH])
    velocity = (way[at + 1] - way[at - 1]) / (2 * fingers.STEP)
    assert velocity == pytest.approx(fingers.VELOCITY, abs=0.002)
    assert way[:at, 1].min() < fingers.DEPTH
    assert way[0] == pytest.approx(fingers.START)
    assert way[-1] == pytest.approx(fingers.END, abs=1e-5)


@pytest.mark.parametrize("eta", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("deflection", [-0.001, 0.003, 0.008])
def test_a_string_is_released_with_the_force_of_two_springs_in_a_row(eta, deflection):
    instrument, string = biased("d4", "in", 0.0, 0.0), guzheng().strings["d4"]
    (released,) = exact(instrument, "d4", "in", eta, deflection)
    x = string.first + eta * string.reach
    wire = string.tension / (string.length * x) + string.tension / (string.length * (1 - x))  # both sides pull
    overlap = path(deflection)[round(released.time / fingers.STEP) - 1, 0]
    assert released.force == pytest.approx(overlap / (1 / wire + 1 / EXACT.stiffness), rel=1e-9)


def test_the_harder_the_pull_the_earlier_a_string_slips_off():
    instrument = biased("d4", "in", 0.0, 0.0)
    depths = [
        -path(deflection)[round(exact(instrument, "d4", "in", 0.5, deflection)[0].time / fingers.STEP), 1]
        for deflection in (0.0, 0.005, 0.01)
    ]
    assert depths[0] < depths[1] < depths[2] < 0.001


def test_a_tip_that_does_not_reach_a_string_plucks_none():
    assert exact(guzheng(), "d4", "in", 0.5, -0.008) == []


def test_a_tip_that_passes_above_a_string_plucks_its_neighbour():
    lower = biased("d4", "in", 0.0, -0.005)  # the neighbour goes with it: raise that
    lower = replace(lower, strings={**lower.strings, "e4": replace(lower.strings["e4"], height=0.005)})
    released = exact(lower, "d4", "in", 0.5, 0.014)
    assert [each.string.name for each in released] == ["e4"]
    results = [
        plucked_string.judged(plucked_string.play(lower, "d4", "in", 0.5, 0.014, seed), 62) for seed in range(10)
    ]
    assert {each.reason for each in results if isinstance(each, Invalid)} >= {"other_note"}
    assert not any(isinstance(each, Valid) for each in results)


def test_the_outermost_strings_have_no_neighbour_behind_them():
    assert guzheng().neighbour("d6", "in") is None
    assert guzheng().neighbour("a3", "out") is None
    assert guzheng().neighbour("a3", "in")[0].name == "b3"


def tone(force=1.0, share=0.5, name="d4"):
    return Release(guzheng().strings[name], share, 0.2, force)


def spectrum(release, frequency):
    """The amplitude at a frequency in the second after a string was let go, without noise to speak of."""
    sound = recording([release], np.random.default_rng(3), duration=1.4)[-RATE:]
    return abs(np.exp(-2j * np.pi * frequency / RATE * np.arange(RATE)) @ (sound * np.hanning(RATE))) / RATE


def test_a_string_plucked_at_its_middle_has_no_even_modes():
    f = guzheng().strings["d4"].frequency
    assert spectrum(tone(), 2 * f) < 0.01 * spectrum(tone(), f)
    assert spectrum(tone(share=0.25), 2 * f) > 0.2 * spectrum(tone(share=0.25), f)


def heard(release, seed=0):
    (onset,) = ear().onsets(recording([release], np.random.default_rng(seed)))
    return onset


def test_twice_the_force_is_six_decibels_louder():
    assert heard(tone(1.6)).loudness - heard(tone(0.8)).loudness == pytest.approx(6.02, abs=0.3)


@pytest.mark.parametrize("name", guzheng().strings)
def test_the_note_of_each_string_is_recognised(name):
    assert heard(tone(0.8, 0.2, name)).notes == (guzheng().strings[name].note,)


def test_two_strings_that_sound_at_once_are_two_notes():
    both = [tone(1.0, 0.3, "d4"), tone(1.0, 0.3, "e4")]
    (onset,) = ear().onsets(recording(both, np.random.default_rng(0)))
    assert set(onset.notes) == {62, 64}


def test_sounds_a_fifth_of_a_second_apart_are_two_onsets_and_of_one_moment_one():
    late = replace(tone(1.0, 0.3, "b4"), time=0.4)
    times = [each.time for each in ear().onsets(recording([tone(), late], np.random.default_rng(0)))]
    assert times == pytest.approx([0.35, 0.55], abs=0.03)
    soon = replace(late, time=0.23)
    assert len(ear().onsets(recording([tone(), soon], np.random.default_rng(0)))) == 1


def test_silence_has_hardly_an_onset():
    knocks = sum(bool(ear().onsets(recording([], np.random.default_rng(seed)))) for seed in range(100))
    assert knocks <= 6


def test_a_sudden_drop_of_the_pull_is_felt_and_a_slow_one_is_not():
    rng, steps = np.random.default_rng(0), np.arange(500)
    sudden = np.where(steps < 250, steps / 250.0, 0.0)
    slow = 0.2 * np.where(steps < 250, steps / 250.0, 2.0 - steps / 250.0)
    assert drops(touch.sampled(sudden, rng)) == pytest.approx([0.25], abs=0.02)
    assert drops(touch.sampled(slow, rng)) == []


@cache
def random_plucks():
    """Plucks anywhere in the space of all strings: what happened, and what was sensed of it."""
    rng, instrument = np.random.default_rng(7), guzheng()
    return [
        plucked_string.play(
            instrument,
            str(rng.choice(list(instrument.strings))),
            str(rng.choice(DIRECTIONS)),
            rng.random(),
            rng.uniform(-0.008, 0.014),
            seed,
        )
        for seed in range(600)
    ]


@pytest.mark.parametrize(("sense", "precision", "recall"), [("onsets", 0.96, 0.93), ("drops", 0.98, 0.9)])
def test_senses_notice_what_happens_and_little_else(sense, precision, recall):
    right = noticed = happened = 0
    for sensed in random_plucks():
        times = [each if sense == "drops" else each.time for each in getattr(sensed, sense)]
        real = [each.time for each in sensed.happened][:1]  # a neighbour follows at once
        right += sum(any(abs(time - at) < plucked_string.ALIGNED for time in times) for at in real)
        noticed, happened = noticed + len(times), happened + len(real)
    assert right / noticed >= precision
    assert right / happened >= recall


def test_a_pluck_is_not_called_valid_unless_its_string_alone_was_plucked():
    names = guzheng().strings
    wrong = right = 0
    for sensed in random_plucks():
        if len(sensed.happened) == 1:
            note = sensed.happened[0].string.note
            right += isinstance(plucked_string.judged(sensed, note), Valid)
            wrong += isinstance(plucked_string.judged(sensed, note + 2), Valid)
        elif not sensed.happened:
            wrong += any(isinstance(plucked_string.judged(sensed, each.note), Valid) for each in names.values())
    assert wrong == 0
    assert right > 250


@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(case.values()))
def test_every_string_is_plucked_softly_loudly_and_too_hard(case):
    def plucked(eta, deflection):
        parameters = {"eta": eta, "deflection": deflection}
        return [plucked_string.pluck_string(case, parameters, seed) for seed in range(8)]

    soft, loud, hard = plucked(0.5, 0.0), plucked(0.5, 0.006), plucked(0.0, 0.0105)
    assert sum(isinstance(each, Valid) for each in soft) >= 6
    assert sum(isinstance(each, Valid) for each in loud) >= 6
    least, most = (
        np.mean([each.outcomes["loudness"] for each in results if isinstance(each, Valid)])
        for results in (soft, loud)
    )
    assert most > least + 5
    assert sum(isinstance(each, Invalid) and each.reason == "too_hard" for each in hard) >= 6


def test_a_pluck_depends_on_its_seed_alone():
    once, again, other = (
        plucked_string.pluck_string(CASES[0], {"eta": 0.4, "deflection": 0.004}, seed) for seed in (5, 5, 6)
    )
    assert once == again
    assert once != other


def test_a_string_is_found_by_touching_it():
    instrument, rng = guzheng(), np.random.default_rng(1)
    known = list(islice(string_lines.contacts(instrument, "d4", rng, string_lines.evenly), 22))
    line = fit_line([each.point for each in known])
    right, left = string_lines.ends(instrument, "d4")
    assert line.distance(np.linspace(right, left, 5)).max() < 0.0015
    assert np.linalg.norm(line.origin - right) < 0.005
    assert not line.inliers[[each.astray for each in known]].any()


def test_the_commands_of_the_readme_run(tmp_path, monkeypatch, capsys):
    folder = shutil.copytree(EXAMPLE, tmp_path / "example", ignore=shutil.ignore_patterns("*.png", "__pycache__"))
    monkeypatch.chdir(folder)
    run, *others = re.findall(r"^    kabo (.*)$", (EXAMPLE / "README.md").read_text(), flags=re.MULTILINE)
    assert main(shlex.split(run.replace("--trials 1000", "--trials 80"))) == 0
    explored = load_exploration("plucks.jsonl")
    assert len(explored.trials) == 80
    assert sum(each.valid for each in explored.trials) > 50
    assert len(others) == 2
    for command in others:
        assert main(shlex.split(command)) == 0
    assert "loudness 30." in capsys.readouterr().out


def test_string_lines_says_how_far_new_contacts_are_from_each_line(capsys):
    string_lines.main()
    told = re.findall(r"([\d.]+) mm after 20", capsys.readouterr().out)
    assert len(told) == 5
    assert all(0.7 < float(each) < 1.5 for each in told)
