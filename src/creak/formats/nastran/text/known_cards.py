"""What each bulk data card means to creak: read, harmless to leave out, or changes the answer."""

from __future__ import annotations

from collections.abc import Collection

from creak.formats.deck.catalogue import Catalogue, Meaning, listed, misspelling
from creak.formats.nastran.text.case_control import SEQUENTIAL
from creak.formats.nastran.text.deck import BY_FREQUENCY, LINEAR, MODAL, Deck

_READ = {
    "": (
        "GRID, GRDSET, SPOINT, CORD1R, CORD1C, CORD1S, CORD2R, CORD2C, CORD2S, PARAM, MAT1, MAT2, MAT8, MAT9,"
        "PSHELL, PCOMP, PCOMPG, CQUAD4, CTRIA3, CQUADR, CTRIAR, CQUAD8, CTRIA6, CBAR,"
        "CBEAM, BAROR, BEAMOR, PBAR, PBARL, PBEAM,"
        "PBEAML, CROD, PROD, CONROD, CTUBE, PTUBE, CHEXA, CPENTA, CTETRA, PSOLID, CONM1, CONM2, CMASS1, CMASS2,"
        "CMASS3, CMASS4, PMASS, CELAS1, CELAS2, CELAS3, CELAS4, PELAS, CDAMP1, CDAMP2, CDAMP3, CDAMP4, PDAMP, CVISC,"
        "PVISC, CBUSH, PBUSH, RBE1, RBE2, RBE3, RBAR, RROD, MPC, MPCADD, SPC, SPC1, SPCADD, TIC, SUPORT, SUPORT1,"
        "ASET, ASET1, BSET, BSET1, CSET, CSET1, SET1, SET3, DMIG, ENDDATA,"
        "NSM, NSM1, NSML, NSML1, NSMADD, CWELD, PWELD, CFAST, PFAST, CBUSH1D, PBUSH1D, RBAR1, RSSCON,"
        "SET, SURF, TIE, CONTACT, PCOMPP, STACK, PLY, CPYRAM, CPYRA"
    ),
}

_AT_LARGE_STRAIN = "material laws at large strain; creak takes the elastic constants, which hold at small strain"
_SLIDE_LINES = "slide lines of grids have no surface; name the elements there in a study's [contact.NAME]"
_HARMLESS = {
    "creak finds the modes up to a frequency or a count of its own": "EIGR, EIGRL, EIGRA, EIGB, EIGC, EIGP, MODTRAK",
    "loads do not act on modes, and the study file defines the excitation": (
        "FORCE, FORCE1, FORCE2, MOMENT, MOMENT1, MOMENT2, PLOAD1, PLOADB3, RFORCE,"
        "RFORCE1, LOAD, SLOAD, DEFORM, DLOAD, DAREA, DELAY, DPHASE, TLOAD1, TLOAD2, RLOAD1, RLOAD2, ACSRCE, LSEQ,"
        "SPCD, SPCR, ACCEL, ACCEL1, LOADCYN, LOADCYH, TABLED1, TABLED2, TABLED3, TABLED4, TABLED5, TABLEH1, TABRND1,"
        "TABRNDG, RANDPS, RANDT1, RCROSS, NOLIN1, NOLIN2, NOLIN3, NOLIN4"
    ),
    "gravity does not act on modes; a study takes it from its [[static]] gravity or deck_loads": "GRAV",
    "pressure does not act on modes; a study takes it from its [[static]] deck_loads": "PLOAD, PLOAD2, PLOAD4",
    "the study file defines the time axis": (
        "TSTEP, TSTEPNL, TSTEP1, NLPARM, NLPCI, NLSTEP, NLADAPT, NLOUT, NLCNTL, NLCNTLG, NLCNTL2, FREQ, FREQ1,"
        "FREQ2, FREQ3, FREQ4, FREQ5, FREQV"
    ),
    "the study file defines reductions": (
        "QSET, QSET1, CSUPEXT, SEQSET, SEQSET1, SEBSET, SEBSET1, SECSET, SECSET1, SENQSET, EXTRN, SECONCT,"
        "SESET, SEELT, SEEXCLD, SELABEL, SELOC, SEUSET, SEUSET1, USET, USET1, SESUP, DYNRED, BNDFIX, BNDFIX1,"
        "BNDFREE, BNDFRE1"
    ),
    "temperatures load statics only, in a study's [[static]]; materials that depend on them are told apart": (
        "TEMP, TEMPD, TEMPP1, TEMPP3, TEMPRB, TEMPAX, TEMPBC, TEMPN1, TEMPF, TEMPG, TABLEM1, TABLEM2, TABLEM3,"
        "TABLEM4, TABLEST"
    ),
    "fluid elements, which alone use it, are told apart": "ACMODL, ACSRCE1, PANEL, SLBDY",
    "they act only where the case control takes MFLUID, which is told apart": "ELIST, MFLUID",
    "creak has no heat": (
        "MAT4, MAT5, MATT4, MATT5, CHBDYE, CHBDYG, CHBDYP, PHBDY, CONV, CONVM, PCONV, PCONVM, QBDY1, QBDY2, QBDY3,"
        "QHBDY, QVOL, QVECT, RADM, RADMT, RADBC, RADSET, RADLST, RADMTX, VIEW, VIEW3D, BDYOR"
    ),
    "creak has no air forces": (
        "AERO, AEROS, AEFACT, AELIST, AELISTC, AELINK, AEPARM, AESTAT, AESURF, AESURFS, AECOMP, AECOMPL, AEGRID,"
        "AEQUAD, AETRIA, AEDW, AEFORCE, AEPRESS, AESCALE, CAERO1, CAERO2, CAERO3, CAERO4, CAERO5, CAERO6, PAERO1,"
        "PAERO2, PAERO3, PAERO4, PAERO5, SPLINE1, SPLINE2, SPLINE3, SPLINE4, SPLINE5, SPLINE6, SPLINE7, SPLINEX,"
        "SPLINRB, SPBLND1, SPBLND2, SPRELAX, PANLST1, PANLST2, PANLST3, FLFACT, FLUTTER, MKAERO1,"
        " MKAERO2, TRIM, TRIM2, UXVEC, GUST, DIVERG, SET2, SET4, MONPNT1, MONPNT2, MONPNT3, MONDSP1, MONDSP2,"
        "MONSUM, MONSUM1, MONSUMT, MONCNCM, CSSCHD, SUPAX"
    ),
    "they act only where the case control takes TFL, which is told apart": "TF, EPOINT",
    _AT_LARGE_STRAIN: ("MATS1, MATEP, TABLES1, MATF, MATVP, CREEP, MATTEP, MATTF"),
    "modes have no damping, and a study has [damping]": "TABDMP1, DAMPING, HYBDAMP, DAMPGBL",
    "it draws or names only": (
        "PLOTEL, PLOTEL3, PLOTEL4, PLOTEL6, PLOTEL8, PLOTHEX, PLOTPEN, PLOTPYR, PLOTTET, PLOTG, GEOMIN, GMCURV, GMSURF,"
        "GMCORD, FEEDGE, FEFACE, DESC, YPARAM"
    ),
    "it asks for output, which the study file defines": "CBARAO, BOUTPUT, OUTRCV",
    "it orders the unknowns, which changes no answer": "SEQGP, SEQEP",
    "it controls the job, not the model": (
        "DTI, NASTRAN, ECHOON, ECHOOFF, SYSTEM, DMI, DMIJ, DMIK, DMIJI, TABLE3D, CORD3G, OMODES, BARPLOT,"
        "RVDOF, RVDOF1, MODSEL, MESH, PARAMARM, NXSTRAT, SWLDPRM, FBODYLD, FBODYSB, MEFF,"
        "DEBUG, PARVEC, PARVEC1"
    ),
    "the study file defines contact": (
        "BCTSET, BCTADD, BCTPARM, BCTPARA, BCONTACT, BCTABLE, BCTABL1, BCBODY, BCBODY1, BCPARA,"
        "BSURF, BSURFS, BCPROP, BCPROPS, BCRPARA, BCONPRG, BCONPRP, BCONECT, BCBDPRP, BCRIGID, BCRGSRF,"
        "PCONT, PCONTX, CONTPRM, BEDGE, BGSET, BGADD, BGPARM, BCGRID, BCAUTOP, BCPATCH, BCBZIER, BCNURBS"
    ),
    _SLIDE_LINES: "BCONP, BFRIC, BLSEG, BWIDTH",
    "it is for design only": (
        "DESVAR, DRESP1, DRESP2, DRESP3, DCONSTR, DCONADD, DVPREL1, DVPREL2, DVMREL1, DVMREL2, DVCREL1, DVCREL2,"
        "DVGRID, DVSHAP, DVBSHAP, DOPTPRM, DOBJ, DTABLE, DTABLE2, DEQATN, DLINK, DSCREEN, DDVAL, TOPVAR, TOMVAR,"
        "BEADVAR, DVPSURF, BNDGRID, DRESP4, DVLREL1, DTPL, DSIZE, DSHAPE, DTPG, DCOMP, DREPORT, DREPADD, DGLOBAL,"
        "TOPDISC, OSDIAG, DLINK2, DSYM, DSCONS, DVSET, DVAR, BMFACE, BLDOUT"
    ),
}

_CHANGES = {
    "creak does not read this element": (
        "CQUAD, CTRIA, CSHEAR, PSHEAR, CBEND, PBEND, "
        "CSEAM, PSEAM, GENEL, CHACAB, CHACBR, PACABS, CAABSF, PAABSF, CRAC2D, CRAC3D, CTRIAX6, CQUADX,"
        "CTRIAX, CHEXAL, PCOMPS, PCOMPLS, PBCOMP, PBRSECT, PBMSECT, PLPLANE, PLSOLID, CDAMP5, CBEAM3, PBEAM3,"
        "CIFHEX, CIFPENT, CGAPG, RBODY, JOINTG, PJOINTG, CMBEAM, CSMSPH, CNTNLSUB"
    ),
    "creak does not read this constraint": (
        "RBE2GS, RSPLINE, RTRPLT, RTRPLT1, RJOINT, SPCAX, MPCAX, SPCOFF, SPCOFF1, BLTMPC"
    ),
    "a bolt's preload stresses the structure, which creak leaves out": (
        "BOLT, BOLTFOR, BOLTFRC, BOLTLD, BOLTSEQ, PRETENS, PTFORCE, PTADJST"
    ),
    "creak does not read this material": "MAT3, MAT10, MAT11, MATHE, MATHP, MATVE, MATORT, MATSMA, MATDIGI",
    "creak's shells have the normals of their own geometry": "SNORM",
    "give it as a superelement in the study": "DMIAX, RELEASE, SEMPLN, CSUPER, SEBULK",
}


_TABLES_OF = {"PBUSHT": "PBUSH", "PELAST": "PELAS", "PDAMPT": "PDAMP"}
_DEPENDS = {
    "its meaning hangs on the analysis": (
        "OMIT, OMIT1, PSET, PVAL, MDLPRM, MATT1, MATT2, MATT3, MATT8, MATT9, MATT11, PBUSHT, PELAST, PDAMPT, CGAP, PGAP"
    )
}
READ, HARMLESS, CHANGES = listed("read", _READ), listed("harmless", _HARMLESS), listed("changes", _CHANGES)
CARDS = Catalogue("card", {**READ, **HARMLESS, **CHANGES, **listed("depends", _DEPENDS)})
_PARAMS_READ = {"WTMASS", "COUPMASS", "W3", "W4", "G", "ALPHA1", "ALPHA2", "CK2", "CM2", "CB2"}
_PARAMS_ALIKE = {"ALPHA1FL", "ALPHA2FL", "INRLM"}
"""Parameters that are spelled like another one and that bear on fluids and rigid motion."""
_PARAMS_HARMLESS = {
    "K6ROT": "creak's shells have a drilling stiffness of their own",
    "AUTOSPC": "creak leaves out dofs without stiffness and mass",
    "GRDPNT": "creak prints the mass by itself",
    "SNORM": "creak's shells have the normals of their own geometry",
    "LMODES": "creak keeps the modes that the study asks for",
    "LFREQ": "creak keeps the modes that the study asks for",
    "HFREQ": "creak keeps the modes that the study asks for",
    "KDAMP": "modes have no damping, and a study has [damping]",
    "LGDISP": "creak's structure is linear: the answer holds for small motion about the undeformed state",
}
_OWN_CONTACT = "SOL 129 has this contact; creak's own run has gaps (CGAP) alone"
_RUN_CHANGES = {
    _AT_LARGE_STRAIN: "SOL 129 follows this material law at large strain; creak's run is elastic",
    "the study file defines contact": _OWN_CONTACT,
    _SLIDE_LINES: _OWN_CONTACT,
}
"""What cards mean that are harmless but for the deck's own nonlinear run."""
_FORMULATION = ("OFFDEF", "SHEARP", "QRSHEAR")
"""Keys of MDLPRM that change elements."""
_PARAMS_CHANGE = {
    *("TSTATIC", "CB1", "CK1", "CK3", "CM1", "CP1", "CP2", "CK41", "CK42", "FRQDEP", "INREL", "FOLLOWK"),
}


def list_unread(deck: Deck, also_read: Collection[str] = (), *, own_run: bool = False) -> None:
    """List every card that is not read, and PARAM cards that bear on the answer.

    Parameters
    ----------
    also_read : cards that are used beyond those of the model.
    own_run : whether the deck's own analysis is run.
    """
    for name, cards in deck.by_name.items():
        if name in also_read:
            continue
        known = _where_it_acts(deck, name, own_run) or CARDS.meaning(name)
        if known.role != "read":
            deck.note(cards[0], _count(known.why, len(cards)), changes=known.changes_answer, what=name)
    for name, card in deck.params.items():
        if name == "LGDISP" and own_run and deck.case.solution in SEQUENTIAL and deck.param(name, -1.0) > 0.0:
            deck.note(card, "creak's structure is linear", changes=True, what=f"PARAM,{name}")
        elif name in _PARAMS_HARMLESS:
            deck.note(card, _PARAMS_HARMLESS[name], changes=False, what=f"PARAM,{name}")
        elif name in _PARAMS_CHANGE:
            deck.note(card, "creak does not follow this parameter", changes=True, what=f"PARAM,{name}")
    others = [name for name in deck.params if name not in _PARAMS_READ | _PARAMS_HARMLESS.keys() | _PARAMS_CHANGE]
    for name in others:
        meant = misspelling(name, _PARAMS_READ | _PARAMS_CHANGE, _PARAMS_ALIKE)
        if meant:
            deck.note(deck.params[name], meant, changes=True, what=f"PARAM,{name}")
    if others:
        why = f"the study file defines analysis and output ({', '.join(sorted(others))})"
        deck.note(deck.params[others[0]], why, changes=False)


def _where_it_acts(deck: Deck, name: str, own_run: bool) -> Meaning | None:
    """What a card means whose meaning hangs on the analysis that the deck asks for."""
    case = deck.case
    if name in _CONDENSED:
        if case.solution in MODAL and not _WITH_MODES & deck.by_name.keys() and "EXTSEOUT" not in case.commands:
            kind = name.rstrip("1") if name[0] in "BC" else "ASET"
            why = f"Nastran condenses the mass to the dofs of {kind} (Guyan); creak keeps all dofs: lower frequencies"
            return Meaning("changes", why)
        return None if name in READ else Meaning("harmless", "the study file defines reductions")
    if name == "SESET" and case.solution in MODAL and not _WITH_MODES & deck.by_name.keys():
        why = "Nastran condenses the mass inside superelements (Guyan); creak keeps all dofs: lower frequencies"
        return Meaning("changes", why)
    if name in _AT_TEMPERATURE:
        if "TEMPERATURE" in case.commands:
            why = "the material differs at the TEMPERATURE of the case control; creak takes MAT1, MAT8 as they are"
            return Meaning("changes", why)
        return Meaning("harmless", "the case control takes no TEMPERATURE, so the material is that of its card")
    if name in _TABLES_OF:
        values = f"the nominal values of {_TABLES_OF[name]}"
        if case.solution in BY_FREQUENCY:
            return Meaning("harmless", f"{values} hold at every frequency; Nastran's response follows the tables")
        if case.solution in LINEAR:
            return Meaning("harmless", f"the solution is linear: {values} hold, as in Nastran")
        return Meaning("changes", f"creak takes {values} at every displacement and frequency")
    if name in ("PSET", "PVAL"):
        why = "the case control takes no ADAPT, so elements have the order of their cards"
        return Meaning(*(("changes", "creak has no p-elements") if "ADAPT" in case.commands else ("harmless", why)))
    if name == "MDLPRM":
        keys = {text.upper() for card in deck.cards(name) for text in card.fields[::2]} & {*_FORMULATION}
        why = f"creak does not follow {', '.join(sorted(keys))}" if keys else "it controls the job, not the model"
        return Meaning("changes" if keys else "harmless", why)
    if case.solution in SEQUENTIAL and (why := CARDS.meaning(name).why) in _RUN_CHANGES:
        asks = f"{why} (a run of the deck's own SOL {case.solution} asks for --ignore '{name}')"
        return Meaning("changes", _RUN_CHANGES[why]) if own_run else Meaning("harmless", asks)
    if case.solution and CARDS.meaning(name).why == _AT_LARGE_STRAIN:
        if case.solution in LINEAR:
            return Meaning("harmless", "the solution is linear: the elastic constants hold, as in Nastran")
        return Meaning("harmless", f"SOL {case.solution} follows {_AT_LARGE_STRAIN}")
    if own_run and name in ("EIGRL", "EIGR"):
        return Meaning("harmless", "creak runs in all dofs, or in as many modes as the answer takes")
    if name in ("SUPORT", "SUPORT1"):
        why = (
            "it holds nothing in a dynamic analysis: creak finds rigid motion by itself (its grids are the set SUPORT)"
        )
        return Meaning("harmless", why)
    if name == "TABDMP1" and own_run and "SDAMPING" in case.commands:
        why = (
            "creak's own run takes damping of modes in SOL 112 alone, from 0 to below critical: G or CRIT over rising "
            "frequencies, or Q of one value; write a study with [damping]"
        )
        return Meaning("changes", why)
    return None


_CONDENSED = ("ASET", "ASET1", "BSET", "BSET1", "CSET", "CSET1", "OMIT", "OMIT1")
_WITH_MODES = {"QSET", "QSET1", "SEQSET", "SEQSET1"}
"""Cards for modes of what is condensed: it is then as good as whole."""
_AT_TEMPERATURE = ("MATT1", "MATT2", "MATT3", "MATT8", "MATT9", "MATT11")


def _count(why: str, n: int) -> str:
    return why if n == 1 else f"{why} ({n} cards)"
