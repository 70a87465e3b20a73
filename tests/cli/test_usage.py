"""Wrong command lines: one line that says what is wrong and what was meant, with `--json` one object as well."""

import json

import pytest

from kabo.cli.main import COMMANDS, main

# What was written, and what the one line says beside the command.
WRONG = {
    "": "kabo: COMMAND is missing; see `kabo --help`",
    "slove x.yaml": 'kabo: there is no command "slove"; did you mean "solve"?',
    "Solve x.yaml": 'kabo: there is no command "Solve"; did you mean "solve"?',
    "slove x.yaml --json": 'kabo: there is no command "slove"; did you mean "solve"?',
    "slove --seeed 3": 'kabo: there is no command "slove"; did you mean "solve"?',
    "help": 'kabo: there is no command "help"; did you mean `kabo --help`?',
    "version": 'kabo: there is no command "version"; did you mean `kabo --version`?',
    "stages": 'kabo: there is no command "stages"; did you mean `kabo task stages`?',
    "plan x.yaml": 'kabo: there is no command "plan"; did you mean `kabo solve` or `kabo task plan`?',
    "x.yaml": 'kabo: there is no command "x.yaml"; a command comes first:',
    "xyzzy": 'kabo: there is no command "xyzzy"; there are solve, verify,',
    "solve": "kabo solve: PROBLEM is missing; see `kabo solve --help`",
    "solve --seeed 3 x.yaml": "kabo solve: there is no option --seeed; did you mean --seed? `kabo solve --help` lists all",
    "solve --seeed": "kabo solve: there is no option --seeed; did you mean --seed?",
    "solve x.yaml --seed": "kabo solve: --seed needs a value",
    "solve x.yaml --seed abc": "kabo solve: --seed: 'abc' is not a whole number from 0 on",
    "solve x.yaml --seed=": "kabo solve: --seed: '' is not a whole number from 0 on",
    "solve x.yaml --search bst": 'kabo solve: --search: there is no "bst"; did you mean "best"?',
    "solve x.yaml --search=bst": 'kabo solve: --search: there is no "bst"; did you mean "best"?',
    "solve x.yaml --clearance 3mmm": "kabo solve: --clearance: '3mmm' is not a length: write metres or millimetres",
    "solve x.yaml --clearance 3cmm": "kabo solve: --clearance: '3cmm' is not a length: write metres or millimetres",
    "solve x.yaml --quality best": 'kabo solve: --quality: there is no "best"; choose fast or good',
    "solve x.yaml --certificate=yes": "kabo solve: --certificate takes no value",
    "solve x.yaml --no-certifcate": "kabo solve: there is no option --no-certifcate; did you mean --no-certificate?",
    "solve x.yaml --json=1": "kabo solve: --json takes no value",
    "solve x.yaml --s 3": "kabo solve: --s may mean --search or --seed",
    "solve x.yaml -o": "kabo solve: -o needs a value",
    "solve x.yaml -x": "kabo solve: there is no option -x; see `kabo solve --help`",
    "solve x.yaml -o /nowhere/at/all/p.json": "kabo solve: -o: '/nowhere/at/all/p.json' is no file in a folder that exists",
    "solve a b c": "kabo solve: one problem file, or a domain and a problem file, not 3 files",
    "solve x.yaml --timeout soon": "kabo solve: --timeout: 'soon' is not a number of seconds above 0, or none",
    "--seed 3 solve x.yaml": "kabo: --seed is an option of `kabo solve`; write it after that: kabo solve … --seed",
    "--qiet solve x.yaml": "kabo: there is no option --qiet; did you mean --quiet?",
    "-z": "kabo: there is no option -z; see `kabo --help`",
    "verify x.yaml": "kabo verify: PLAN is missing",
    "verify": "kabo verify: PROBLEM and PLAN are missing",
    "check x.yaml --epsilon 0.1": "kabo check: there is no option --epsilon; see `kabo check --help`",
    "explain x.yaml --geometry exact": 'kabo explain: --geometry: there is no "exact"; choose bounding or none',
    "generate bartender": "kabo generate: --n and -o are missing",
    "task": "kabo task: COMMAND is missing; see `kabo task --help`",
    "task paln x.yaml": 'kabo task: there is no command "paln"; did you mean "plan"?',
    "task stages A B": 'kabo task stages: too many arguments: "B"',
    "task compare a.json": "kabo task compare: B.json is missing",
    "explore tell m --set a=1 --valid --invalid": "kabo explore tell: --invalid and --valid exclude each other",
    "explore tell m --set a=1": "kabo explore tell: one of --valid and --invalid is missing",
    "explore infer m": "kabo explore infer: --target is missing",
    "bound m.off --epsilon 1mm -o o.off": "kabo bound: --epsilon: '1mm' is not a length above 0: write metres",
    "bound m.off --epsilom 1% -o o.off": "kabo bound: there is no option --epsilom; did you mean --epsilon?",
    "bound m.off --epsilon 1% -o o.off --side outter": 'kabo bound: --side: there is no "outter"; did you mean "outer"?',
    "serve extra": 'kabo serve: too many arguments: "extra"',
    "--completion": "kabo: --completion needs a value",
    "--completion bsh": 'kabo: --completion: there is no "bsh"; did you mean "bash"?',
    "--completion powershell": 'kabo: --completion: there is no "powershell"; choose bash, zsh or fish',
    "--log": "kabo: --log needs a value",
}


@pytest.mark.parametrize("written", WRONG)
def test_a_wrong_command_line_gets_one_line(kabo, written):
    said = kabo(*written.split())
    assert said.code == 2
    assert said.err.count("\n") == 1 and said.err.startswith(WRONG[written])
    if "--json" not in written:
        assert said.out == ""


@pytest.mark.parametrize("written", WRONG)
def test_with_json_anywhere_it_is_an_object_as_well(kabo, written):
    """Even if the command does not exist, or has no --json: then that may be what is told."""
    said = kabo(*written.split(), "--json")
    assert said.code == 2 and said.err.count("\n") == 1
    assert said.json == {"code": "bad_request", "message": said.err.rstrip("\n")}


@pytest.mark.parametrize("command", [command.NAME for command in COMMANDS])
def test_every_command_names_an_option_that_does_not_exist(kabo, command):
    said = kabo(command, "--no-such-option")
    assert said.code == 2 and "--no-such-option" in said.err or "no command" in said.err


def test_what_is_right_is_not_refused(kabo, parcels, tmp_path):
    for before, after in ((["-q"], []), ([], ["-q"]), (["-v", "--log", tmp_path / "l"], ["-v"])):
        assert kabo(*before, "check", "one.yaml", *after).code == 0
    assert kabo("check", "one.yaml", "--js").json["valid"] is True


def test_a_null_character_is_no_argument(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["solve", "x\0.yaml", "--json"])
    assert ended.value.code == 2
    assert json.loads(capsys.readouterr().out)["code"] == "bad_request"


@pytest.mark.parametrize(
    "option",
    [
        "solve one.yaml --seed",
        "solve one.yaml --max-samples",
        "explain one.yaml --changes",
        "motion one.yaml --samples",
        "task plan one.yaml --repeat",
        "view one.json --solution",
        "view one.json --port",
    ],
)
def test_a_number_of_hundreds_of_digits_gets_one_line(kabo, option):
    """It is no float, and its text no message."""
    said = kabo(*option.split(), "9" * 400)
    assert said.code == 2 and said.err.count("\n") == 1 and len(said.err) < 250
    assert option.split()[-1] in said.err
