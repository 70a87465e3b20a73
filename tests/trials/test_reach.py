"""examples/pick_and_place/reach.yaml: kabo's own planner finds where the object can be put down, and how long it takes."""

from pathlib import Path

from kabo.exploration import Journal
from kabo.trials import Invalid, Valid, exploration_of, load_exploration_file, run_exploration, trial_of

REACH = Path(__file__).resolve().parents[2] / "examples" / "pick_and_place" / "reach.yaml"


def test_a_place_on_the_table_takes_its_time_and_one_beyond_its_edge_is_named() -> None:
    trial = trial_of(load_exploration_file(REACH))
    on_the_table, beyond = (trial({}, {"x": x, "y": -0.3}, 1) for x in (0.5, 0.72))
    assert isinstance(on_the_table, Valid) and 5.0 < on_the_table.outcomes["duration"] < 12.0
    assert isinstance(beyond, Invalid) and beyond.reason == "place pose: constraint"
    assert trial({}, {"x": 0.5, "y": -0.3}, 1) == on_the_table


def test_a_run_that_is_resumed_writes_the_same_bytes(tmp_path: Path) -> None:
    file = load_exploration_file(REACH)
    whole, torn = tmp_path / "whole.jsonl", tmp_path / "torn.jsonl"
    run_exploration(Journal.create(whole, exploration_of(file)), trial_of(file), 6)
    run_exploration(Journal.create(torn, exploration_of(file)), trial_of(file), 3)
    with torn.open("ab") as lines:
        lines.write(b'{"case": {}, "para')
    run_exploration(Journal.resume(torn), trial_of(file), 6)
    assert torn.read_bytes() == whole.read_bytes()
