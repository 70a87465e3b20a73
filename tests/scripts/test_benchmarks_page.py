"""docs/explanation/benchmarks.md has the figures of the files in benchmarks/results/, and no others."""

import json

import pytest

from scripts.benchmarks_page import PAGE, RESULTS, ROOT, page, questions, results

FILES = [path for script in questions() for path in results(script)]


def test_the_page_is_what_the_script_writes():
    assert page() == PAGE.read_text(), f"python -m scripts.benchmarks_page writes {PAGE.relative_to(ROOT)}"


def test_every_script_has_its_question_and_every_file_its_script():
    scripts = {path.stem for path in (ROOT / "benchmarks").glob("*.py") if "ArgumentParser(" in path.read_text()}
    assert set(questions()) == scripts - {"construction_set_peer"}
    assert {path for path in RESULTS.rglob("*") if path.is_file()} == set(FILES)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_says_when_where_and_how_it_was_measured(path):
    content = json.loads(path.read_text())
    around = content["surroundings"]
    assert content["tables"] and all(each["rows"] for each in content["tables"])
    assert all(around[name] for name in ("command", "date", "commit", "processor", "cores", "load", "python"))
    script = path.relative_to(RESULTS).parts[0].removesuffix(".json")
    assert around["command"].split()[1] == f"benchmarks/{script}.py"
