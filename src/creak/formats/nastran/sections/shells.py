"""PSHELL and PCOMP -> shell sections; PCOMPP with STACK and PLY of OptiStruct: laminates made of plies that each lie on
sets of elements."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from creak.arrays import FloatArray
from creak.errors import InputError
from creak.formats.nastran.mesh.sets import ROW, bulk_sets
from creak.formats.nastran.sections.materials import CONSISTENT, Materials, damping, mass_in
from creak.formats.nastran.text.bulk_data import Card, ids_among
from creak.formats.nastran.text.deck import Deck
from creak.model.elasticity import isotropic_sheet, sheet_matrices
from creak.model.laminates import LOOSE, STIFF, Layup, Moduli, Ply, shell_of
from creak.model.materials import AnyMaterial, GeneralShell, Isotropic, Material, SheetMaterial, ShellSection

PLANE_STRAIN = -1
"""MID2 of a membrane without strain along its normal."""


def sheet_of(materials: Materials, identifier: int, user: Card) -> AnyMaterial:
    """A material as a sheet; a MAT1 whose G is its own keeps it."""
    found = materials.of(identifier, user)
    material = found.material
    if not isinstance(material, Material) or abs(found.shear_factor - 1.0) <= CONSISTENT:
        return material
    return isotropic_sheet(Isotropic(material, found.shear_factor))


def _in_plane_strain(materials: Materials, identifier: int, user: Card) -> SheetMaterial:
    """A MAT1 held along the normal: the in-plane rows of Hooke's law, with (1 + nu) alpha."""
    found = materials.of(identifier, user)
    material = found.material
    if not isinstance(material, Material):
        raise user.error(
            f"{user.title} is in plane strain (MID2 = -1) and its MID1 is {material.name}", expected="a MAT1"
        )
    return isotropic_sheet(Isotropic(material, found.shear_factor, strained=True))


def shell_section(deck: Deck, card: Card, materials: Materials, thickness: float) -> ShellSection | GeneralShell:
    """The section of a PSHELL, PCOMP, PCOMPG or (with an element's plies) PCOMPP card; `thickness` replaces a blank T
    of PSHELL.

    Raises
    ------
    InputError : a missing thickness or material.
    """
    return _pshell(deck, card, materials, thickness) if card.name == "PSHELL" else _pcomp(deck, card, materials)


def is_directed(section: ShellSection | GeneralShell) -> bool:
    """Does the section need a material direction? Not where every in-plane turn leaves it as it is."""
    if isinstance(section, ShellSection):
        return False
    S = section.S
    round_shear = max(abs(S[0, 0] - S[1, 1]), abs(S[0, 1])) <= 1e-9 * np.abs(S).max(initial=1e-300)
    return not round_shear or not all(_isotropic(m) for m in (section.A, section.B, section.D))


def _isotropic(m: FloatArray) -> bool:
    size = np.abs(m).max(initial=1e-300)
    wanted = np.array([[m[0, 0], m[0, 1], 0.0], [m[0, 1], m[0, 0], 0.0], [0.0, 0.0, 0.5 * (m[0, 0] - m[0, 1])]])
    return bool(np.abs(m - wanted).max() <= 1e-9 * size)


def _pshell(deck: Deck, card: Card, materials: Materials, thickness: float) -> ShellSection | GeneralShell:
    """N = T G1 e - T^2 G4 k, M = -T^2 G4 e + (12I/T^3) T^3/12 G2 k, Q = (TS/T) T G3 gamma, k = de/dz.

    (Nastran's curvature has the other sign.) Without MID3, or with TS/T = 0, the shell is rigid in transverse shear.
    MID2 = -1 is a membrane in plane strain.
    """
    mids = _materials_of(card)
    if card.text(4) and not card.real(4) and mids[1] != PLANE_STRAIN:
        mids[1] = 0
    if card.text(6) and not card.real(6):
        mids[2] = 0
    t = card.real(2, thickness) or thickness
    if not t > 0.0:
        raise card.error(f"PSHELL {card.integer(0)} has thickness {t:g}", expected="T > 0")
    bending, shear = card.real(4, 1.0) or 1.0, card.real(6, 5.0 / 6.0) or 1.0
    nsm = mass_in(deck, card, 7, "a mass per area")
    name = f"PSHELL {card.integer(0)}"
    first = next((m for m in mids[:2] if m > 0), 0)
    if not first:
        raise card.error(f"{name} has neither MID1 nor MID2", expected="a material")
    base = sheet_of(materials, first, card)
    plain = mids[1] == mids[0] and mids[2] > 0 and mids[3] == 0 and bending == 1.0 and abs(shear - 5.0 / 6.0) < 1e-4
    if plain and isinstance(base, Material) and mids[2] == mids[0]:
        return ShellSection(name, base, t, nsm)
    return replace(_moduli(deck, card, materials, mids, t, bending, shear), area_mass=nsm)


def _materials_of(card: Card) -> list[int]:
    """MID1 to MID4, 0 where there is none; MID2 may be PLANE_STRAIN."""
    fields = (1, 3, 5, 10)
    mids = [card.integer(i, 0) for i in fields]
    strained = mids[1] == PLANE_STRAIN
    for k, (i, mid) in enumerate(zip(fields, mids, strict=True)):
        if mid < 0 and not (k == 1 and strained):
            raise card.wrong(i, "the number of a material" + (", or -1 for plane strain" if k == 1 else ""))
        if strained and k > 1 and mid:
            raise card.wrong(i, "a blank field beside MID2 = -1 (plane strain), which has no bending")
    return mids


def _moduli(
    deck: Deck, card: Card, materials: Materials, mids: list[int], t: float, bending: float, shear: float
) -> GeneralShell:
    sheets = [sheet_of(materials, m, card) if m > 0 else None for m in mids]
    if mids[1] == PLANE_STRAIN:
        sheets[0] = _in_plane_strain(materials, mids[0], card)
    base = sheets[0] or sheets[1]
    assert base is not None
    across = (shear, sheets[2]) if sheets[2] else (STIFF, base)
    made_of = Moduli(
        t,
        base,
        (1.0, sheets[0]) if sheets[0] else (LOOSE, base),
        (bending, sheets[1]) if sheets[1] else (LOOSE, base),
        across if sheets[1] else (LOOSE * 5.0 / 6.0, base),
        sheets[3],
    )
    if sheets[0] is None or sheets[1] is None:
        deck.note(
            card,
            "a shell without MID1 or MID2 keeps a millionth of the membrane or bending stiffness, so that "
            "no dof is loose",
            changes=False,
            what="PSHELL without MID1 or MID2",
        )
    return shell_of(f"PSHELL {card.integer(0)}", made_of)


def _pcomp(deck: Deck, card: Card, materials: Materials) -> GeneralShell:
    """Plies from the bottom Z0 (default: half the thickness below the grids) up; LAM = SYM mirrors them.

    LAM = MEM has no bending, BEND no membrane (a millionth of it), SMEAR bends as a sheet of the mean modulus.

    TREF and GE of the card stand for those of its materials, as in Nastran.
    """
    plies = _plies(card, materials)
    name = f"{card.name} {card.integer(0)}"
    if not plies:
        raise card.error(f"{name} has no plies", expected="MID, T, THETA of each ply")
    lam = card.text(7).upper()
    if lam in ("SYM", "SYMEM", "SYBEND", "SYSMEAR"):
        plies = [*plies, *reversed(plies)]
        lam = lam[2:] if lam != "SYM" else ""
    if lam not in ("", *_PARTIAL):
        why = f"creak reads LAM blank, SYM, MEM, BEND and SMEAR, not {lam}"
        deck.note(card, why, changes=True, what=f"{card.name}, LAM={lam}")
    bottom = card.real(1) if card.text(1) else None
    beta = damping(deck, card, card.real(6))[1] if card.real(6, 0.0) else None
    layup = Layup(tuple(plies), bottom, left=lam if lam in _PARTIAL else "", beta=beta)
    made = replace(shell_of(name, layup), area_mass=mass_in(deck, card, 2, "a mass per area"))
    if made.expansion is None:
        return made
    return replace(made, expansion=replace(made.expansion, reference=card.real(5, 0.0), flaw=""))


_PARTIAL = ("MEM", "BEND", "SMEAR")


def _plies(card: Card, materials: Materials) -> list[Ply]:
    """PCOMP, PCOMPP: MID T THETA SOUT by fours; PCOMPG: ply id, MID T THETA SOUT by lines of eight."""
    width, skip = (8, 1) if card.name == "PCOMPG" else (4, 0)
    plies: list[Ply] = []
    mid, t = 0, 0.0
    for at in range(8, len(card.fields), width):
        if not any(card.fields[at : at + width]):
            continue
        i = at + skip
        mid, t = card.integer(i, mid), card.real(i + 1, t)
        if not t > 0.0 or not mid:
            raise InputError(
                f"a ply of {card.name} {card.integer(0)} has material {mid} and thickness {t:g}",
                where=card.place(i),
                expected="a material and T > 0",
            )
        material = sheet_of(materials, mid, card)
        if not (np.diag(sheet_matrices(material)[1]) > 0.0).all():
            raise InputError(
                f"a ply of {card.name} {card.integer(0)} has material {mid}, which has no shear modulus",
                where=card.place(i),
                expected="G of MAT1, G1Z and G2Z of MAT8 above 0, or blank",
            )
        plies.append(Ply(material, t, math.radians(card.real(i + 2, 0.0))))
    return plies


Layers = tuple[Card, ...]
"""A STACK and then its PLYs that lie on an element, from the bottom up."""


def layers_of(deck: Deck, elements: Collection[int]) -> dict[int, Layers]:
    """The layers of each of these elements; those that no ply lies on are not there.

    Raises
    ------
    InputError : a ply that is not defined, or draped, or on a set that is not there; a stack of substacks; an element
        in two stacks.
    """
    plies = {card.text(0): card for card in deck.cards("PLY")}
    sets, wanted = bulk_sets(deck, "ELEM"), dict.fromkeys(elements)
    found: dict[int, Layers] = {}
    for stack in deck.cards("STACK"):
        here: dict[int, Layers] = {}
        for i, name in enumerate(stack.fields[2:], start=2):
            if name:
                ply = _ply(stack, i, plies)
                for element in ids_among([ids for s in _sets_of(ply, sets) for ids in sets[s]], wanted):
                    here[element] = (*here.get(element, (stack,)), ply)
        twice = found.keys() & here.keys()
        if twice:
            raise InputError(
                f"element {min(twice)} lies in two stacks, {found[min(twice)][0].text(0)} and {stack.text(0)}",
                where=stack.where,
                expected="one STACK for an element",
                fix="Take its plies out of one of them.",
            )
        found.update(here)
    return found


def as_pcomp(owner: Card, element: Card, layers: Layers) -> Card:
    """The PCOMPP of an element as the PCOMP that it stands for: LAM of the stack, MID, T and THETA of the plies.

    Raises
    ------
    InputError : no ply lies on the element.
    """
    if not layers:
        raise InputError(
            f"no PLY of a STACK lies on {element.name} {element.text(0)}, whose property is PCOMPP {owner.text(0)}",
            where=element.where,
            expected="PLYs on sets (SET, TYPE ELEM) that hold it, in a STACK",
            fix="Add it to a set, or give it a PCOMP.",
        )
    stack, *plies = layers
    head = [*owner.fields[:7], *[""] * 7][:7]
    rows = [text for ply in plies for text in (ply.text(1), ply.text(2), ply.text(3), "")]
    return Card(owner.name, (*head, stack.text(1), *rows), owner.where)


def _ply(stack: Card, i: int, plies: dict[str, Card]) -> Card:
    name = stack.text(i)
    if name.upper() in ("SUB", "INT"):
        raise InputError(
            f"STACK {stack.text(0)} has substacks ({name.upper()})",
            where=stack.place(i),
            expected="one row of plies from the bottom up",
            fix="Have the preprocessor write PCOMP or PCOMPG cards (realize the laminate by zones).",
        )
    if name not in plies:
        raise stack.wrong(i, "the number of a PLY that there is")
    if plies[name].text(6):
        raise InputError(
            f"PLY {name} is draped (DRAPE {plies[name].text(6)}): its thickness and angle vary from element to element",
            where=plies[name].where,
            expected="a ply of one thickness and angle",
            fix="Have the preprocessor write PCOMP or PCOMPG cards (realize the laminate by zones).",
        )
    return plies[name]


def _sets_of(ply: Card, sets: dict[int, list[range]]) -> list[int]:
    """Numbers of the element sets that a ply lies on."""
    fields = [i for i in range(ROW, len(ply.fields)) if ply.text(i)]
    for i in fields:
        if ply.integer(i) not in sets:
            raise ply.wrong(i, "a SET of TYPE ELEM and SUBTYPE LIST", "Add the set.")
    return [ply.integer(i) for i in fields]
