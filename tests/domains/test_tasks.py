"""The procedures of the bundled domains: each is a task file beside its domain, to be read and changed there."""

from pathlib import Path

import pytest

import kabo
from kabo.language.yaml.procedures import TASK_FOLDER, TASK_LIBRARY

DOMAINS = Path(__file__).parents[2] / "domains"
PROBLEMS = [
    "bartender/four_bottles.yaml",
    "circular_rearrange/n3.yaml",
    "force_sensing/n2.yaml",
    "stacked/n3.yaml",
]
OWN = {("force_sensing", "sense_weight")}  # unlike the library's on purpose


@pytest.mark.parametrize("problem", PROBLEMS)
def test_every_procedure_that_a_domain_calls_is_a_task_beside_it(problem):
    folder = (DOMAINS / problem).parent / TASK_FOLDER
    loaded = kabo.load_problem(DOMAINS / problem)
    called = {
        action.geometry.procedure for action in loaded.domain.actions.values() if action.geometry is not None
    }
    assert called
    assert called == {path.stem for path in folder.glob("*.yaml")}


@pytest.mark.parametrize(
    "file", sorted(DOMAINS.glob(f"*/{TASK_FOLDER}/*.yaml")), ids=lambda path: f"{path.parts[-3]}/{path.stem}"
)
def test_a_task_beside_a_domain_is_that_of_the_library_unless_it_is_meant_to_differ(file):
    same = file.read_text() == (TASK_LIBRARY / file.name).read_text()
    assert same != ((file.parts[-3], file.stem) in OWN)
