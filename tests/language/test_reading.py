"""Which files belong together, told by their endings, through every door: Python, commands, service."""

import hashlib
import json
from pathlib import Path

import pytest

import kabo
from kabo.cli import main
from kabo.errors import InputError
from kabo.language import check_files
from kabo.options import SolveOptions
from kabo.requests import solve_file
from kabo.service.inline import pack_problem, unpack_problem
from kabo.service.messages import ProblemFiles
from tests.language.samples import PKS_UNTYPED

DOMAIN = """(define (domain lamps) (:predicates (lit ?l))
  (:action light :parameters (?l) :precondition (not (lit ?l)) :effect (lit ?l)))"""
PROBLEM = "(define (problem two-lamps) (:domain {domain}) (:objects a b) (:init (lit a)) (:goal (lit b)))"


def put(folder: Path, **texts: str) -> None:
    """Writes files named like `problem_pddl`."""
    for name, text in texts.items():
        (folder / ".".join(name.rsplit("_", 1))).write_text(text)


def messages(error: InputError) -> list[str]:
    """The messages of an error."""
    return [each.message for each in error.diagnostics]


# --------------------------------------------------------------------------------------------- what belongs together
def test_the_two_files_may_stand_in_either_order(tmp_path):
    put(tmp_path, d_pddl=DOMAIN, p_pddl=PROBLEM.format(domain="lamps"))
    one = kabo.load_problem(tmp_path / "d.pddl", tmp_path / "p.pddl")
    other = kabo.load_problem(str(tmp_path / "p.pddl"), str(tmp_path / "d.pddl"))
    assert one == other
    assert one.name == "two_lamps"
    assert (one.path, one.domain.path) == (tmp_path / "p.pddl", tmp_path / "d.pddl")
    digest = "sha256:" + hashlib.sha256(DOMAIN.encode()).hexdigest()
    assert dict(one.files)["d.pddl"] == digest
    assert set(one.files) == {"d.pddl", "p.pddl"}


@pytest.mark.parametrize("name", ["domain_pddl", "lamps_pddl", "domain_PDDL"])
def test_a_domain_beside_the_problem_is_found(tmp_path, name):
    ending = name.rsplit("_", 1)[1]
    put(tmp_path, **{name: DOMAIN, f"p_{ending}": PROBLEM.format(domain="lamps")})
    assert set(kabo.load_problem(tmp_path / f"p.{ending}").files) == {f"p.{ending}", name.replace("_", ".")}


def test_of_two_domains_the_named_one_is_taken(tmp_path):
    other = DOMAIN.replace("lamps", "fires")
    put(tmp_path, domain_pddl=other, lamps_pddl=DOMAIN, p_pddl=PROBLEM.format(domain="lamps"))
    assert kabo.load_problem(tmp_path / "p.pddl").domain.name == "lamps"


def test_one_file_may_hold_both(tmp_path):
    put(tmp_path, both_pddl=DOMAIN + PROBLEM.format(domain="lamps"))
    assert list(kabo.load_problem(tmp_path / "both.pddl").files) == ["both.pddl"]


def test_files_in_other_folders_are_recorded_from_the_problem(tmp_path):
    (tmp_path / "problems").mkdir()
    put(tmp_path, d_pddl=DOMAIN)
    put(tmp_path / "problems", p_pddl=PROBLEM.format(domain="lamps"))
    problem = kabo.load_problem(tmp_path / "problems" / "p.pddl", tmp_path / "d.pddl")
    assert set(problem.files) == {"p.pddl", "../d.pddl"}


def test_a_pks_domain_beside_the_problem_is_found(tmp_path):
    start = PKS_UNTYPED.index("<problem")
    domain = PKS_UNTYPED[:start] + "</pks>"
    problem = "<pks>" + PKS_UNTYPED[start:]
    put(tmp_path, domain_pks=domain, p_xml=problem)
    assert set(kabo.load_problem(tmp_path / "p.xml").files) == {"domain.pks", "p.xml"}


@pytest.mark.parametrize(
    ("texts", "named", "message"),
    [
        ({"p_pddl": PROBLEM.format(domain="lamps")}, ["p.pddl"], 'there is no domain "lamps" here'),
        ({"p_pddl": PROBLEM.format(domain="../lamps")}, ["p.pddl"], 'there is no domain "../lamps" here'),
        ({"domain_pddl": DOMAIN, "p_pddl": PROBLEM.format(domain="lamp")}, ["p.pddl"], 'there is no domain "lamp" here'),
        ({"d_pddl": DOMAIN}, ["d.pddl"], "a problem is needed here, this is a domain"),
        ({"p_pddl": DOMAIN + PROBLEM.format(domain="lamps") * 2}, ["p.pddl"],
         'a second problem, "two-lamps", stands here: only one can be solved at a time'),
        ({}, ["p.pddl"], "there is no such file"),
        ({"p_xml": "x"}, ["p.xml"], "this is no PKS file, expected <pks>, <domain> or <problem>"),
        ({"p_pddl": DOMAIN, "p_xml": PKS_UNTYPED}, ["p.pddl", "p.xml"], "the two files are of different formats"),
        ({"p_pddl": DOMAIN, "p_yaml": "problem: p"}, ["p.pddl", "p.yaml"],
         "one file is enough: a problem in YAML names its domain itself"),
        ({"p_pddl": "(define (problem p) (:domain))"}, ["p.pddl"], "a problem must name its domain"),
        ({"p_pddl": "(define (situation p))"}, ["p.pddl"], 'expected "(domain name)" or "(problem name)" here'),
        ({"p_pddl": "(defined)"}, ["p.pddl"], 'unexpected "(defined", expected "(define …"'),
    ],
)  # fmt: skip
def test_files_that_do_not_fit_are_refused(tmp_path, texts, named, message):
    put(tmp_path, **texts)
    with pytest.raises(InputError) as caught:
        kabo.load_problem(*(tmp_path / name for name in named))
    assert message in messages(caught.value)


def test_a_near_file_name_is_proposed(tmp_path):
    put(tmp_path, problem_pddl=DOMAIN)
    with pytest.raises(InputError) as caught:
        kabo.load_problem(tmp_path / "problm.pddl")
    assert caught.value.diagnostics[0].hint == 'did you mean "problem.pddl"?'


def test_another_domain_that_was_named_is_taken_with_a_warning(tmp_path):
    put(tmp_path, d_pddl=DOMAIN, p_pddl=PROBLEM.format(domain="lamps-2"))
    assert kabo.load_problem(tmp_path / "d.pddl", tmp_path / "p.pddl").domain.name == "lamps"
    (finding,) = check_files([tmp_path / "d.pddl", tmp_path / "p.pddl"])
    assert (finding.severity, finding.message) == (
        "warning", 'the problem is for the domain "lamps-2", used is "lamps"',
    )  # fmt: skip


@pytest.mark.parametrize(
    "data", [b"(define \xff)", b"\x00" * 9_000_000, b"(" * 7_000_000], ids=["bytes", "9 MB", "deep"]
)
def test_files_that_are_no_text_or_too_large_are_refused(tmp_path, data):
    for ending in ("pddl", "xml"):
        path = tmp_path / f"file.{ending}"
        path.write_bytes(data)
        with pytest.raises(InputError) as caught:
            kabo.load_problem(path)
        assert caught.value.diagnostics[0].file == str(path)


def test_nothing_outside_of_the_allowed_folder_is_opened(tmp_path):
    inside = tmp_path / "inside"
    inside.mkdir()
    put(tmp_path, d_pddl=DOMAIN, secret_pddl="(tulip)")
    put(inside, p_pddl=PROBLEM.format(domain="lamps"))
    (inside / "domain.pddl").symlink_to(tmp_path / "secret.pddl")
    for other in (tmp_path / "d.pddl", None):
        with pytest.raises(InputError) as caught:
            kabo.language.load_problem(inside / "p.pddl", other, within=inside)
        assert "tulip" not in str(caught.value)


# ----------------------------------------------------------------------------------------------------------- doors
def run(*arguments: object) -> int:
    """A command's exit code."""
    return main([str(each) for each in arguments])


def test_commands_take_a_domain_and_a_problem(tmp_path, capsys):
    put(tmp_path, d_pddl=DOMAIN, p_pddl=PROBLEM.format(domain="lamps"))
    domain, problem, plan = tmp_path / "d.pddl", tmp_path / "p.pddl", tmp_path / "plan.json"
    assert run("solve", domain, problem, "-o", plan) == 0
    assert "light(l=b)" in capsys.readouterr().out
    assert set(json.loads(plan.read_text())["problem"]["files"]) == {"d.pddl", "p.pddl"}
    assert run("verify", domain, problem, plan) == 0
    assert run("verify", problem, domain, plan) == 0
    assert run("check", domain, problem) == 0
    put(tmp_path, d_pddl=DOMAIN.replace("not (lit ?l)", "lit ?l"))
    assert run("verify", domain, problem, plan) == 5


def test_commands_take_a_problem_beside_its_domain(tmp_path):
    put(tmp_path, domain_pddl=DOMAIN, p_pddl=PROBLEM.format(domain="lamps"))
    assert run("solve", tmp_path / "p.pddl", "-o", tmp_path / "plan.json") == 0
    assert run("verify", tmp_path / "p.pddl", tmp_path / "plan.json") == 0


def test_a_faulty_file_is_bad_input_with_its_findings(tmp_path, capsys):
    put(tmp_path, d_pddl=DOMAIN.replace("(lit ?l)))", "(lid ?l)))"), p_pddl=PROBLEM.format(domain="lamps"))
    assert run("solve", tmp_path / "d.pddl", tmp_path / "p.pddl", "--json") == 2
    answer = json.loads(capsys.readouterr().out)
    assert answer["status"] == "invalid"
    assert [each["message"] for each in answer["diagnostics"]] == ['unknown predicate "lid" in action "light"']
    assert run("check", tmp_path / "d.pddl") == 2
    assert 'did you mean "lit"? lit(object) is declared at d.pddl:1:' in capsys.readouterr().err


def test_three_files_are_too_many(tmp_path, capsys):
    with pytest.raises(SystemExit) as caught:
        run("solve", "a.pddl", "b.pddl", "c.pddl")
    assert caught.value.code == 2
    assert "not 3 files" in capsys.readouterr().err


def test_checking_takes_files_of_all_formats_at_once(tmp_path):
    put(
        tmp_path, d_pddl=DOMAIN, p_pddl=PROBLEM.format(domain="lamps"), e_xml=PKS_UNTYPED.replace("K(note", "K(not"),
        y_yaml="domain: d\ntypes: [t]\nactions: {a: {}}\n",
    )  # fmt: skip
    found = check_files(sorted(tmp_path.iterdir()))
    assert {Path(each.file).name for each in found} == {"e.xml"}


def test_a_request_carries_both_files(tmp_path):
    (tmp_path / "here" / "problems").mkdir(parents=True)
    put(tmp_path / "here", d_pddl=DOMAIN)
    put(tmp_path / "here" / "problems", p_pddl=PROBLEM.format(domain="lamps"))
    packed = pack_problem(tmp_path / "here" / "problems" / "p.pddl", tmp_path / "here" / "d.pddl")
    assert packed == {
        "path": "problems/p.pddl", "domain": "d.pddl",
        "files": {"d.pddl": DOMAIN, "problems/p.pddl": PROBLEM.format(domain="lamps")},
    }  # fmt: skip
    there = tmp_path / "there"
    there.mkdir()
    path = unpack_problem(ProblemFiles(packed["path"], packed["files"], packed["domain"]), there)
    answer = solve_file(there / path, SolveOptions(), domain=there / "d.pddl", within=there)
    assert answer.body["status"] == "solved"


def test_the_problem_among_the_files_of_a_request_is_recognised(tmp_path):
    for name, text in (("p.pddl", PROBLEM), ("p.xml", PKS_UNTYPED)):
        files = {"domain.pddl": DOMAIN, name: text}
        assert str(unpack_problem(ProblemFiles(None, files), tmp_path)) == name
