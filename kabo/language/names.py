"""Translates names of PDDL and PKS files to kabo's spelling, one to one; the original names are kept for messages.

kabo's names are `[a-z][a-z0-9_]*`. Every other character becomes `_`. If the result is a keyword, it gets the
suffix `_1`; if it is already in use, it gets `_2`, `_3`, … in the order of the file.
"""

import re
import unicodedata
from collections.abc import Iterable

NAME = re.compile(r"[a-z][a-z0-9_]*")
RESERVED = frozenset(
    ("and", "or", "xor", "not", "forall", "exists", "exactly_one", "when", "then", "add", "del", "true", "false")
    + ("initially", "always", "K", "Kf", "Kw", "Kv", "Kx", "Kor", "LCW")
)

_LONGEST = 200
_IN_LATIN = str.maketrans(
    {"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "æ": "ae", "œ": "oe", "ø": "oe", "å": "aa", "ł": "l", "đ": "d"}
    | {"Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ẞ": "SS", "Æ": "Ae", "Œ": "Oe", "Ø": "Oe", "Å": "Aa", "Ł": "L", "Đ": "D"}
)


class Names:
    """A namespace that gives each name of a file a unique name in kabo."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self._taken = {*RESERVED, *taken}
        self.originals: dict[str, str] = {}  # kabo's name -> the name in the file

    def take(self, original: str) -> str:
        """Reserves and returns an unused name in kabo for the name `original` of the file."""
        name = self.free(original)
        self._taken.add(name)
        self.originals[name] = original
        return name

    @staticmethod
    def plain(original: str) -> str:
        """The name `original` in kabo's spelling, whether or not it is in use."""
        fits = NAME.fullmatch(original) is not None and len(original) <= _LONGEST
        spelled = original if fits else proper_name(original)
        stem = spelled.removesuffix("_1")
        return stem if stem in RESERVED else spelled

    def free(self, original: str, also_taken: Iterable[str] = ()) -> str:
        """An unused name for `original` that is also not among `also_taken`; it is not reserved."""
        taken = set(also_taken)
        stem = self.plain(original)
        name, number = (f"{stem}_1", 2) if stem in RESERVED else (stem, 2)
        while name in self._taken or name in taken:
            name, number = f"{stem}_{number}", number + 1
        return name


def proper_name(word: str) -> str:
    """The valid name most similar to `word`: `isEmpty` becomes `is_empty`, `r'` becomes `r_prime`, `Würfel` `wuerfel`.

    Letters without accents stand for those with them.
    """
    plain = unicodedata.normalize("NFKD", unicodedata.normalize("NFC", word[:_LONGEST]).translate(_IN_LATIN))
    plain = "".join(each for each in plain if not unicodedata.combining(each))
    spelled = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", plain.replace("'", "_prime"))
    spelled = re.sub(r"[^a-z0-9]+", "_", spelled.lower()).strip("_")[:60]
    if not spelled or not spelled[0].isalpha():
        spelled = f"n{spelled}"
    return f"{spelled}_1" if spelled in RESERVED else spelled
