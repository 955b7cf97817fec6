"""What --verbose tells of a study before it is run: sizes, and choices that were made."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from creak.cli.output import Output
from creak.words import first_few

if TYPE_CHECKING:
    from creak.model.mesh import Model, Unread
    from creak.studies.prepare.setup import Setup

KEYWORDS = 3
"""Most keywords that a line names."""


def list_unread(output: Output, unread: tuple[Unread, ...]) -> None:
    """A line for each reason why keywords were not read, or what is to be told of some; one for all without effect."""
    alike: dict[tuple[str, str], list[str]] = {}
    idle = list(dict.fromkeys(u.keyword for u in unread if not (u.changes_answer or u.used)))
    if idle:
        output.say(f"not read, without effect (creak info tells why): {first_few(idle, KEYWORDS)}")
    for u in unread:
        if not (u.changes_answer or u.used):
            continue
        alike.setdefault((u.word, u.why), []).append(f"{u.keyword} ({u.where})")
    for (word, why), names in alike.items():
        output.say(f"{word}: {first_few(names, KEYWORDS)}: {why}")


def tell_vain(output: Output, model: Model, ignore: Iterable[str]) -> None:
    """A warning for each --ignore that names nothing of the deck."""
    from creak.formats.deck.catalogue import ignored_in_vain

    for text in ignored_in_vain(model, ignore):
        output.warn(text)


def model_detail(output: Output, model: Model) -> None:
    """Size of a deck."""
    if not output.verbose:
        return
    parts = ", ".join(f"{p.name} ({p.nodes_idx.size:,} nodes)" for p in model.parts)
    output.detail(
        f"model: {model.nodes.count:,} nodes, {model.n_elements:,} elements, "
        f"{len(model.constraints):,} constraints; parts: {parts}"
    )


def setup_detail(output: Output, setup: Setup) -> None:
    """Sizes and choices of a study."""
    if not output.verbose:
        return
    from creak.linalg.mkl import has_pardiso

    model_detail(output, setup.model)
    config, loads = setup.study.config, setup.loads
    for name, table in config.contact.items():
        count = setup.contacts.group.count(name)
        output.detail(
            f"contact {name}: {table.method}, stiffness {table.stiffness}, {count} channels before the pre-check"
        )
    if setup.connectors.m:
        output.detail(f"connectors: {setup.connectors.m} channels")
    highest = setup.band.excited
    known = f" up to {highest:g} Hz" if highest else ""
    output.detail(f"excitation: {', '.join(config.excitation) or 'none'}{known}")
    method = config.reduction.method
    more = " or more, as far as it takes" if setup.band.auto else ""
    reduction = method if method in ("none", "guyan") else f"{method} to {setup.band.f_max:g} Hz{more}"
    output.detail(f"reduction: {reduction}")
    time = config.time
    steps = f"{loads.n_step // time.substeps:,} steps of {time.step:g} s to {loads.time[-1]:g} s"
    output.detail(f"time: {steps}, {f'accuracy {time.accuracy}' if time.exact else time.integrator}")
    damping = config.damping
    kind = next((name for name, given in damping if given is not None), "the deck's").replace("from_test", "measured")
    output.detail(f"damping: {kind}; sparse solver: {'MKL PARDISO' if has_pardiso() else 'SuperLU'}")


def tell_warnings(output: Output, notes: Iterable[str], told: set[str]) -> None:
    """The notes that warn, on stderr, but those in `told`, which grows by them."""
    from creak.studies.warned import warnings_of

    for text in warnings_of(notes):
        if text not in told:
            output.warn(text)
            told.add(text)


def tell_setup(output: Output, no_contact: str | None, notes: Sequence[str], told: set[str]) -> None:
    """Before a run: in red why nothing can touch, then the notes that warn."""
    if no_contact:
        output.alarm(no_contact)
    tell_warnings(output, notes, told)


def tell_notes(output: Output, notes: Sequence[str], told: set[str]) -> None:
    """Warnings on stderr, other notes among the results."""
    from creak.studies.warned import plain_notes

    tell_warnings(output, notes, told)
    for note in plain_notes(notes):
        output.say(f"note: {note}")
