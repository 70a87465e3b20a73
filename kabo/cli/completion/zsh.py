"""The completion script for zsh, on top of its own completion system (`compinit`)."""

from kabo.cli.completion.tree import Command, Option, Value

HEAD = """#compdef kabo
# zsh completion for kabo: eval "$(kabo --completion zsh)" after compinit, or a file _kabo in a folder of $fpath
"""
TAIL = """if [[ ${funcstack[1]} == _kabo ]]; then _kabo "$@"; else compdef _kabo kabo; fi
"""


def script(top: Command) -> str:
    """The script for a command line."""
    return HEAD + "\n".join(_function(command) for command in reversed(list(top.all()))) + TAIL


def _function(command: Command) -> str:
    """The function that completes one command."""
    lines = [f"{_name(command)}() {{"]
    if command.inner:
        lines += ["    local curcontext=$curcontext state line", "    local -a commands"]
    lines.append(f"    _arguments {'-C ' if command.inner else ''}-s \\")
    specs = [spec for option in command.options for spec in _specs(option)]
    if command.inner:
        specs += ["'1:command:->command'", "'*::argument:->arguments'"]
    for index, (value, many) in enumerate(command.values):
        if many:
            offered = [later for later, _ in command.values[index:]]
            specs.append(f"'*:{value.name.lower()}:{_action(offered)}'")
            break
        specs.append(f"'{index + 1}:{value.name.lower()}:{_action([value])}'")
    lines.append(" \\\n".join(f"        {spec}" for spec in specs))
    if command.inner:
        offered_ = " ".join(f"'{inner.path[-1]}:{_quoted(inner.help)}'" for inner in command.inner)
        lines += [
            "    case $state in",
            f"        command) commands=({offered_}); _describe command commands;;",
            "        arguments) case $line[1] in",
            *(f"            {inner.path[-1]}) {_name(inner)};;" for inner in command.inner),
            "        esac;;",
            "    esac",
        ]
    return "\n".join([*lines, "}", ""])


def _name(command: Command) -> str:
    return "_".join(("_kabo", *command.path)).replace("-", "_")


def _specs(option: Option) -> list[str]:
    """What `_arguments` is told of an option: a word for each of its names."""
    others = "" if option.again else f"({' '.join(option.names)})"
    value = "" if option.value is None else f":{option.value.name.lower()}:{_action([option.value])}"
    star = "*" if option.again else ""
    equals = "=" if value else ""
    return [
        f"'{others}{star}{name}{equals if name.startswith('--') else '+' if value else ''}[{_quoted(option.help)}]{value}'"
        for name in option.names
    ]


def _action(values: list[Value]) -> str:
    """What `_arguments` does for one of several values."""
    words = [word for value in values for word in value.words]
    if words:
        return f"({' '.join(words)})"
    if values[0].folder:
        return "_files -/"
    endings = list(dict.fromkeys(ending for value in values for ending in value.endings or ()))
    if endings:
        return f'_files -g "*.({"|".join(endings)})(-.)"'
    return " " if all(value.endings is None for value in values) else "_files"


def _quoted(text: str) -> str:
    """Text within brackets within single quotes."""
    for letter in "\\[]:":
        text = text.replace(letter, f"\\{letter}")
    return text.replace("'", "'\\''")
