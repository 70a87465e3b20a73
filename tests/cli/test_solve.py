"""`kabo solve`: exit codes, the one JSON object, and a plan file that is whole or absent."""

import hashlib
import json

import jsonschema
import pytest

from kabo.cli.main import parser
from kabo.cli.solving import finish
from kabo.language import load_problem
from kabo.plan import plan_to_json, schema
from kabo.planner import solve as planner
from kabo.planner.result import Result, result_to_json
from kabo.planner.statistics import completed

RESULT = schema("kabo-result-1")


def test_a_plan_is_written_and_shown_as_a_tree(kabo, parcels):
    said = kabo("solve", "one.yaml")
    assert said.code == 0
    assert "read_label(p=box)" in said.out and "oslo:" in said.out
    assert "3 outcomes" in said.err and "3 actions" in said.err
    assert (parcels / "plan.json").read_bytes().endswith(b"}\n")
    assert [path.name for path in parcels.iterdir() if path.name.startswith(".")] == []


def test_json_is_one_object_of_the_schema_and_the_hash_is_of_the_file(kabo, parcels):
    said = kabo("solve", "one.yaml", "--json", "-o", "p.json")
    jsonschema.validate(said.json, RESULT)
    assert (said.code, said.json["status"], said.json["plan"]) == (0, "solved", "p.json")
    digest = hashlib.sha256((parcels / "p.json").read_bytes()).hexdigest()
    assert said.json["plan_hash"] == f"sha256:{digest}"
    figures = said.json["statistics"]
    assert (figures["plan_actions"], figures["plan_leaves"], figures["plan_nodes"]) == (3, 3, 6)


def test_no_plan_is_exit_3_and_leaves_the_old_file_alone(kabo, parcels):
    (parcels / "plan.json").write_text("old")
    said = kabo("solve", "hopeless.yaml", "--json")
    jsonschema.validate(said.json, RESULT)
    assert (said.code, said.json["status"], said.json["reason"]["proved"]) == (3, "no_plan", "knowledge")
    assert (parcels / "plan.json").read_text() == "old"
    told = kabo("solve", "hopeless.yaml")
    assert told.code == 3 and told.out == "" and "no plan (proved by knowledge)" in told.err


def test_a_spent_budget_is_exit_4_and_says_what_was_spent(kabo, parcels):
    said = kabo("solve", "one.yaml", "--max-expansions", "0", "--json")
    jsonschema.validate(said.json, RESULT)
    assert (said.code, said.json["reason"]["budget"]) == (4, "expansions")
    assert not (parcels / "plan.json").exists()


def test_bad_input_is_exit_2_with_every_finding(kabo, parcels):
    (parcels / "domain.yaml").write_text((parcels / "domain.yaml").read_text().replace("K(held(p))", "K(hold(p))"))
    said = kabo("solve", "one.yaml", "--json")
    jsonschema.validate(said.json, RESULT)
    assert (said.code, said.json["status"], len(said.json["diagnostics"])) == (2, "invalid", 2)
    assert said.json["reason"]["message"] == "2 problems in 1 file"
    told = kabo("solve", "one.yaml")
    assert told.out == "" and told.err.count('did you mean "held"?') == 2


@pytest.mark.parametrize(
    "arguments",
    [
        ["absent.yaml"],
        ["one.yaml", "-o", "absent/plan.json"],
        ["one.yaml", "-o", "."],
        ["one.yaml", "--epsilon", "0"],
        ["one.yaml", "--epsilon", "nan"],
        ["one.yaml", "--seed", "-1"],
        ["one.yaml", "--search", "fastest"],
        ["one.yaml", "--timeout", "-1"],
        ["one.yaml", "--memory", "much"],
        [],
    ],
)
def test_unusable_arguments_are_exit_2_and_write_nothing(kabo, parcels, arguments):
    said = kabo("solve", *arguments)
    assert said.code == 2 and said.out == "" and said.err
    assert "Traceback" not in said.err
    assert not list(parcels.glob("*.json"))


def test_the_same_seed_writes_the_same_bytes(kabo, parcels):
    files = []
    for name in ("a.json", "b.json"):
        assert kabo("solve", "one.yaml", "--seed", "3", "-o", name).code == 0
        files.append((parcels / name).read_bytes())
    assert files[0] == files[1]
    assert json.loads(files[0])["options"]["seed"] == 3


def test_an_interrupt_is_exit_4_without_a_file(kabo, parcels, monkeypatch):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(planner, "solve", interrupted)
    said = kabo("solve", "one.yaml", "--json")
    jsonschema.validate(said.json, RESULT)
    assert said.code == 4 and "interrupted" in said.err
    assert not list(parcels.glob("*.json"))


def test_a_defect_is_exit_1_and_says_how_to_report_it(kabo, parcels, monkeypatch):
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("on purpose")

    monkeypatch.setattr(planner, "solve", broken)
    said = kabo("solve", "one.yaml", "--json")
    assert said.code == 1 and said.json["code"] == "failed"
    assert "a defect of kabo" in said.err and "report" in said.err


def test_a_missing_system_library_is_told_in_one_line(kabo, parcels, monkeypatch):
    def missing(*_: object, **__: object) -> None:
        raise ImportError("libgomp.so.1: cannot open shared object file: No such file or directory")

    monkeypatch.setattr(planner, "solve", missing)
    said = kabo("solve", "one.yaml")
    assert said.code == 1 and said.err.count("\n") == 1 and "apt-get install libgomp1" in said.err


def test_a_plan_whose_certificate_could_not_be_made_is_told_with_the_first_gap(parcels, capsys):
    plan = planner.solve(load_problem("one.yaml")).plan
    gaps = ["n3: peg and socket are not proven apart", "n4: peg and socket are not proven apart"]
    body = result_to_json(Result("solved", plan, completed({"certificate_gaps": gaps, "certificate_s": 0.1})))
    jsonschema.validate(body, RESULT)
    said = "the plan has no certificate: n3: peg and socket are not proven apart (and 1 more)"
    for options, cut_off, count in (([], (), 1), (["--json"], (), 0), ([], ("the certificate was cut off",), 0)):
        given = parser().parse_args(["solve", "one.yaml", *options])
        given.output = parcels / "p.json"
        assert finish(body | ({"cut_off": [*cut_off]} if cut_off else {}), plan_to_json(plan), given) == 0
        assert capsys.readouterr().err.count(said) == count
