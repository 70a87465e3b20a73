"""Random command lines: commands, options and values as they are, and as fingers slip."""

import random

_FILES = (
    *(
        "corpus/problem.yaml",
        "corpus/domain.yaml",
        "corpus/scene.yaml",
        "corpus/task.yaml",
        "corpus/medicate.json",
    ),
    *(
        "corpus/logistics.pddl",
        "corpus/pks_typed.xml",
        "domains/medicate/n5.yaml",
        "corpus/tetra.off",
        "nothing.yaml",
    ),
    *(
        "corpus/tetra.stl",
        "corpus/report.json",
        "corpus/exploration.yaml",
        "corpus/model.jsonl",
        "corpus/plan.json",
        "",
        ".",
        "/",
        "/dev/null",
        "x" * 300,
        "a\0b",
        "é.yaml",
    ),
)
_VALUES = (
    *(
        "0",
        "1",
        "-1",
        "10",
        "0.01",
        "1e300",
        "1e-300",
        "nan",
        "inf",
        "",
        "x",
        "best",
        "astar",
        "none",
        "exact",
        "1%",
    ),
    *(
        "101%",
        "1 mm",
        "99999999999999999999",
        "true",
        "lazy",
        "good",
        "o.json",
        "o.off",
        "/proc/o.json",
        "/o/o.json",
    ),
    *("torque=0", "torque=least", "bar=steel", "along=0", "tests/Anything", "o.jsonl"),
    *("robot=arm", "steps=x", "steps=1e300", "=", "n=3", "-", "--"),
)
_OPTIONS = {
    "check": ("--json",),
    "verify": ("--json", "--knowledge-only", "--paranoid"),
    "solve": (
        *("--json", "--search", "--seed", "--epsilon", "--geometry-order", "--quality", "--certificate", "-o"),
        *("--no-certificate", "--max-expansions", "--max-samples", "--workers", "--timeout"),
    ),
    "explain": ("--json", "--search", "--seed", "--epsilon", "--max-expansions", "--max-samples", "--changes"),
    "generate": ("--n", "--set", "-o"),
    "bound": ("--epsilon", "--scale", "--repair", "--side", "--vertices", "--cost", "--borders", "--json", "-o"),
    "decompose": ("--epsilon", "--scale", "--parts", "--vertices-per-part", "--seed", "--json", "-o"),
    "task show": ("--json", "--comments", "--html"),
    "task stages": ("--json",),
    "task compare": ("--json",),
    "task": ("--json",),
    "explore run": ("--json", "--trials", "--stages", "--seed", "--invalid-budget", "--resume", "-o", "--timeout"),
    "explore ask": ("--json", "--case", "--timeout"),
    "explore tell": ("--json", "--case", "--set", "--valid", "--invalid", "--outcome", "--reason"),
    "explore infer": ("--json", "--target", "--where", "--alpha", "--tolerance"),
    "explore show": ("--json", "--html"),
    "explore": ("--json",),
    "": ("--version", "--json", "--help"),
}
_BOUNDED = {  # so that no command does much: what is tried here is what it is told
    "solve": ("--timeout", "1", "--max-expansions", "5", "--geometry", "none"),
    "explain": ("--timeout", "1", "--max-expansions", "5", "--geometry", "none", "--changes", "0"),
}


def drawn(rng: random.Random) -> list[str]:
    """The words behind `kabo`."""
    name = rng.choice([*_OPTIONS, "serv", "Solve"])
    words = name.split()
    words += [rng.choice(_FILES) for _ in range(rng.choice((0, 1, 1, 1, 2, 2, 3)))]
    for _ in range(rng.choice((0, 1, 1, 2, 3))):
        option = rng.choice(
            _OPTIONS.get(name, ("--json",)) + (rng.choice(("--jso", "--nothing", "-x", "--epsilon")),)
        )
        words.append(option)
        if rng.random() < 0.8:
            words.append(rng.choice(_VALUES))
    return [*words, *_BOUNDED.get(name, ())]
