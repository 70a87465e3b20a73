"""The completion script of a shell: `eval "$(kabo --completion bash)"`."""

import argparse

SHELLS = ("bash", "zsh", "fish")


def script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The text of the script for one of `SHELLS`; the same for the same version of kabo."""
    from kabo.cli.completion import bash, fish, tree, zsh  # only who asks for a script pays for them

    made = {"bash": bash.script, "zsh": zsh.script, "fish": fish.script}[shell]
    return made(tree.tree_of(parser))
