"""`kabo verify`: exit code 5 and the place when a plan does not keep what it promises."""


def test_a_plan_of_solve_is_verified(kabo, parcels):
    assert kabo("solve", "one.yaml").code == 0
    said = kabo("verify", "one.yaml", "plan.json", "--json")
    assert (said.code, said.json["ok"], said.json["findings"]) == (0, True, [])
    assert "verified" in kabo("verify", "one.yaml", "plan.json").err


def test_a_tampered_plan_is_exit_5_with_the_node(kabo, parcels):
    assert kabo("solve", "one.yaml").code == 0
    plan = parcels / "plan.json"
    plan.write_text(plan.read_text().replace('"b":"b1"', '"b":"b2"'))
    said = kabo("verify", "one.yaml", "plan.json", "--json")
    assert said.code == 5 and not said.json["ok"]
    assert {finding["node"] for finding in said.json["findings"]} != {None}


def test_a_file_that_is_no_plan_is_exit_2(kabo, parcels):
    (parcels / "plan.json").write_text('{"format": "kabo-plan/1"}')
    assert kabo("verify", "one.yaml", "plan.json").code == 2
    assert kabo("verify", "one.yaml", "absent.json").code == 2
    assert kabo("verify", "absent.yaml", "plan.json").code == 2


def test_a_missing_plan_is_named_with_its_place_and_what_was_meant(kabo, parcels):
    assert kabo("solve", "one.yaml").code == 0
    said = kabo("verify", "one.yaml", "plan.jso").err
    assert said.startswith("plan.jso:1:1: there is no such file") and 'did you mean "plan.json"?' in said
