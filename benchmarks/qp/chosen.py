"""Which of a benchmark's programs are asked for by ``--only``."""

from __future__ import annotations

from collections.abc import Iterable


class UnknownName(ValueError):
    """A word that fits none of the names; the text says which there are."""


def chosen(names: Iterable[str], only: tuple[str, ...]) -> frozenset[str]:
    """The names asked for: a whole name is that one alone, another word a family, all that begin
    with it and an underscore; every name where nothing is asked for.

    Raises:
        UnknownName: a word is neither.
    """
    all_names = tuple(dict.fromkeys(names))
    if not only:
        return frozenset(all_names)
    found: set[str] = set()
    for word in only:
        family = {name for name in all_names if name.startswith(word.rstrip("_") + "_")}
        fits = {word} if word in all_names else family
        if not fits:
            told = f"nothing here is called {word}, nor begins with {word}_"
            raise UnknownName(f"{told}; there are {', '.join(all_names)}")
        found |= fits
    return frozenset(found)
