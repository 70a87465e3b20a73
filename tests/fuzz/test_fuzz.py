"""Whatever stands in a file, it is read or refused with findings that have a place [tests/fuzz].

By count, so that a run is the same on every machine: 30,000 files at the whole scale, 3,000 at that of `.ci/run`. An
hour by hand is `python -m tests.fuzz --minutes 60`; what it finds goes to `tests/regressions/finds`, and is read
again here.
"""

import random
from pathlib import Path

import pytest

from tests.conftest import PROPERTY_SCALE
from tests.fuzz.formats import FORMATS, Workspace
from tests.fuzz.judging import judged
from tests.fuzz.mutations import mutated
from tests.fuzz.running import counts, run_apart

FILES = 30_000
COUNTS = counts(round(FILES * PROPERTY_SCALE))
FINDS = Path(__file__).parents[1] / "regressions/finds"


@pytest.mark.parametrize("name", FORMATS)
def test_no_file_is_a_defect(name: str) -> None:
    finds = run_apart(name, range(COUNTS[name]))
    assert not finds, "\n".join(map(str, finds[:20]))


@pytest.mark.parametrize("name", FORMATS)
def test_the_seeds_are_sound(name: str, tmp_path: Path) -> None:
    """Else every change of one would be refused for the same reason."""
    workspace, format = Workspace(tmp_path / "work"), FORMATS[name]
    for seed in format.seeds:
        format.read(workspace.folder / seed.main, 1)


@pytest.mark.parametrize("name", FORMATS)
def test_a_case_is_its_number(name: str, tmp_path: Path) -> None:
    workspace, format = Workspace(tmp_path / "work"), FORMATS[name]
    first = [workspace.case(format, number) for number in range(20)]
    assert first == [workspace.case(format, number) for number in range(20)]
    assert len({content for _, content in first}) > 10


@pytest.mark.parametrize("path", sorted(FINDS.glob("*-*-*")), ids=lambda path: path.name)
def test_what_was_found_once_stays_repaired(path: Path, tmp_path: Path) -> None:
    """Files are called as `python -m tests.fuzz` keeps them: FORMAT-NUMBER-TARGET."""
    name, number, target = path.name.split("-", 2)
    workspace, format = Workspace(tmp_path / "work"), FORMATS[name]
    for seed in format.seeds:
        if seed.target.name == target:
            what = judged(lambda seed=seed: workspace.read(format, seed, path.read_bytes(), int(number)))
            assert what is None, what


def test_the_judge_sees_what_it_looks_for() -> None:
    def endless() -> None:
        while True:
            pass

    def broken() -> None:
        raise KeyError("x")

    assert "KeyError" in str(judged(broken))
    assert "took more than" in str(judged(endless, seconds=0.2))
    assert judged(lambda: None) is None


def test_changes_keep_most_of_a_file() -> None:
    """A fuzzer that only writes noise tests the first line of every reader."""
    sound = (Path(__file__).parent / "corpus/scene.yaml").read_bytes()
    kept = [len(set(mutated(sound, random.Random(i)).split()) & set(sound.split())) for i in range(200)]
    assert sorted(kept)[100] > 0.8 * len(set(sound.split()))
