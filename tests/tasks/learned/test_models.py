"""Models of tasks: opened beside the task file, with answers that are kept by content."""

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.exploration import Exploration, NoParametersError
from kabo.language.source import UnreadableError
from kabo.tasks.learned import Model, open_model
from kabo.tasks.learned.models import model_of
from tests.support.bars import explored, write_model

LEVEL = ({"torque": 0.0}, {"bar": "steel"}, 0.95, "deviation", 2)


def test_a_model_lies_beside_what_names_it(tmp_path: Path) -> None:
    (tmp_path / "tasks").mkdir()
    path = write_model(tmp_path, trials=5)
    model = open_model("../model.jsonl", str(tmp_path / "tasks"))
    assert (str(model), Path(model)) == ("../model.jsonl", path)
    assert model.exploration.trials == explored(5).trials
    with pytest.raises(UnreadableError, match="there is no such file"):
        open_model("model.jsonl", str(tmp_path / "tasks"))
    with pytest.raises(UnreadableError, match="this is a folder"):
        open_model(".", str(tmp_path))


def test_in_python_a_path_or_an_exploration_will_do(tmp_path: Path, known: Exploration) -> None:
    path = write_model(tmp_path, trials=5)
    assert model_of(known).exploration is known
    assert model_of(path).exploration.digest == model_of(str(path)).exploration.digest
    assert model_of(model := model_of(path)) is model
    with pytest.raises(InputError, match="there is no such file"):
        model_of(tmp_path / "none.jsonl")


def test_answers_are_kept_by_the_content_of_the_model(tmp_path: Path) -> None:
    path = write_model(tmp_path, trials=30)
    first = model_of(path).alternatives(*LEVEL)
    assert model_of(path).alternatives(*LEVEL) is first, "the same content gives the answer that is kept"
    assert model_of(path).alternatives(*LEVEL[:-1], 1) != first
    write_model(tmp_path, trials=31)
    assert model_of(path).alternatives(*LEVEL) is not first


def test_an_exploration_that_is_told_more_answers_anew() -> None:
    growing = explored(30)
    model = Model("growing", "", growing)
    first = model.alternatives(*LEVEL)
    growing.tell({"bar": "steel"}, first[0].parameters, False, reason="dropped")
    assert model.alternatives(*LEVEL) != first


def test_that_there_is_nothing_is_kept_too(known: Exploration) -> None:
    for _ in range(2):
        with pytest.raises(NoParametersError) as told:
            Model("m", "", known).alternatives({"torque": 7.0}, {"bar": "steel"}, 0.95, "deviation", 1)
        assert told.value.reason == "out_of_range" and told.value.nearest is not None
