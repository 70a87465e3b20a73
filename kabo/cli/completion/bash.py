"""The completion script for bash, 3.2 and newer; it needs no other package."""

from kabo.cli.completion.tree import Command, Value

HEAD = r"""# bash completion for kabo: eval "$(kabo --completion bash)"
_kabo_words() { COMPREPLY=($(compgen -W "$1" -- "$cur")); }
_kabo_files() {  # endings: a pattern; empty: any file. Folders are offered as well, for the way to files.
    local IFS=$'\n' each any=()
    compopt -o filenames 2>/dev/null
    COMPREPLY=()
    for each in $(compgen -f -- "$cur"); do
        any+=("$each")
        if [[ -d ${each/#\~/$HOME} || -z $1 || $each =~ \.($1)$ ]]; then COMPREPLY+=("$each"); fi
    done
    if [[ ${#COMPREPLY[@]} -eq 0 ]]; then COMPREPLY=("${any[@]}"); fi
}
_kabo_folders() {
    local IFS=$'\n'
    compopt -o filenames 2>/dev/null
    COMPREPLY=($(compgen -d -- "$cur"))
}
_kabo() {
    local cur="${COMP_WORDS[COMP_CWORD]}" command="kabo" before="" word i count=0
    COMPREPLY=()
    if [[ $cur == "=" ]]; then cur=""; before="${COMP_WORDS[COMP_CWORD-1]}"
    elif [[ ${COMP_WORDS[COMP_CWORD-1]} == "=" ]]; then before="${COMP_WORDS[COMP_CWORD-2]}"
    else before="${COMP_WORDS[COMP_CWORD-1]}"; fi
    for ((i = 1; i < COMP_CWORD; i++)); do
        word="${COMP_WORDS[i]}"
        case "$command $word" in
"""
TAIL = """    esac
}
complete -F _kabo kabo
"""


def script(top: Command) -> str:
    """The script for a command line."""
    commands = list(top.all())
    lines = [HEAD.rstrip("\n")]
    names = "|".join(f'"{_name(each)}"' for each in commands if each.path)
    if names:
        lines.append(f'            {names}) command="$command $word"; count=0;;')
    with_values = [
        f'"{_name(each)} {name}"'
        for each in commands
        for option in each.options
        if option.value
        for name in option.names
    ]
    lines.append(f"            {'|'.join(with_values)}) ((i++)); [[ ${{COMP_WORDS[i]}} == '=' ]] && ((i++));;")
    lines += ['            *" -"*) ;;', "            *) ((count++));;", "        esac", "    done"]
    lines.append('    case "$command $before" in')
    for each in commands:
        for option in each.options:
            if option.value is not None:
                patterns = "|".join(f'"{_name(each)} {name}"' for name in option.names)
                lines.append(f"        {patterns}) {_offer(option.value)}; return;;")
    lines += ["    esac", "    if [[ $cur == -* ]]; then", '        case "$command" in']
    for each in commands:
        words = " ".join(name for option in each.options for name in option.names)
        lines.append(f'            "{_name(each)}") _kabo_words "{words}";;')
    lines += ["        esac", "        return", "    fi", '    case "$command $count" in']
    for each in commands:
        if each.inner:
            words = " ".join(inner.path[-1] for inner in each.inner)
            lines.append(f'        "{_name(each)} 0") _kabo_words "{words}";;')
        for index, (value, many) in enumerate(each.values):
            offered = (
                _joined([each.values[later][0] for later in range(index, len(each.values))]) if many else value
            )
            pattern = f'"{_name(each)} {index}"'
            lines.append(f"        {pattern}) {_offer(value)};;")
            if many:
                lines.append(f'        "{_name(each)} "*) {_offer(offered)};;')
    return "\n".join(lines) + "\n" + TAIL


def _name(command: Command) -> str:
    return " ".join(("kabo", *command.path))


def _joined(values: list[Value]) -> Value:
    """A value that is any of these."""
    endings = tuple(dict.fromkeys(ending for value in values for ending in value.endings or ()))
    return Value(values[0].name, endings=endings)


def _offer(value: Value) -> str:
    if value.words:
        return f'_kabo_words "{" ".join(value.words)}"'
    if value.folder:
        return "_kabo_folders"
    return ":" if value.endings is None else f'_kabo_files "{"|".join(value.endings)}"'
