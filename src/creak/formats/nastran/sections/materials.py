"""MAT1, MAT2, MAT8 and MAT9 -> materials."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.deck.refusals import referred
from creak.formats.nastran.text.bulk_data import Card
from creak.formats.nastran.text.deck import Deck, unique_cards
from creak.model.elasticity import lamina, require_stable
from creak.model.expansion import Expansion
from creak.model.laminates import STIFF
from creak.model.materials import AnisotropicMaterial, AnyMaterial, Material, SheetMaterial

MATERIALS = ("MAT1", "MAT2", "MAT8", "MAT9")
CONSISTENT = 0.01
"""Share by which G may differ from E/(2(1+nu)) before it is listed."""


@dataclass(frozen=True)
class Elastic:
    """A material and what creak's isotropic material cannot hold."""

    material: AnyMaterial
    shear_factor: float = 1.0
    """G of a MAT1 over E/(2(1+nu))."""
    flaw: InputError | None = None
    """Why only bars and rods may use it: E and G are those of no isotropic body."""


@dataclass(frozen=True)
class Materials:
    """The materials of a deck by id."""

    deck: Deck
    cards: dict[int, Card]
    found: dict[int, Elastic] = field(default_factory=dict)
    """Those that were asked for."""

    def _read(self, identifier: int, user: Card) -> Elastic:
        referred(self.cards, identifier, user, "material", ", ".join(MATERIALS))
        if identifier not in self.found:
            card = self.cards[identifier]
            self.found[identifier] = _READERS[card.name](self.deck, card)
        return self.found[identifier]

    def of(self, identifier: int, user: Card) -> Elastic:
        """The material that a card of shells or solids refers to.

        Raises
        ------
        InputError : it is not defined, a bad number, constants of no stable material.
        """
        found = self._read(identifier, user)
        if found.flaw is not None:
            raise found.flaw
        return found

    def isotropic(self, identifier: int, user: Card) -> tuple[Material, float]:
        """A MAT1 and its shear factor, for bars, beams and rods."""
        found = self._read(identifier, user)
        if not isinstance(found.material, Material):
            raise user.error(f"{user.title} uses {self.cards[identifier].name} {identifier}", expected="a MAT1")
        return found.material, found.shear_factor


def read_materials(deck: Deck) -> Materials:
    """The materials, read when something uses them; densities are multiplied by PARAM,WTMASS.

    Structural damping GE becomes stiffness-proportional damping GE/W4 where PARAM,W4 is given, as in Nastran's
    transient solutions; PARAM,G and W3 add to it, PARAM,ALPHA1 and ALPHA2 are Rayleigh's numbers (see `damping`).

    Raises
    ------
    InputError : an id twice.
    """
    return Materials(deck, unique_cards(deck.cards(*MATERIALS), "material"))


def damping(deck: Deck, card: Card, loss: float = 0.0) -> tuple[float, float]:
    """alpha = ALPHA1 (1/s) and beta = ALPHA2 + G/W3 + GE/W4 (s) of an element that `card` gives GE = `loss`.

    Materials, springs, bushings, masses and added matrices have these numbers each, so that the whole model has
    B = ALPHA1 M + (ALPHA2 + G/W3) K + sum of GE/W4 K_e, and a study's own damping replaces all of it.
    """
    beta, whole = deck.param("ALPHA2", 0.0), deck.param("G", 0.0)
    for value, at, by, what in (
        (whole, "W3", deck.params.get("G", card), "PARAM,G"),
        (loss, "W4", card, f"{card.name}, GE"),
    ):
        if value and deck.param(at, 0.0) > 0.0:
            beta += value / deck.param(at, 0.0)
        elif value:
            joint = at == "W4" and card.name not in MATERIALS  # it damps what moves in it, not the parts
            share, owner = 0.0 if joint else 0.5 * value, "" if at == "W3" or joint else f"{card.name} {card.text(0)}"
            same = "" if joint else f" (modal = {share:g} does the same at resonance)"
            why = (
                f"Nastran's transient solutions use it with PARAM,{at} alone, and so does creak: give that, or "
                f"[damping] in the study{same}"
            )
            deck.note(by, why, changes=False, what=what, damps=True, share=share, share_of=owner)
    return deck.param("ALPHA1", 0.0), beta


def mass_in(deck: Deck, card: Card, i: int, what: str = "a density") -> float:
    """A field with mass, WTMASS applied."""
    if card.real(i, 0.0) < 0.0:
        raise card.wrong(i, f"{what} of zero or more")
    return card.real(i, 0.0) * deck.mass_factor


def _expansion(card: Card, fields: Sequence[int | None], reference: int) -> Expansion | None:
    """Coefficients in these fields, in the order of `Expansion`, and TREF; None where all are blank or zero."""
    some = [0.0 if i is None else card.real(i, 0.0) for i in fields]
    if not any(some):
        return None
    a, b, c, d, e, f = [*some, *[0.0] * 6][:6]
    return Expansion((a, b, c, d, e, f), card.real(reference) if card.text(reference) else None)


def _mat1(deck: Deck, card: Card) -> Elastic:
    """Isotropic; of E, G and nu the third follows from two: G = E/(2(1+nu))."""
    name = f"MAT1 {card.integer(0)}"
    E, G, nu = (card.real(i) if card.text(i) else None for i in (1, 2, 3))
    if E is None and G is None:
        raise card.error(f"{name} has neither E nor G", expected="two of E, G and NU")
    if nu is None and (E is None or G is None):
        why = (
            "creak takes NU = 0 and the other modulus that follows; Nastran takes NU = 0 and that modulus for 0 as well"
        )
        deck.note(card, why, changes=False, what="MAT1 of one modulus alone")
    if E is None and G is not None:
        nu = nu or 0.0
        E = 2.0 * (1.0 + nu) * G
    assert E is not None
    if nu is None:
        nu = E / (2.0 * G) - 1.0 if G else 0.0
    flaw = None
    if not E > 0.0 or not -1.0 < nu < 0.5:
        flaw = card.error(
            f"{name} has E = {E:g} and nu = {nu:g}", expected="E > 0 and -1 < nu < 0.5", fix="Check E, G and NU."
        )
        if not E > 0.0 or (G is not None and G < 0.0):
            raise flaw
        nu = 0.0
    factor = 1.0 if G is None else G * 2.0 * (1.0 + nu) / E
    if abs(factor - 1.0) > CONSISTENT and flaw is None:
        deck.note(
            card,
            f"G is {factor:.4g} times E/(2(1+NU)); creak follows it in bars and shells, and takes E and NU in solids",
            changes=False,
            what="MAT1, G",
        )
    alpha, beta = damping(deck, card, card.real(7, 0.0))
    heat = _expansion(card, (5, 5, 5), 6)
    return Elastic(Material(name, E, nu, mass_in(deck, card, 4), alpha, beta, heat), factor, flaw)


def _upper(card: Card, first: int, n: int) -> FloatArray:
    """Symmetric (n, n) from its upper triangle, row by row, from field `first` on."""
    matrix = np.zeros((n, n))
    at = first
    for i in range(n):
        for j in range(i, n):
            matrix[i, j] = matrix[j, i] = card.real(at, 0.0)
            at += 1
    return matrix


def _mat2(deck: Deck, card: Card) -> Elastic:
    """Anisotropic sheet: G11 G12 G13 G22 G23 G33, RHO. As a shear material (MID3) G11, G12, G22 are used."""
    G = _upper(card, 1, 3)
    alpha, beta = damping(deck, card, card.real(12, 0.0))
    rho = mass_in(deck, card, 7)
    heat = _expansion(card, (8, 9, None, 10), 11)
    return Elastic(SheetMaterial(f"MAT2 {card.integer(0)}", G, G[:2, :2], rho, alpha, beta, expansion=heat))


def _mat8(deck: Deck, card: Card) -> Elastic:
    """Orthotropic sheet: E1 E2 NU12 G12 G1Z G2Z RHO; blank G1Z or G2Z: rigid in transverse shear."""
    E1, E2, nu12, G12 = (card.real(i) for i in (1, 2, 3, 4))
    if not min(E1, E2, G12) > 0.0:
        raise card.error(
            f"MAT8 {card.integer(0)} has E1 = {E1:g}, E2 = {E2:g} and G12 = {G12:g}", expected="positive moduli"
        )
    G1z, G2z = (card.real(i, 0.0) or STIFF * G12 for i in (5, 6))
    in_plane, shear = lamina(E1, E2, nu12, G12, G1z, G2z, where=card.where)
    alpha, beta = damping(deck, card, card.real(16, 0.0))
    rho = mass_in(deck, card, 7)
    given = (E1, E2, nu12, G12, G1z, G2z)
    return Elastic(
        SheetMaterial(f"MAT8 {card.integer(0)}", in_plane, shear, rho, alpha, beta, given, _expansion(card, (8, 9), 10))
    )


def _mat9(deck: Deck, card: Card) -> Elastic:
    """Anisotropic solid, 21 entries by rows, RHO; the order xx, yy, zz, xy, yz, zx is creak's own."""
    G = _upper(card, 1, 6)
    require_stable(G, card.where)
    alpha, beta = damping(deck, card, card.real(30, 0.0))
    rho = mass_in(deck, card, 22)
    heat = _expansion(card, (23, 24, 25, 26, 27, 28), 29)
    return Elastic(AnisotropicMaterial(f"MAT9 {card.integer(0)}", G, rho, alpha, beta, heat))


_READERS: dict[str, Callable[[Deck, Card], Elastic]] = {"MAT1": _mat1, "MAT2": _mat2, "MAT8": _mat8, "MAT9": _mat9}
