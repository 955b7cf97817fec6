"""*HYPERELASTIC and *HYPERFOAM about the undeformed state: the isotropic material of small strain."""

from __future__ import annotations

from creak.formats.abaqus.text.fields import to_float
from creak.formats.abaqus.text.lexer import Block

INCOMPRESSIBLE = 0.4995
"""Poisson's ratio of a rubber without compressibility (D = 0); Abaqus takes such in hybrid elements only."""
_FORMS = {
    "NEO HOOKE": 1,
    "MOONEY-RIVLIN": 2,
    "YEOH": 3,
    "REDUCED POLYNOMIAL": 0,
    "POLYNOMIAL": 0,
    "OGDEN": 0,
    "ARRUDA-BOYCE": 2,
    "VAN DER WAALS": 4,
}
"""Kind of energy -> number of its constants before D; 0: by N."""


def small_strain(name: str, option: Block) -> tuple[float, float]:
    """E and nu at zero strain.

    mu = 2 (C10 + C01) of polynomials, sum mu_i of Ogden's and foam's energy, mu of van der Waals, and
    mu (1 + 3/(5 l^2) + 99/(175 l^4) + 513/(875 l^6) + 42039/(67375 l^8)) of Arruda and Boyce with locking stretch l.
    K = 2/D1; of foam sum 2 mu_i (1/3 + nu_i/(1 - 2 nu_i)).

    Raises
    ------
    InputError : an unknown energy, test data, a temperature, constants of no stable material.
    """
    if any(option.has(p) for p in ("TEST DATA INPUT", "USER", "MARLOW", "VALANIS-LANDEL")):
        raise option.error(
            f"*{option.name} of material {name!r} has no constants",
            expected="the constants of the energy",
            fix="Write the constants that a fit of the test data gave, or *ELASTIC.",
        )
    rows = list(option.rows(blanks=True))
    values = [
        to_float(f, where, f"constant of material {name!r}") for fields, where in rows for f in _padded(fields, rows)
    ]
    order = _order(option)
    shear, bulk = _foam(option, values, order) if option.name == "HYPERFOAM" else _solid(name, option, values, order)
    nu = INCOMPRESSIBLE
    if bulk is not None:
        nu = (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear)) if 3.0 * bulk + shear else -1.0
    if not shear > 0.0 or not -1.0 < nu < 0.5:
        raise option.error(
            f"*{option.name} of material {name!r} has the shear modulus {shear:g} and nu = {nu:g} at zero strain",
            expected="a positive modulus and -1 < nu < 0.5",
            fix="Check its constants.",
        )
    nu = min(nu, INCOMPRESSIBLE)
    return 2.0 * shear * (1.0 + nu), nu


def _order(option: Block) -> int:
    """N, the number of terms."""
    text = option.get("N", "1")
    if text not in ("1", "2", "3", "4", "5", "6"):
        raise option.error(f"*{option.name} has N={text}", expected="1 to 6", fix="Correct it.")
    return int(text)


def _padded(fields: list[str], rows: list[tuple[list[str], str]]) -> list[str]:
    return [*fields, *[""] * 8][:8] if len(rows) > 1 else fields


def _solid(name: str, option: Block, values: list[float], order: int) -> tuple[float, float | None]:
    kind = next((k for k in _FORMS if option.has(k)), "POLYNOMIAL")
    if kind in ("REDUCED POLYNOMIAL", "OGDEN"):
        count = order if kind == "REDUCED POLYNOMIAL" else 2 * order
    else:
        count = _FORMS[kind] or order * (order + 3) // 2
    v = [*values, *[0.0] * (count + 1)]
    shear = {
        "OGDEN": sum(v[0 : 2 * order : 2]),
        "POLYNOMIAL": 2.0 * (v[0] + v[1]),
        "MOONEY-RIVLIN": 2.0 * (v[0] + v[1]),
        "VAN DER WAALS": v[0],
    }.get(kind, 2.0 * v[0])
    if kind == "ARRUDA-BOYCE":
        if not v[1] > 0.0:
            raise option.error(
                f"*{option.name} of material {name!r} has the locking stretch {v[1]:g}",
                expected="more than zero",
                fix="Correct it.",
            )
        t = 1.0 / v[1] ** 2
        shear = v[0] * (1.0 + 3.0 / 5.0 * t + 99.0 / 175.0 * t**2 + 513.0 / 875.0 * t**3 + 42039.0 / 67375.0 * t**4)
    return shear, 2.0 / v[count] if v[count] else None


def _foam(option: Block, values: list[float], order: int) -> tuple[float, float]:
    v = [*values, *[0.0] * (3 * order)]
    mu, nu = v[0 : 2 * order : 2], v[2 * order : 3 * order]
    if option.has("POISSON"):
        nu = [to_float(option.get("POISSON"), option.where, "POISSON")] * order
    if any(n >= 0.5 for n in nu):
        return sum(mu), -1.0
    return sum(mu), sum(2.0 * m * (1.0 / 3.0 + n / (1.0 - 2.0 * n)) for m, n in zip(mu, nu, strict=True))
