"""Programs for the arms of Universal Robots: their syntax, and what they do, read by a grammar of URScript."""

import re

import lark
import numpy as np
import pytest

from kabo.errors import InputError
from kabo.exporting import check_export, export
from kabo.plan import Plan
from tests.exporting.conftest import UR, close, made

GRAMMAR = lark.Lark(
    r"""
    start: _NL* statement+
    ?statement: def | while | if | (assignment | call | HALT) _NL+
    def: "def" NAME "(" [NAME ("," NAME)*] "):" _NL+ statement* "end" _NL+
    while: "while" expression ":" _NL+ statement* "end" _NL+
    if: "if" expression ":" _NL+ statement* "end" _NL+
    assignment: ["local"] NAME "=" expression
    call: NAME "(" [argument ("," argument)*] ")"
    ?argument: NAME "=" expression -> named
        | expression
    ?expression: sum (/[<>]/ sum)?
    ?sum: term (/[+-]/ term)*
    ?term: NUMBER | STRING | BOOL | call | NAME "[" expression "]" -> item | NAME -> variable | list
    list: "[" expression ("," expression)* "]"
    BOOL.2: "True" | "False"
    HALT.2: "halt"
    NAME: /(?!(def|end|while|if|halt|local)\b)[A-Za-z_]\w*/
    NUMBER: /-?\d+(\.\d+)?/
    STRING: /"[^"\n]*"/
    _NL: /[ \t]*(#[^\n]*)?\n/
    %ignore /[ \t]+/
    """,
    parser="lalr",
)
CALLS = {  # of the script manual: how many arguments may be given by place, and which by name
    "movej": (1, {"a", "v", "t", "r"}), "servoj": (1, {"t", "lookahead_time", "gain"}), "stopj": (1, set()),
    "textmsg": (1, set()), "popup": (2, {"warning", "error", "blocking"}), "sleep": (1, set()), "norm": (1, set()),
    "str_cat": (2, set()), "set_standard_digital_out": (2, set()), "get_actual_joint_positions": (0, set()),
}  # fmt: skip


def calls(program: str) -> list[tuple[str, list[str], dict[str, str]]]:
    """The calls of a program's body in order, by a grammar, with their arguments; names that nobody knows fail."""
    tree = GRAMMAR.parse(program)
    own = {
        str(each.children[0]): len([a for a in each.children[1:] if isinstance(a, lark.Token)])
        for each in tree.find_data("def")
    }
    found = []
    for each in tree.find_data("call"):
        name, *arguments = each.children
        arguments = [a for a in arguments if a is not None]
        named = {str(a.children[0]) for a in arguments if isinstance(a, lark.Tree) and a.data == "named"}
        most, names = CALLS.get(str(name), (own.get(str(name), -1), set()))
        assert len(arguments) - len(named) == most and named <= names, name
    for line in program.split("\n"):
        if (match := re.fullmatch(r"  (\w+)\((.*)\)", line)) is not None:
            found.append(
                (
                    match[1],
                    re.findall(r"\[.*?\]|\"[^\"]*\"", match[2]),
                    dict(re.findall(r"(\w+)=([\d.]+)", match[2])),
                )
            )
    return found


def row(text: str) -> list[float]:
    return [float(each) for each in text.strip("[]").split(",")]


def test_the_arm_is_led_along_the_trajectory_at_the_rate(with_ur: Plan) -> None:
    found = calls(export(with_ur, "urscript", branch="true", robot="left", rate=500.0).replace("halt", "halt"))
    said = [arguments[0].strip('"').split()[0] for name, arguments, _ in found if name == "textmsg"]
    assert said == ["n0", "n1", "n2", "n3", "n4", "n5"]
    sent = [(row(arguments[0]), more) for name, arguments, more in found if name == "servoj"]
    assert {
        (more["t"], 0.03 <= float(more["lookahead_time"]) <= 0.2, 100 <= int(more["gain"]) <= 2000)
        for _, more in sent
    } == {("0.002", True, True)}
    first, second, _ = with_ur.nodes["n0"].motion
    whole = first.trajectory.joined(second.trajectory)
    assert close([q for q, _ in sent[:1000]], whole.at(np.arange(1, 1001) / 500.0))
    assert close(sent[-1][0], [-0.5] * 6) and len(sent) == 1500
    order = [name for name, _, _ in found if name.startswith(("kabo", "stop"))]
    assert order == ["kabo_begin_at", "stopj", "kabo_hand", "kabo_sense", "stopj", "kabo_hand", "kabo_wait"]


def test_from_way_point_to_way_point_no_joint_is_faster_than_in_the_plan(with_ur: Plan) -> None:
    program = export(with_ur, "urscript", branch="false", robot="left", way_points=True)
    moves = [(row(arguments[0]), more) for name, arguments, more in calls(program) if name == "movej"]
    assert close(moves[-1][0], [-0.5] * 6)
    fastest = np.abs(np.array(with_ur.nodes["n3"].motion[0].trajectory.bounds(1))).max()
    assert float(moves[-1][1]["v"]) <= fastest + 1e-9
    assert check_export(with_ur, "urscript", program, branch="false", robot="left", way_points=True) is None
    other = program.replace("movej([-0.5", "movej([-0.6")
    assert check_export(with_ur, "urscript", other, branch="false", robot="left", way_points=True) is not None


def test_several_arms_are_refused_unless_one_is_chosen(with_ur: Plan) -> None:
    with pytest.raises(InputError, match=r"left and right move, and a program drives one arm\n.*--robot left"):
        export(with_ur, "urscript", branch="true")
    with pytest.raises(InputError, match="URScript does not drive right with the joints b_1"):
        export(with_ur, "urscript", branch="true", robot="right")


def test_an_arm_that_moves_beside_another_one_is_refused() -> None:
    with pytest.raises(InputError, match="in n4 left and right move at once"):
        export(made(UR, overlap=0.5), "urscript", branch="true", robot="left")
