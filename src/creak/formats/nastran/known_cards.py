"""What each bulk data card means to creak: read, harmless to leave out, or changes the answer."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from creak.errors import suggest
from creak.formats.nastran.bulk_data import Card
from creak.formats.nastran.deck import Deck

_READ = {
    "": (
        "GRID, GRDSET, SPOINT, CORD1R, CORD1C, CORD1S, CORD2R, CORD2C, CORD2S, PARAM,"
        "MAT1, MAT2, MAT8, MAT9, PSHELL, PCOMP, PCOMPG, CQUAD4, CTRIA3, CQUADR, CTRIAR,"
        "CBAR, CBEAM, BAROR, BEAMOR, PBAR, PBARL, PBEAM, PBEAML, CROD, PROD, CONROD, CTUBE, PTUBE,"
        "CHEXA, CPENTA, CTETRA, PSOLID, CONM1, CONM2, CMASS1, CMASS2, CMASS3, CMASS4, PMASS,"
        "CELAS1, CELAS2, CELAS3, CELAS4, PELAS, CDAMP1, CDAMP2, CDAMP3, CDAMP4, PDAMP, CVISC, PVISC, CBUSH, PBUSH,"
        "RBE1, RBE2, RBE3, RBAR, RROD, MPC, MPCADD, SPC, SPC1, SPCADD, TIC, SUPORT, SUPORT1,"
        "ASET, ASET1, BSET, BSET1, CSET, CSET1, SET1, SET3, DMIG, ENDDATA,"
        "NSM, NSM1, NSML, NSML1, NSMADD"
    ),
}

_HARMLESS = {
    "creak finds the modes up to a frequency or a count of its own": "EIGR, EIGRL, EIGB, EIGC, EIGP",
    "the study file defines the excitation": (
        "FORCE, FORCE1, FORCE2, MOMENT, MOMENT1, MOMENT2, PLOAD, PLOAD1, PLOAD2, PLOAD4, GRAV, RFORCE, LOAD, SLOAD,"
        "DLOAD, DAREA, DELAY, DPHASE, TLOAD1, TLOAD2, RLOAD1, RLOAD2, ACSRCE, LSEQ, SPCD, ACCEL, ACCEL1, SPCR,"
        "TABLED1, TABLED2, TABLED3, TABLED4, TABRND1, RANDPS, RANDT1"
    ),
    "the study file defines the time axis": "TSTEP, TSTEPNL, NLPARM, NLPCI, FREQ, FREQ1, FREQ2, FREQ3, FREQ4, FREQ5",
    "the study file defines reductions": (
        "QSET, QSET1, CSUPER, CSUPEXT, SEQSET, SEQSET1, SEBSET, SEBSET1, SENQSET, EXTRN, SECONCT, SEBULK,"
        "SESET, SEELT, SEEXCLD, SELABEL, SELOC, SEUSET, USET, USET1, OMIT, OMIT1"
    ),
    "creak has no temperatures": "TEMP, TEMPD, TEMPP1, TEMPRB, MAT4, MAT5, MATT1, MATT2, MATT8, MATT9, TABLEM1, CHBDYG",
    "it draws only": "PLOTEL, PLOTEL3, PLOTEL4, GEOMIN, PSET, PVAL",
    "it controls the job, not the model": "DTI, MDLPRM, NASTRAN, ECHOON, ECHOOFF, SYSTEM, DMI, TABLE3D, TOPVAR",
    "the study file defines contact": (
        "BCONP, BFRIC, BLSEG, BCTSET, BCTADD, BCTPARM, BCTPARA, BCONTACT, BCTABLE, BCTABL1, BCBODY, BCBODY1, BCPARA,"
        "BSURF, BSURFS, BCPROP, BCPROPS, BCRPARA, BWIDTH, BCONPRG, BCONPRP,"
        "BCONECT, BCBDPRP, BCRIGID, BCRGSRF, BSURFS, BEDGE, BGSET, BGADD, BGPARM"
    ),
    "it is for design only": (
        "DESVAR, DRESP1, DRESP2, DCONSTR, DCONADD, DVPREL1, DVPREL2, DVMREL1, DOPTPRM, DOBJ, DTABLE, DEQATN, DLINK"
    ),
}

_CHANGES = {
    "creak does not read this element": (
        "CQUAD8, CTRIA6, CQUAD, CTRIA, CPYRAM, CSHEAR, PSHEAR, CBEND, PBEND, CBUSH1D, PBUSH1D, CWELD,"
        "PWELD, CFAST, PFAST, CSEAM, PSEAM, GENEL, CHACAB, CRAC2D, CRAC3D, CTRIAX6, CQUADX, CTRIAX, CHEXAL, PCOMPS,"
        "PBCOMP, PBRSECT, PBMSECT, PLPLANE, PLSOLID, PBUSHT, PELAST, PDAMPT, CDAMP5, CBEAM3, CONV, CAERO1"
    ),
    "creak does not read this constraint": (
        "RBE2GS, RSPLINE, RSSCON, RTRPLT, RTRPLT1, RJOINT, RBAR1, TEMPAX, SPCAX, MPCAX, TF, EPOINT, SPCOFF, SPCOFF1,"
        "SESUP, BLTMPC"
    ),
    "creak's materials are linear elastic": "MATS1, TABLES1, MATEP",
    "creak does not read this material": "MAT3, MAT10, MAT11, MATHE, MATHP, MATVE, MATF, MATORT",
    "creak does not read tapered thickness": "SNORM",
    "modal damping: give [damping] in the study": "TABDMP1",
    "give it as a superelement in the study": "DMIAX, RELEASE, SEMPLN",
}


def _listed(groups: dict[str, str]) -> dict[str, str]:
    return {name.strip(): why for why, names in groups.items() for name in names.split(",")}


READ, HARMLESS, CHANGES = _listed(_READ).keys(), _listed(_HARMLESS), _listed(_CHANGES)
_WHY = {
    "SNORM": "creak's shells have the normals of their own geometry",
}
_PARAMS_READ = {"WTMASS", "COUPMASS", "W3", "W4", "G", "ALPHA1", "ALPHA2", "CK2", "CM2", "CB2"}
_PARAMS_HARMLESS = {
    "K6ROT": "creak's shells have a drilling stiffness of their own",
    "AUTOSPC": "creak leaves out dofs without stiffness and mass",
    "GRDPNT": "creak prints the mass by itself",
    "SNORM": "creak's shells have the normals of their own geometry",
}
_PARAMS_CHANGE = {
    "CB1",
    "CK1",
    "CK3",
    "CM1",
    "CP1",
    "CP2",
    "CK41",
    "CK42",
    "FRQDEP",
    "KDAMP",
    "LMODES",
    "INREL",
    "LGDISP",
    "FOLLOWK",
}


def list_unread(deck: Deck, also_read: Collection[str] = ()) -> None:
    """List every card that is not read, and PARAM cards that bear on the answer.

    Parameters
    ----------
    also_read : cards that are used beyond those of the model.
    """
    for name, cards in deck.by_name.items():
        if name in READ or name in also_read:
            continue
        if name in HARMLESS:
            deck.note(cards[0], _count(HARMLESS[name], len(cards)), changes=False)
        elif name in CHANGES:
            deck.note(cards[0], _count(_WHY.get(name, CHANGES[name]), len(cards)), changes=True)
        else:
            why = f"creak does not know this card. {_meant(name)}".removesuffix(". ")
            deck.note(cards[0], _count(why, len(cards)), changes=True, what=name)
    for name, card in deck.params.items():
        if name in _PARAMS_HARMLESS:
            deck.note(card, _PARAMS_HARMLESS[name], changes=False, what=f"PARAM,{name}")
        elif name in _PARAMS_CHANGE:
            deck.note(card, "creak does not follow this parameter", changes=True, what=f"PARAM,{name}")
    others = [name for name in deck.params if name not in _PARAMS_READ | _PARAMS_HARMLESS.keys() | _PARAMS_CHANGE]
    if others:
        why = f"the study file defines analysis and output ({', '.join(sorted(others))})"
        deck.note(deck.params[others[0]], why, changes=False)


def misspelled(cards: Iterable[Card]) -> str:
    """Hint at the first card that looks like a misspelling: it may have caused an error; empty without one."""
    first: dict[str, str] = {}
    for card in cards:
        first.setdefault(card.name, card.where)
    for name, where in first.items():
        if name not in READ and name not in HARMLESS and name not in CHANGES and (hint := _meant(name)):
            return f"Note that {name} at {where} is not a card that creak knows. {hint}"
    return ""


def _meant(name: str) -> str:
    """`Did you mean ...?` for an unknown card; empty where no known one is like it."""
    hint = suggest(name, READ | HARMLESS.keys() | CHANGES.keys())
    return hint if hint.startswith("Did you mean") else ""


def _count(why: str, n: int) -> str:
    return why if n == 1 else f"{why} ({n} cards)"
