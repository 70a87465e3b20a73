"""`kabo explain` and `kabo solve` where geometry stands in the way: the report, JSON, and three lines."""

from pathlib import Path

import jsonschema

from kabo.plan import schema
from tests.planner.gantry import gantry

LID = {"lid": ((0.2, 0.2, 0.01), (0.2, 0.0, 0.1))}


def test_the_report_names_what_blocks_and_what_helps(kabo, tmp_path: Path) -> None:
    problem = gantry(tmp_path, walls=LID)
    said = kabo("explain", problem, "--max-samples", 2000)
    lines = said.out.splitlines()
    assert said.code == 4 and said.err == ""
    assert lines[0] == "No plan was found: pick(gantry, cube) never succeeded."
    assert lines[1].startswith("It was blocked by lid in ") and lines[1].endswith("samples (100 %).")
    assert lines[2] == "Without lid a plan of 2 actions exists."
    assert "Procedures that failed:" in lines and "  - without lid: a plan of 2 actions" in lines


def test_json_of_geometry_is_one_object_of_the_schema(kabo, tmp_path: Path) -> None:
    said = kabo("explain", gantry(tmp_path, robots="robots: []"), "--json", "--changes", 0)
    jsonschema.validate(said.json, schema("kabo-explain-1"))
    assert (said.code, said.json["verdict"]) == (3, "proved")
    assert said.json["procedures"][0]["failures"][0]["reason"] == "empty_family"


def test_without_geometry_only_knowledge_is_asked(kabo, tmp_path: Path) -> None:
    said = kabo("explain", gantry(tmp_path, walls=LID), "--geometry", "none")
    assert said.code == 0 and "There is a plan as far as knowledge goes" in said.out


def test_solve_says_the_main_things_in_three_lines(kabo, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    said = kabo("solve", gantry(tmp_path, walls=LID), "--max-samples", 2000)
    lines = said.err.strip().splitlines()
    assert said.code == 4 and len(lines) <= 3
    assert lines[0].startswith("no plan found (samples exhausted)")
    assert lines[1].startswith("  - pick(gantry, cube): blocked by lid in ")
