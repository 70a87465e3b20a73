"""`kabo explain`: sentences on standard output, one JSON object with `--json`, the exit codes of `solve`."""

import jsonschema

from kabo.plan import schema

SCHEMA = schema("kabo-explain-1")


def test_a_solvable_problem_is_exit_0(kabo, parcels):
    said = kabo("explain", "one.yaml")
    assert said.code == 0 and said.out.startswith("There is a plan as far as knowledge goes") and said.err == ""
    assert not (parcels / "plan.json").exists()


def test_a_dead_end_is_exit_3_and_names_the_outcome(kabo, parcels):
    said = kabo("explain", "hopeless.yaml")
    assert said.code == 3 and "dead end" in said.out
    assert "once destination(box) turns out to be york, no plan reaches the goal any more" in said.out


def test_json_is_one_object_of_the_schema(kabo, parcels):
    for name, verdict in (("one.yaml", "solvable"), ("hopeless.yaml", "proved")):
        said = kabo("explain", name, "--json")
        jsonschema.validate(said.json, SCHEMA)
        assert (said.json["verdict"], said.json["procedures"], said.json["counterfactuals"]) == (verdict, [], [])


def test_a_goal_out_of_reach_is_told_with_its_cause(kabo, parcels):
    domain = parcels / "domain.yaml"
    domain.write_text(
        domain.read_text().replace("    sense: destination(p)\n", "    effects:\n      - add(Kf, held(p))\n")
    )
    said = kabo("explain", "one.yaml", "--json")
    jsonschema.validate(said.json, SCHEMA)
    assert (said.code, said.json["knowledge"]["reachable"]) == (3, False)
    assert "destination(box)" in " ".join(said.json["knowledge"]["unreachable_goals"])
    told = kabo("explain", "one.yaml")
    assert "Parts of the goal that never hold:" in told.out and "not known at the start" in told.out


def test_a_spent_budget_is_exit_4(kabo, parcels):
    said = kabo("explain", "one.yaml", "--max-expansions", "0", "--json")
    jsonschema.validate(said.json, SCHEMA)
    assert (said.code, said.json["verdict"]) == (4, "exhausted")


def test_bad_input_is_exit_2_with_the_place(kabo, parcels):
    domain = parcels / "domain.yaml"
    domain.write_text(domain.read_text().replace("K(held(p))", "K(hold(p))", 1))
    said = kabo("explain", "one.yaml")
    assert said.code == 2 and said.out == "" and 'did you mean "held"?' in said.err
    said = kabo("explain", "one.yaml", "--json")
    jsonschema.validate(said.json, SCHEMA)
    assert said.json["verdict"] == "invalid" and "domain.yaml, line 20" in said.json["summary"][1]


def test_a_missing_file_is_one_message(kabo, parcels):
    said = kabo("explain", "absent.yaml")
    assert said.code == 2 and said.out == "" and "absent.yaml" in said.err and "Traceback" not in said.err
    assert kabo("explain").code == 2
