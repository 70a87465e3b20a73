"""The completion script for fish, 3.1 and newer."""

from kabo.cli.completion.tree import Command, Option, Value

HEAD = r"""# fish completion for kabo: kabo --completion fish > ~/.config/fish/completions/kabo.fish
function __kabo_command  # the command that is being written: its words
    set -l words (commandline -opc)
    set -l path
    for word in $words[2..-1]
        if contains -- (string trim -- "$path $word") COMMANDS
            set path $path $word
        end
    end
    echo -- "$path"
end
function __kabo_at
    set -l path (__kabo_command)
    test "$path" = "$argv"
end
function __kabo_files  # files with one of these endings, and folders, for the way to files; any file if there is none
    set -l found (complete -C"'' "(commandline -ct))
    set -l endings (string join -- '|' $argv)
    set -l fitting (string match -r -e -- "(?:/|\.(?:$endings))(?:\t|\$)" $found)
    if test -n "$fitting"
        string join -- \n $fitting
    else
        string join -- \n $found
    end
end
complete -c kabo -f
"""


def script(top: Command) -> str:
    """The script for a command line."""
    commands = list(top.all())
    names = " ".join(_quoted(" ".join(each.path)) for each in commands if each.path)
    lines = [HEAD.replace("COMMANDS", names).rstrip("\n")]
    for command in commands:
        at = f"complete -c kabo -n {_quoted(('__kabo_at ' + ' '.join(command.path)).strip())}"
        lines += [f"{at} -a {inner.path[-1]} -d {_quoted(inner.help)}" for inner in command.inner]
        lines += [f"{at}{_option(option)}" for option in command.options]
        offered = [value for value, _ in command.values]
        if offered and (said := _offer(offered)):
            lines.append(f"{at} -a {said}")
    return "\n".join(lines) + "\n"


def _option(option: Option) -> str:
    names = "".join(f" -l {name[2:]}" if name.startswith("--") else f" -s {name[1:]}" for name in option.names)
    said = f"{names} -d {_quoted(option.help)}"
    if option.value is None:
        return said
    offered = _offer([option.value])
    return f"{said} -x -a {offered}" if offered else f"{said} -x"


def _offer(values: list[Value]) -> str:
    words = [word for value in values for word in value.words]
    if words:
        return _quoted(" ".join(words))
    if values[0].folder:
        return "'(__fish_complete_directories)'"
    if all(value.endings is None for value in values):
        return ""
    endings = list(dict.fromkeys(ending for value in values for ending in value.endings or ()))
    return _quoted(
        f"(__kabo_files {' '.join(endings)})" if endings else "(__fish_complete_path (commandline -ct))"
    )


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace("'", "\\'")
    return f"'{escaped}'"
