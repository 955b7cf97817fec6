"""What the keywords of a deck mean to creak: read, harmless to leave out, or a change of the answer."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import lru_cache

from creak.errors import InputError, suggest
from creak.model.mesh import Model
from creak.words import first_few

SHOWN = 3
"""Keywords that a sentence names."""


@dataclass(frozen=True)
class Meaning:
    """The meaning of one keyword or card."""

    role: str
    """read, harmless, changes (leaving it out changes the answer), or depends (on the analysis that is asked for)."""
    why: str = ""
    params: frozenset[str] = frozenset()
    """Parameters that creak reads or that cannot change the answer."""
    owners: tuple[str, ...] = ()
    """Keywords that this one is an option of."""

    @property
    def changes_answer(self) -> bool:
        return self.role == "changes"


READ = Meaning("read")


def listed(role: str, groups: Mapping[str, str]) -> dict[str, Meaning]:
    """Name -> meaning, from reason -> names with commas between them."""
    return {name.strip(): Meaning(role, why) for why, names in groups.items() for name in names.split(",")}


NEAR = 0.8
"""Share of letters from which on a word that may say anything is taken for a misspelled one."""


def misspelling(word: str, read: Collection[str], known: Collection[str] = ()) -> str:
    """Words about a name of three letters or more that looks like one that is read, and is neither that nor `known`."""
    if len(word) < 3 or word in known or word in read:
        return ""
    near = get_close_matches(word, read, n=1, cutoff=NEAR)
    return f"creak does not know it. Did you mean {near[0]!r}?" if near else ""


@dataclass(frozen=True, eq=False)
class Catalogue:
    """Every name that creak knows."""

    what: str
    """keyword, or card"""
    known: Mapping[str, Meaning]

    def meaning(self, name: str) -> Meaning:
        """What a name means; an unknown one may change the answer."""
        if name in self.known:
            return self.known[name]
        why = f"creak does not know this {self.what}"
        hint = self.meant(name)
        return Meaning("changes", f"{why}. {hint}" if hint else why)

    @lru_cache(maxsize=10000)  # noqa: B019 -- a catalogue lives as long as the program
    def meant(self, name: str) -> str:
        """`Did you mean ...?` for a name; empty where no known one, of the same first or last letter, is like it."""
        hint = suggest(name, [k for k in self.known if k[:1] == name[:1] or k[-1:] == name[-1:]])
        return hint if hint.startswith("Did you mean") else ""

    def misspelled(self, named: Iterable[tuple[str, str, str]]) -> str:
        """Hint at the first of (name, as written, file and line) that looks like a misspelling: it may have caused an
        error; empty without one."""
        seen = set(self.known)
        for name, written, where in named:
            hint = "" if name in seen else self.meant(name)
            seen.add(name)
            if hint:
                return f"Note that {written} at {where} is not a {self.what} that creak knows. {hint}"
        return ""


def ignored_in_vain(model: Model, ignore: Iterable[str]) -> list[str]:
    """A sentence for each word of `ignore` that names nothing of the deck that was left unread."""
    unread = dict.fromkeys(_word(u.keyword) for u in model.unread)
    left = first_few(unread, SHOWN) or "nothing"
    return [
        f"--ignore {word!r} names nothing that was left unread ({left}): it changes nothing"
        for word in ignore
        if _word(word) not in unread
    ]


def _word(keyword: str) -> str:
    return keyword.upper().lstrip("*")


def without_unread_damping(model: Model, why: str) -> Model:
    """The model where damping that was not read changes no answer, for the reason `why`."""
    unread = (replace(u, changes_answer=False, why=why) if u.damps else u for u in model.unread)
    return replace(model, unread=tuple(unread))


def without_unread_motion(model: Model) -> Model:
    """The model where speeds at the start that were not read change no answer: modes have none."""
    why = "modes do not start from anything"
    unread = (
        replace(u, changes_answer=False, why=why) if _word(u.keyword).startswith("INITIAL_VELOCITY") else u
        for u in model.unread
    )
    return replace(model, unread=tuple(unread))


def same_share(share: float) -> str:
    """What is said of modal damping that a study may give instead."""
    return f"modes have no damping; in a study [damping] modal = {share:g} does the same"


def with_named_stops(model: Model, named: Collection[str]) -> Model:
    """The model where gaps of the deck count as used whose node sets are all among those that connectors name."""
    told = {stop.where for stop in model.stops if set(stop.node_sets) <= {name.upper() for name in named}}
    why = "a [[connector]] of the study stands in its place"
    unread = (replace(u, changes_answer=False, used=True, why=why) if u.where in told else u for u in model.unread)
    return replace(model, unread=tuple(unread))


def with_open_stops(model: Model) -> Model:
    """The model where gaps of the deck change no answer of a structure that does not move far: those that are open."""
    still = {stop.where for stop in model.stops if not stop.closed}
    why = "it is open: nothing of it acts in modes"
    unread = (replace(u, changes_answer=False, why=why) if u.where in still else u for u in model.unread)
    return replace(model, unread=tuple(unread))


def stop_on_unread(model: Model, ignore: Iterable[str]) -> None:
    """Stop where the model was read without something that changes the answer, but the keywords of `ignore`.

    Raises
    ------
    InputError : there is such a keyword; the first one.
    """
    accepted = {_word(k) for k in ignore}
    for unread in model.unread:
        if unread.changes_answer and _word(unread.keyword) not in accepted:
            keyword = unread.keyword.lstrip("*")
            raise InputError(
                f"{unread.keyword} is not read by creak and would change the answer: {unread.why}",
                where=unread.where,
                fix=f"Remove it, or run with --ignore {keyword!r} to go on without it.",
            )
