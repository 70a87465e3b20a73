"""`kabo explore ask`, `tell`, `infer` and `show`: questions to a model, and trials that are made elsewhere."""

import os

import jsonschema
import pytest

from kabo.cli import main
from kabo.exploration import load_exploration
from kabo.plan import schema
from tests.support.discs import FILE, write_files

SCHEMA = schema("kabo-explore-1")
COMMANDS = (
    ("ask", "m.jsonl"),
    ("tell", "m.jsonl", "--case", "bar=steel", "--set", "along=0", "force=20", "--invalid"),
    ("infer", "m.jsonl", "--target", "torque=0"),
    ("show", "m.jsonl"),
)


def valid_for(answer, name):
    jsonschema.validate(answer, SCHEMA)
    jsonschema.validate(answer, {**SCHEMA, "anyOf": [{"$ref": f"#/$defs/{name}"}]})
    return answer


@pytest.fixture
def begun(kabo, tmp_path, monkeypatch):
    """A model without trials, as for a robot."""
    write_files(tmp_path)
    (tmp_path / "disc.yaml").write_text(FILE.replace("trial: tests/Disc\n", ""))
    monkeypatch.chdir(tmp_path)
    assert kabo("explore", "run", "disc.yaml", "--trials", 0, "-o", "m.jsonl").code == 0
    return tmp_path


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The bytes of a model with 40 trials."""
    folder = tmp_path_factory.mktemp("made")
    write_files(folder)
    files = [str(folder / name) for name in ("disc.yaml", "disc.py", "m.jsonl")]
    assert main(["explore", "run", files[0], "--stages", files[1], "--trials", "40", "-o", files[2]]) == 0
    return (folder / "m.jsonl").read_bytes()


@pytest.fixture
def model(made, tmp_path, monkeypatch):
    """A folder with that model; the current one during the test."""
    write_files(tmp_path)
    (tmp_path / "m.jsonl").write_bytes(made)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_robot_asks_and_tells(kabo, begun):
    said = kabo("explore", "ask", "m.jsonl", "--case", "bar=wood", "--json")
    answer = valid_for(said.json, "Asked")
    assert said.code == 0 and answer["case"] == {"bar": "wood"} and answer["trials"] == 0
    assert answer["parameters"] == {"along": 0.0, "force": 20.0}
    tried = ("--case", "bar=wood", "--set", "along=0", "force=20")
    said = kabo("explore", "tell", "m.jsonl", *tried, "--invalid", "--reason", "dropped", "--json")
    assert said.code == 0 and valid_for(said.json, "Told")["reason"] == "dropped" and said.json["trials"] == 1
    answer = kabo("explore", "ask", "m.jsonl", "--case", "bar=wood", "--json").json
    assert answer["parameters"] == {"along": 0.0, "force": 22.0} and (answer["trials"], answer["valid"]) == (1, 0)
    tried = ("--case", "bar=wood", "--set", "along=0", "--set", "force=22")
    said = kabo("explore", "tell", "m.jsonl", *tried, "--valid", "--outcome", "torque=-0.6", "--json")
    assert said.code == 0 and said.json["outcomes"] == {"torque": -0.6} and said.json["valid"] is True
    assert [trial.valid for trial in load_exploration("m.jsonl").trials] == [False, True]


def test_ask_says_what_to_try(kabo, model):
    said = kabo("explore", "ask", "m.jsonl", "--case", "bar=steel")
    assert said.code == 0 and said.out.startswith("bar steel\n  try along ") and " N\n" in said.out
    assert kabo("explore", "ask", "m.jsonl").out == kabo("explore", "ask", "m.jsonl").out


def test_without_a_start_ask_has_nothing_to_offer_until_it_is_told_a_trial(kabo, begun):
    text = FILE.replace("trial: tests/Disc\n", "").replace("start: {along: 0.0, force: 20}\n", "")
    (begun / "disc.yaml").write_text(text)
    kabo("explore", "run", "disc.yaml", "--trials", 0, "-o", "n.jsonl")
    said = kabo("explore", "ask", "n.jsonl", "--json")
    assert said.code == 4 and valid_for(said.json, "Nothing")["reason"] == "not_explored"
    assert said.json["nearest"] is None and said.json["message"] in said.err
    told = ("--case", "bar=steel", "--set", "along=0", "force=20", "--valid", "--outcome", "torque=0")
    assert kabo("explore", "tell", "n.jsonl", *told).code == 0
    assert kabo("explore", "ask", "n.jsonl", "--case", "bar=steel").code == 0


def test_infer_gives_parameters_for_an_outcome(kabo, model):
    said = kabo("explore", "infer", "m.jsonl", "--target", "torque=0", "--where", "bar=steel", "--json")
    answer = valid_for(said.json, "InferredAnswer")
    assert said.code == 0 and answer["case"] == {"bar": "steel"} and answer["validity"] > 0.95
    assert abs(answer["parameters"]["along"] - 0.01) < 0.005 and abs(answer["expected"]["torque"]) < 0.1
    said = kabo("explore", "infer", "m.jsonl", "--target", "torque=0", "--where", "bar=steel")
    assert said.code == 0 and said.out.startswith("bar steel\n  along ") and " Nm\n" in said.out


def test_infer_of_the_least_and_the_most(kabo, model):
    least, most = (
        kabo("explore", "infer", "m.jsonl", "--target", f"torque={word}", "--json").json["expected"]["torque"]
        for word in ("least", "most")
    )
    assert least < -1.0 and most > 1.0


def test_infer_refuses_what_is_too_far_off_and_tells_the_nearest(kabo, model):
    said = kabo("explore", "infer", "m.jsonl", "--target", "torque=50", "--json")
    answer = valid_for(said.json, "Nothing")
    assert said.code == 4 and answer["reason"] == "out_of_range" and answer["nearest"]["expected"]["torque"] > 1.0
    for tolerance in ("none", "49", "torque=49"):
        said = kabo("explore", "infer", "m.jsonl", "--target", "torque=50", "--tolerance", tolerance, "--json")
        assert said.code == 0 and said.json["expected"] == answer["nearest"]["expected"]
    assert kabo("explore", "infer", "m.jsonl", "--target", "torque=0", "--tolerance", "1e-9").code == 4


def test_infer_without_trials_or_where_nothing_is_that_valid_says_so(kabo, begun):
    said = kabo("explore", "infer", "m.jsonl", "--target", "torque=0", "--json")
    assert said.code == 4 and said.json["reason"] == "not_explored"
    kabo("explore", "tell", "m.jsonl", "--case", "bar=steel", "--set", "along=0", "force=20", "--invalid")
    said = kabo("explore", "infer", "m.jsonl", "--target", "torque=0", "--json")
    assert said.code == 4 and said.json["reason"] == "nothing_valid"


def test_show_tells_each_case(kabo, model):
    answer = valid_for(kabo("explore", "show", "m.jsonl", "--json").json, "Shown")
    assert [case["case"] for case in answer["cases"]] == [{"bar": "steel"}, {"bar": "wood"}]
    for case in answer["cases"]:
        assert case["valid"] + sum(case["reasons"].values()) == case["trials"] > 0
        torque = case["outcomes"]["torque"]
        assert torque["lowest"] < torque["highest"] and torque["unit"] == "Nm" and 0.0 < torque["error"] < 1.0
    assert answer["trials"] == sum(case["trials"] for case in answer["cases"]) == 40
    assert answer["digest"] == load_exploration("m.jsonl").digest
    said = kabo("explore", "show", "m.jsonl")
    assert said.code == 0 and "bar steel: " in said.out and "dropped" in said.out and "torque" in said.out


def test_show_writes_a_page(kabo, model):
    said = kabo("explore", "show", "m.jsonl", "--html", "m.html")
    page = (model / "m.html").read_text()
    assert said.code == 0 and not said.out and "m.html: 40 trials" in said.err
    assert page.startswith("<!DOCTYPE html>") and "bar steel" in page and page.count("<svg class") == 4
    assert kabo("explore", "show", "m.jsonl", "--html", "nowhere/m.html").code == 2


@pytest.mark.parametrize("path", ["m.jsonl", "./m.jsonl", "linked.html"])
def test_the_page_is_not_written_over_the_model(kabo, model, path):
    (model / "linked.html").symlink_to("m.jsonl")
    before = (model / "m.jsonl").read_bytes()
    said = kabo("explore", "show", "m.jsonl", "--html", path)
    assert said.code == 2 and "m.jsonl:1:1: the command reads" in said.err.replace("linked.html", "m.jsonl")
    assert (model / "m.jsonl").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["ask", "--case", "bar=wod"], '--case:1:1: unknown value of bar "wod": did you mean "wood"?'),
        (["ask", "--case", "bra=wood"], 'did you mean "bar"?'),
        (["ask", "--case", "bar"], "--case:1:1: write --case NAME=VALUE"),
        (["tell", "--case", "bar=steel", "--set", "along=0", "--invalid"], "--set:1:1: the parameter force is missing"),
        (["tell", "--case", "bar=steel", "--set", "along=0.1", "force=2", "--invalid"], "outside its bounds -0.08 to"),
        (["tell", "--case", "bar=steel", "--set", "along=nan", "force=2", "--invalid"], '"along" must be a finite'),
        (["tell", "--case", "bar=steel", "--set", "along=inf", "force=2", "--invalid"], '"along" must be a finite'),
        (["tell", "--case", "bar=steel", "--set", "alog=0", "force=2", "--invalid"], 'did you mean "along"?'),
        (["tell", "--case", "bar=steel", "--set", "force=1", "force=2", "--invalid"], '"force" is given twice'),
        (["tell", "--set", "along=0", "force=2", "--invalid"], "--case:1:1: the case must say bar"),
        (["tell", "--case", "bar=steel", "--set", "along=0", "force=2"], "one of --valid and --invalid is missing"),
        (["tell", "--case", "bar=steel", "--set", "along=0", "force=2", "--valid"], "a valid trial has an outcome"),
        (
            ["tell", "--case", "bar=steel", "--set", "along=0", "force=2", "--valid", "--outcome", "torqe=1"],
            'unknown outcome "torqe": did you mean "torque"?',
        ),
        (
            ["tell", "--case", "bar=steel", "--set", "along=0", "force=2", "--valid", "--outcome", "torque=inf"],
            '"torque" must be a finite number, this is "inf"',
        ),
        (
            ["tell", "--case", "bar=steel", "--set", "along=0", "force=2", "--invalid", "--outcome", "torque=1"],
            "an invalid trial has no outcome",
        ),
        (
            ["tell", "--case", "bar=steel", "--set", "along=0", "force=2", "--valid", "--outcome", "torque=1",
             "--reason", "x"],
            "a valid trial has no reason",
        ),
        (["infer", "--target", "torqe=1"], 'did you mean "torque"?'),
        (["infer", "--target", "torque=nan"], "must be a finite number, least or most"),
        (["infer", "--target", "torque=0", "--alpha", "1"], "--alpha:1:1: write a probability above 0 and below 1"),
        (["infer", "--target", "torque=0", "--alpha", "x"], "--alpha:1:1: write a probability above 0 and below 1"),
        (["infer", "--target", "torque=0", "--where", "bar=stel"], 'did you mean "steel"?'),
        (["infer", "--target", "torque=0", "--tolerance", "-1"], "write a number from 0 on"),
        (["infer", "--target", "torque=0", "--tolerance", "nan"], "--tolerance:1:1: write a number from 0 on"),
        (["infer", "--target", "torque=0", "--tolerance", "torqe=1"], '--tolerance:1:1: unknown outcome "torqe": did'),
        (["infer", "--target", "torque=0", "--tolerance", "torque=-1"], "--tolerance:1:1: the tolerance must be a number"),
    ],
)  # fmt: skip
def test_wrong_arguments_are_refused_and_the_model_stays_as_it_was(kabo, model, arguments, message):
    before = (model / "m.jsonl").read_bytes()
    command, *rest = arguments
    said = kabo("explore", command, "m.jsonl", *rest)
    assert said.code == 2 and message in said.err and "Traceback" not in said.err, said.err
    assert (model / "m.jsonl").read_bytes() == before


@pytest.mark.parametrize("command", COMMANDS, ids=lambda each: each[0])
@pytest.mark.parametrize(
    ("change", "place"),
    [
        (lambda lines: [], "m.jsonl:1:1: this is no model of an exploration"),
        (lambda lines: ['{"format": "kabo-plan/1"}\n'], "m.jsonl:1:1: this is no model of an exploration, its format"),
        (lambda lines: ["name: x\n"], "m.jsonl:1:1: this is no JSON"),
        (lambda lines: [lines[0].replace('"to": 0.08', '"to": -0.08'), *lines[1:]], "m.jsonl:1:1: "),
        (lambda lines: [lines[0].replace('"seed": 0', '"seed": 0, "x": 1')], 'm.jsonl:1:1: unknown key "x"'),
        (lambda lines: [*lines[:5], lines[5][:30] + "\n", *lines[6:]], "m.jsonl:6:"),
        (lambda lines: [*lines[:3], lines[3].replace('"along": ', '"along": 9.5, "f": '), *lines[4:]], "m.jsonl:4:1: "),
        (lambda lines: [*lines[:3], lines[3].replace('"along": ', '"along": NaN, "x": '), *lines[4:]], "m.jsonl:4:1: NaN"),
        (lambda lines: [*lines[:2], lines[2].replace("steel", "stel").replace("wood", "wod"), *lines[3:]], "did you mean"),
        (lambda lines: [*lines[:2], '{"case": {"bar": "wood"}, "parameters": {"along": 0, "force": 2}, "valid": true}\n'],
         'm.jsonl:3:1: the key "outcomes" is missing'),
        (lambda lines: [*lines[:2], "\n", *lines[2:]], "m.jsonl:3:1: "),
    ],
    ids=["empty", "foreign", "no JSON", "bounds", "key", "torn", "outside", "nan", "case", "outcome", "blank"],
)  # fmt: skip
def test_a_damaged_model_is_refused_with_its_place_and_stays_as_it_was(kabo, model, command, change, place):
    lines = (model / "m.jsonl").read_text().splitlines(keepends=True)
    (model / "m.jsonl").write_text("".join(change(lines)))
    before = (model / "m.jsonl").read_bytes()
    name, *rest = command
    for json in ((), ("--json",)):
        said = kabo("explore", name, *rest, *json)
        assert said.code == 2 and place in said.err and "Traceback" not in said.err, said.err
    assert said.json["code"] == "bad_request"
    assert (model / "m.jsonl").read_bytes() == before
    assert sorted(os.listdir(model)) == ["disc.py", "disc.yaml", "m.jsonl"]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda each: each[0])
def test_a_torn_last_line_is_dropped(kabo, model, command):
    text = (model / "m.jsonl").read_bytes()
    (model / "m.jsonl").write_bytes(text[:-15])
    name, *rest = command
    assert kabo("explore", name, *rest).code == 0
    trials = load_exploration("m.jsonl").trials
    assert len(trials) == (40 if name == "tell" else 39)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda each: each[0])
def test_a_model_that_is_not_there_is_told(kabo, model, command):
    (model / "m.jsonl").unlink()
    name, *rest = command
    said = kabo("explore", name, *rest)
    assert said.code == 2 and "m.jsonl:1:1: No such file" in said.err
