"""What each Abaqus keyword means to creak: read, harmless to leave out, or changes the answer."""

from __future__ import annotations

from collections.abc import Iterable

from creak.formats.abaqus.lexer import Block, squeeze
from creak.formats.deck.catalogue import Catalogue, Meaning, listed


def _read(params: str = "", under: str = "") -> Meaning:
    """Parameters that creak reads or that cannot change the answer, and what the keyword is an option of."""
    owners = tuple(name.strip() for name in under.split(",") if name)
    return Meaning("read", params=frozenset(squeeze(p) for p in params.split(",") if p), owners=owners)


_READ: dict[str, Meaning] = {
    "HEADING": _read("SPARSE, UNSYMM"),
    "NODE": _read("NSET, SYSTEM"),
    "ELEMENT": _read("TYPE, ELSET"),
    "NSET": _read("NSET, GENERATE, UNSORTED, INSTANCE, ELSET, INTERNAL"),
    "ELSET": _read("ELSET, GENERATE, UNSORTED, INSTANCE, INTERNAL"),
    "SURFACE": _read("NAME, TYPE, INTERNAL, NO THICK, NO OFFSET, REGION TYPE, DEFINITION"),
    "SHELL SECTION": _read(
        "ELSET, MATERIAL, COMPOSITE, OFFSET, NODAL THICKNESS, SECTION INTEGRATION, POISSON, CONTROLS,"
        "SHELL THICKNESS, TEMPERATURE, ORIENTATION, STACK DIRECTION, SYMMETRIC, LAYUP"
    ),
    "SHELL GENERAL SECTION": _read(
        "ELSET, MATERIAL, COMPOSITE, OFFSET, NODAL THICKNESS, POISSON, CONTROLS, SHELL THICKNESS, ORIENTATION,"
        "STACK DIRECTION, SYMMETRIC, LAYUP, DENSITY, ZERO"
    ),
    "TRANSVERSE SHEAR STIFFNESS": _read("", "SHELL SECTION, SHELL GENERAL SECTION, BEAM SECTION, BEAM GENERAL SECTION"),
    "NODAL THICKNESS": _read("GENERATE"),
    "BEAM SECTION": _read("ELSET, MATERIAL, SECTION, TEMPERATURE, POISSON, LUMPED, ROTARY INERTIA"),
    "BEAM GENERAL SECTION": _read("ELSET, SECTION, DENSITY, POISSON, ZERO, LUMPED, ROTARY INERTIA"),
    "CENTROID": _read("", "BEAM GENERAL SECTION"),
    "SHEAR CENTER": _read("", "BEAM GENERAL SECTION"),
    "ORIENTATION": _read("NAME, SYSTEM, DEFINITION"),
    "TRANSFORM": _read("NSET, TYPE"),
    "SYSTEM": _read(""),
    "NONSTRUCTURAL MASS": _read("ELSET, UNITS, DISTRIBUTION"),
    "DISTRIBUTING COUPLING": _read("ELSET"),
    "CONNECTOR SECTION": _read("ELSET, BEHAVIOR"),
    "CONNECTOR BEHAVIOR": _read("NAME, INTEGRATION"),
    "CONNECTOR ELASTICITY": _read("COMPONENT, RIGID, NONLINEAR", "CONNECTOR BEHAVIOR"),
    "CONNECTOR DAMPING": _read("COMPONENT, TYPE, NONLINEAR", "CONNECTOR BEHAVIOR"),
    "CONNECTOR CONSTITUTIVE REFERENCE": _read("", "CONNECTOR BEHAVIOR"),
    "SOLID SECTION": _read("ELSET, MATERIAL, CONTROLS, REF NODE, ORIENTATION, COMPOSITE, SYMMETRIC, LAYUP"),
    "MEMBRANE SECTION": _read("ELSET, MATERIAL, NODAL THICKNESS, ORIENTATION, POISSON, CONTROLS"),
    "COHESIVE SECTION": _read("ELSET, MATERIAL, RESPONSE, THICKNESS, CONTROLS, STACK DIRECTION"),
    "DISTRIBUTION": _read("NAME, LOCATION, TABLE"),
    "DISTRIBUTION TABLE": _read("NAME"),
    "DISPLAY BODY": _read("INSTANCE"),
    "MASS": _read("ELSET, ALPHA, COMPOSITE, TYPE, ORIENTATION"),
    "ROTARY INERTIA": _read("ELSET, ALPHA, COMPOSITE, ORIENTATION"),
    "SPRING": _read("ELSET, NONLINEAR, COMPLEX STIFFNESS, ORIENTATION"),
    "DASHPOT": _read("ELSET, NONLINEAR, ORIENTATION"),
    "MATERIAL": _read("NAME, DESCRIPTION, RTOL, SRATE FACTOR, STRAIN RATE REGULARIZATION"),
    "ELASTIC": _read("TYPE, MODULI, DEPENDENCIES", "MATERIAL"),
    "HYPERELASTIC": _read(
        "NEO HOOKE, MOONEY-RIVLIN, YEOH, REDUCED POLYNOMIAL, POLYNOMIAL, OGDEN, ARRUDA-BOYCE, VAN DER WAALS, N, MODULI,"
        "TEST DATA INPUT, USER, POISSON, BETA, PROPERTIES, TYPE, MARLOW, VALANIS-LANDEL",
        "MATERIAL",
    ),
    "HYPERFOAM": _read("N, MODULI, POISSON, TEST DATA INPUT", "MATERIAL"),
    "DENSITY": _read("DEPENDENCIES", "MATERIAL"),
    "DAMPING": _read("ALPHA, BETA, COMPOSITE", "MATERIAL"),
    "COUPLING": _read("CONSTRAINT NAME, REF NODE, SURFACE, ORIENTATION, INFLUENCE RADIUS"),
    "KINEMATIC": _read("", "COUPLING"),
    "DISTRIBUTING": _read("WEIGHTING METHOD, COUPLING", "COUPLING"),
    "KINEMATIC COUPLING": _read("REF NODE, ORIENTATION"),
    "RIGID BODY": _read("REF NODE, TIE NSET, PIN NSET, ELSET, POSITION"),
    "TIE": _read("NAME, POSITION TOLERANCE, TIED NSET, ADJUST, NO ROTATION, NO THICKNESS, TYPE"),
    "MPC": _read("MODE"),
    "EQUATION": _read(""),
    "BOUNDARY": _read("OP, TYPE, AMPLITUDE, REGION TYPE"),
    "INITIAL CONDITIONS": _read("TYPE"),
    "PARAMETER": _read(),
    "PART": _read("NAME"),
    "END PART": _read(),
    "ASSEMBLY": _read("NAME"),
    "END ASSEMBLY": _read(),
    "INSTANCE": _read("NAME, PART"),
    "END INSTANCE": _read(),
    "STEP": _read(),
    "END STEP": _read(),
}

_HARMLESS = {
    "the study file defines contact": (
        "CONTACT PAIR, CONTACT, CONTACT INCLUSIONS, CONTACT EXCLUSIONS, CONTACT PROPERTY ASSIGNMENT,"
        "CONTACT FORMULATION, CONTACT INITIALIZATION DATA, CONTACT INITIALIZATION ASSIGNMENT,"
        "CONTACT CONTROLS, CONTACT CONTROLS ASSIGNMENT, CONTACT STABILIZATION, CONTACT DAMPING,"
        "CONTACT INTERFERENCE, SURFACE INTERACTION, SURFACE BEHAVIOR, SURFACE PROPERTY ASSIGNMENT,"
        "FRICTION, CHANGE FRICTION, CLEARANCE, GAP CONDUCTANCE, GAP HEAT GENERATION"
    ),
    "the study file defines the excitation": "AMPLITUDE",
    "it asks for output, which the study file defines": (
        "OUTPUT, NODE OUTPUT, ELEMENT OUTPUT, CONTACT OUTPUT, ENERGY OUTPUT, MODAL OUTPUT, NODE PRINT,"
        "EL PRINT, NODE FILE, EL FILE, CONTACT PRINT, CONTACT FILE, ENERGY PRINT, ENERGY FILE, FILE FORMAT,"
        "MONITOR, TIME POINTS, FILTER, INTEGRATED OUTPUT, INTEGRATED OUTPUT SECTION, PRINT, FILE OUTPUT,"
        "SECTION PRINT, SECTION FILE, MODAL FILE, MODAL PRINT, INCREMENTATION OUTPUT, INTERACTION OUTPUT,"
        "INTERACTION PRINT, INTERACTION FILE, RADIATION OUTPUT, RADIATION PRINT, RADIATION FILE, SURFACE OUTPUT,"
        "ELEMENT MATRIX OUTPUT, DESIGN RESPONSE, POST OUTPUT, CFILE, TRACER PARTICLE"
    ),
    "it controls the job, not the model": (
        "PREPRINT, RESTART, DIAGNOSTICS, WAVEFRONT MINIMIZATION, PHYSICAL CONSTANTS, CONSTRAINT CONTROLS,"
        "SOLUTION TECHNIQUE, SOLVER CONTROLS, CONTROLS, PARAMETER DEPENDENCE, USER DEFINED FIELD, DEPVAR,"
        "USER SUBROUTINE, DESIGN PARAMETER, VALUES AT INFINITY"
    ),
    "plastic, creeping or breaking at large strain; creak takes the elastic constants, which hold at small strain": (
        "PLASTIC, CREEP, RATE DEPENDENT, CYCLIC HARDENING, POTENTIAL, ANNEAL TEMPERATURE, SWELLING, TENSILE FAILURE,"
        "SHEAR FAILURE, DAMAGE INITIATION, DAMAGE EVOLUTION, DAMAGE STABILIZATION, FAIL STRESS, FAIL STRAIN, ORNL,"
        "CYCLED PLASTIC, TENSION STIFFENING, TENSION CUTOFF, DRUCKER PRAGER, DRUCKER PRAGER HARDENING, MOHR COULOMB,"
        "MOHR COULOMB HARDENING, CAP PLASTICITY, CAP HARDENING, CRUSHABLE FOAM, CRUSHABLE FOAM HARDENING,"
        "CONCRETE DAMAGED PLASTICITY, CONCRETE COMPRESSION HARDENING, CONCRETE TENSION STIFFENING, MULLINS EFFECT"
    ),
    "creak's elements have no hourglass modes to control": "SECTION CONTROLS, HOURGLASS STIFFNESS",
    "creak has no heat": (
        "EXPANSION, CONDUCTIVITY, SPECIFIC HEAT, LATENT HEAT, INELASTIC HEAT FRACTION, JOULE HEAT FRACTION,"
        "ELECTRICAL CONDUCTIVITY, FILM PROPERTY, EMISSIVITY, SURFACE PROPERTY, HEAT GENERATION, DIELECTRIC,"
        "DIFFUSIVITY, SOLUBILITY, FLUID CONSTANTS, SPECIFIC GAS CONSTANT"
    ),
}

_CHANGES = {
    "creak does not read this joint": "SHELL TO SOLID COUPLING, EMBEDDED ELEMENT, FASTENER",
    "creak does not read added mass": "BEAM ADDED INERTIA",
    "loads are read from the study's [excitation], not from model data": "CLOAD, DLOAD, DSLOAD",
    "creak does not generate nodes or elements; write them out": "NGEN, NFILL, NCOPY, NMAP, ELGEN, ELCOPY",
    "creak's materials are linear elastic": (
        "VISCOELASTIC, NO COMPRESSION, NO TENSION, TRANSVERSE SHEAR, HYPOELASTIC, DEFORMATION PLASTICITY,"
        "LOW DENSITY FOAM, FABRIC, HYSTERESIS, USER MATERIAL, POROUS ELASTIC, MULLINS, SUPERELASTIC, EOS"
    ),
    "creak does not read this kind of section": ("GASKET SECTION, JOINT, GAP, PRE-TENSION SECTION, SURFACE SECTION"),
    "creak does not read this constraint": "RELEASE",
    "creak does not read this extension of the model": (
        "USER ELEMENT, UEL PROPERTY, MATRIX INPUT, MATRIX ASSEMBLE, SUBSTRUCTURE PROPERTY, IMPORT,"
        "IMPERFECTION, NORMAL, INERTIA RELIEF"
    ),
}


_OF_STEPS = (
    "STATIC, DYNAMIC, FREQUENCY, MODAL DYNAMIC, STEADY STATE DYNAMICS, RANDOM RESPONSE, RESPONSE SPECTRUM, BUCKLE,"
    "COMPLEX FREQUENCY, VISCO, HEAT TRANSFER, COUPLED TEMPERATURE-DISPLACEMENT, SUBSTRUCTURE GENERATE, MATRIX GENERATE,"
    "ANNEAL, GREEN, MODAL, NO ANALYSIS, SELECT EIGENMODES, MODAL DAMPING, BASE MOTION, TEMPERATURE, FIELD,"
    "MODEL CHANGE, CFLUX, DFLUX, FILM, RADIATE, CONNECTOR LOAD, CONNECTOR MOTION, SUBSTRUCTURE LOAD CASE, LOAD CASE,"
    "END LOAD CASE"
)
"""Keywords that stand in steps."""


KEYWORDS = Catalogue(
    "keyword",
    {
        **listed("harmless", _HARMLESS),
        **listed("changes", {"it belongs into a *STEP": _OF_STEPS}),
        **listed("changes", _CHANGES),
        **_READ,
    },
)
"""By the keyword without star, single blanks."""

_SPELLED = {squeeze(name): name for name in KEYWORDS.known}


def canonical(name: str) -> str:
    """The keyword as the table spells it; unknown ones are returned as they are."""
    return _SPELLED.get(squeeze(name), name)


def meaning(name: str) -> Meaning:
    """What a keyword means to creak; an unknown one may change the answer."""
    name = canonical(name)
    if _of_connectors(name):
        return Meaning("changes", "creak reads *CONNECTOR SECTION, BEHAVIOR, ELASTICITY and DAMPING")
    return KEYWORDS.meaning(name)


def _of_connectors(name: str) -> bool:
    return name.startswith("CONNECTOR") and name not in KEYWORDS.known


def misspelled(blocks: Iterable[Block]) -> str:
    """Hint at the first keyword that looks like a misspelling; empty without one."""
    named = ((canonical(b.name), f"*{b.name}", b.where) for b in blocks)
    return KEYWORDS.misspelled(n for n in named if not _of_connectors(n[0]))
