"""`kabo generate`: problems of any size that can be read where they were written."""

import os

import pytest

from kabo.language import load_problem


@pytest.mark.parametrize(("domain", "n"), [("bartender", 2), ("force_sensing", 7), ("stacked", 25)])
def test_a_generated_problem_is_valid_wherever_it_lies(kabo, tmp_path, monkeypatch, domain, n):
    (tmp_path / "deep" / "er").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    path = os.path.join("deep", "er", "p.yaml")
    said = kabo("generate", domain, "--n", n, "-o", path)
    assert (said.code, said.out) == (0, f"{path}\n")
    assert load_problem(path).domain.name
    assert kabo("check", path).code == 0


def test_a_folder_with_a_generator_is_a_domain(kabo, parcels):
    (parcels / "generate.py").write_text("def problem(n, home):\n    return f'# {n} {home}\\n'\n")
    assert kabo("generate", ".", "--n", "4", "-o", "../p.yaml").code == 0
    assert (parcels.parent / "p.yaml").read_text() == "# 4 parcels/\n"


@pytest.mark.parametrize(
    "arguments", [["bartendr", "--n", "2"], ["bartender", "--n", "-2"], ["bartender", "--n", "0"]]
)
def test_what_cannot_be_generated_is_exit_2_and_writes_nothing(kabo, parcels, arguments):
    said = kabo("generate", *arguments, "-o", "p.yaml")
    assert said.code == 2 and said.err and not (parcels / "p.yaml").exists()
    assert arguments[0] != "bartendr" or 'did you mean "bartender"?' in said.err


def test_settings_reach_the_rule_with_the_type_of_its_default(kabo, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert kabo("generate", "safes", "--n", 3, "--set", "note=true", "safes=2", "-o", "p.yaml").code == 0
    problem = load_problem("p.yaml")
    assert problem.of_type("safe") == ("safe_1", "safe_2")
    assert problem.name == "safes_n3_with_note"


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("safe=2", 'did you mean "safes"?'),
        ("colour=red", "it takes safes, note"),
        ("safes", "write KEY=VALUE"),
        ("safes=two", "safes takes a whole number, not 'two'"),
        ("note=maybe", "note takes true or false, not 'maybe'"),
    ],
)
def test_settings_that_the_rule_does_not_take_are_refused(kabo, tmp_path, monkeypatch, setting, said):
    monkeypatch.chdir(tmp_path)
    answer = kabo("generate", "safes", "--n", 3, "--set", setting, "-o", "p.yaml")
    assert answer.code == 2 and said in answer.err and not (tmp_path / "p.yaml").exists()
