"""The options of a solve, from the table of options: what they mean, as fields of a request."""

from kabo.options import OPTIONS, Option


def default(option: Option) -> str:
    """What an option is if nobody says it."""
    said = option.otherwise or ("yes" if option.default is True else f"`{option.default}`")
    return said if option.problem_key is None else f"the problem's, else {said}"


def meaning(option: Option) -> str:
    """What an option means, and its choices unless that names them."""
    unnamed = [choice for choice in option.choices if f"`{choice}`:" not in option.help]
    choices = ", ".join(f"`{choice}`" for choice in option.choices)
    return f"{option.help} ({choices})" if unnamed else option.help


def fields() -> str:
    """The options of a request."""
    return ", ".join(f"`{name}`" for name in OPTIONS)
