"""docs/explanation/comparison.md says what benchmarks/results has: each figure is computed anew."""

import json
import re
from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).parents[2]
PAGE = (REPOSITORY / "docs" / "explanation" / "comparison.md").read_text()


def rows(name: str) -> list[list[str]]:
    """The cells of the page's table of one benchmark."""
    table = PAGE.split(f"<!-- figures: {name} -->\n")[1].split("<!-- to here -->")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in table]


def measured(name: str) -> dict[str, list[dict[str, Any]]]:
    """The tables of a benchmark, by their titles."""
    tables = json.loads((REPOSITORY / "benchmarks" / "results" / f"{name}.json").read_text())["tables"]
    return {table["title"]: table["rows"] for table in tables}


def row_of(found: list[dict[str, Any]], label: str, **values: str) -> dict[str, Any]:
    """The row of a label, and of the values of other columns."""
    (row,) = (row for row in found if row[""] == label and values.items() <= row.items())
    return row


def test_the_command_of_each_table_is_the_one_of_the_benchmarks_page() -> None:
    benchmarks = (REPOSITORY / "docs" / "explanation" / "benchmarks.md").read_text()
    commands = re.findall(r"^`(python benchmarks/.*)`$", PAGE, re.MULTILINE)
    assert len(commands) == 3
    assert not {command for command in commands if f"`{command}`" not in benchmarks}


def test_times_of_collision_checks_are_those_measured() -> None:
    titles = {"configuration": "Configuration check, ", "motion": "Sweep check, "}
    for where, question, peer, ratio in rows("kernel"):
        scene, configurations = where.rsplit(", ", 1)
        (table,) = (
            found for title, found in measured("kernel").items() if title.startswith(titles[question] + scene)
        )
        assert f"{row_of(table, peer, set=configurations)['p50 x']:.1f}" == ratio


def test_times_of_inverse_kinematics_are_those_measured() -> None:
    for arm, own, own_solved, other, other_solved, ratio in rows("inverse_kinematics"):
        (table,) = (found for title, found in measured("inverse_kinematics").items() if title.startswith(arm))
        kabo, peer = row_of(table, "closed form, a call a pose"), row_of(table, "pinocchio CLIK, up to 10 seeds")
        assert [f"{row['us a pose']:.1f}" for row in (kabo, peer)] == [own, other]
        assert [f"{row['solved']:.2f}" for row in (kabo, peer)] == [own_solved, other_solved]
        assert f"{peer['us a pose'] / kabo['us a pose']:.1f}" == ratio


def test_rates_of_sampling_are_those_measured() -> None:
    (table,) = (found for title, found in measured("sampling").items() if title.startswith("Valid samples"))
    for constraint, own, other, ratio in rows("sampling"):
        kabo = row_of(table, f"{constraint}: kabo, evened out")["valid_per_s"]
        peer = row_of(table, f"{constraint}: pinocchio's Jacobians")
        assert [f"{kabo:.0f}", f"{peer['valid_per_s']:.0f}"] == [own, other]
        assert f"{peer['evened_out_is_faster_by']:.0f}" == ratio
