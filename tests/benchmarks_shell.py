"""The classical shell obstacle course: each function returns computed / reference for one mesh."""

from __future__ import annotations

import numpy as np

from helpers_fem import Mesh, dof, frequencies, grid, rectangle, shell_section, solve

STRAIGHT = {"extension": 3.0e-5, "in-plane": 0.1081, "out-of-plane": 0.4321, "twist": 0.0341}
CURVED = {"in-plane": 0.08734, "out-of-plane": 0.5022}
TWISTED = {"in-plane": 0.0054245, "out-of-plane": 0.0017532}
ROOF, HEMISPHERE, CYLINDER, HOOK = 0.3024, 0.0940, 1.8248e-5, 4.963
"""Deflections under the load, from the publications; twist is St Venant's angle, the hook's that of 48 x 1 x 8 C3D20 in
CalculiX 2.20."""
FV12 = np.array([1.6217, 2.3595, 2.9223, 4.1902, 4.1902, 7.3560, 7.3560, 7.6682])
FV16 = np.array([0.4179, 1.0242, 2.5628, 3.2749, 3.7273, 6.5244])
FV32 = np.array([44.618, 130.013, 162.690, 245.990, 379.720, 391.408])
THICK = np.array([45.911, 109.528, 109.528, 168.073])
"""Frequencies, Hz: converged Ritz values; the thick plate's are exact in Mindlin's theory."""


def straight_beam(load: str, layout: str = "regular", kind: str = "quad") -> float:
    """MacNeal and Harder's 6 x 1 cantilever, 6 x 0.2 x 0.1, unit tip load."""
    mesh = rectangle(6, 1, 6.0, 0.2, kind)
    top = mesh.coords[:, 1] > 0.1
    inner = (mesh.coords[:, 0] > 0.1) & (mesh.coords[:, 0] < 5.9)
    row = np.rint(mesh.coords[:, 0]).astype(int)
    if layout == "trapezoid":
        mesh.coords[inner, 0] += np.where(top, 1, -1)[inner] * 0.1 * (-1.0) ** (row[inner] + 1)
    elif layout == "parallelogram":
        mesh.coords[inner, 0] += np.where(top, 0.1, -0.1)[inner]
    root, tip = mesh.nodes(lambda x: x[:, 0] < 1e-9), mesh.nodes(lambda x: x[:, 0] > 6 - 1e-9)
    held = dof(root, 1, 2, 3, 4, 5, 6)
    stiffness = mesh.stiffness(shell_section(0.1, 1e7, 0.3), held)
    force = np.zeros(mesh.n_dof)
    if load == "twist":
        force[dof(tip, 3)] = np.array([-5.0, 5.0])
    else:
        force[dof(tip, {"extension": 1, "in-plane": 2, "out-of-plane": 3}[load])] = 0.5
    u = solve(stiffness, force, held)
    if load == "twist":
        return float(u[dof(tip, 4)].mean() / STRAIGHT[load])
    at = {"extension": 1, "in-plane": 2, "out-of-plane": 3}[load]
    return float(u[dof(tip, at)].mean() / STRAIGHT[load])


def curved_beam(load: str, kind: str = "quad", n: int = 6, m: int = 1) -> float:
    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        radius, angle = 4.12 + 0.2 * eta, np.pi / 2 * (1 - xi)
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * xi])

    mesh = grid(n, m, shape, kind)
    mesh.elements = mesh.elements[:, ::-1]
    tip, root = mesh.nodes(lambda x: x[:, 1] < 1e-9), mesh.nodes(lambda x: x[:, 0] < 1e-9)
    at = {"in-plane": 1, "out-of-plane": 3}[load]
    share = np.array([0.5, *(m - 1) * [1.0], 0.5]) / m
    force = np.zeros(mesh.n_dof)
    force[dof(tip, at)] = share
    held = dof(root, 1, 2, 3, 4, 5, 6)
    u = solve(mesh.stiffness(shell_section(0.1, 1e7, 0.25), held), force, held)
    return float(u[dof(tip, at)] @ share / CURVED[load])


def twisted_beam(load: str, kind: str = "quad", n: int = 12, m: int = 2, thickness: float = 0.32) -> float:
    """Load along the tip's width ("in-plane") or normal to it ("out-of-plane")."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle, across = np.pi / 2 * xi, 1.1 * (eta - 0.5)
        return np.column_stack([12 * xi, across * np.cos(angle), across * np.sin(angle)])

    mesh = grid(n, m, shape, kind)
    tip, root = mesh.nodes(lambda x: x[:, 0] > 12 - 1e-9), mesh.nodes(lambda x: x[:, 0] < 1e-9)
    at = {"in-plane": 3, "out-of-plane": 2}[load]
    thin = {"in-plane": 5256.0, "out-of-plane": 1294.0}
    reference = (TWISTED if thickness == 0.32 else thin)[load]
    share = np.array([0.5, *(m - 1) * [1.0], 0.5]) / m
    force = np.zeros(mesh.n_dof)
    force[dof(tip, at)] = share
    held = dof(root, 1, 2, 3, 4, 5, 6)
    u = solve(mesh.stiffness(shell_section(thickness, 29e6, 0.22), held), force, held)
    return float(u[dof(tip, at)] @ share / reference)


def raasch_hook(n: int, m: int, kind: str = "quad") -> float:
    """Arcs of 60 and 150 degrees that bend to either side, radii 14 and 46, 20 wide and 2 thick; 1 across the tip."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        turn, back = np.pi / 3, np.pi / 6 * 5
        first = np.minimum(xi * (14.0 * turn + 46.0 * back) / 14.0, turn)
        second = (xi * (14.0 * turn + 46.0 * back) - 14.0 * first) / 46.0
        x = 14.0 - 60.0 * np.cos(first) + 46.0 * np.cos(first - second)
        y = 60.0 * np.sin(first) - 46.0 * np.sin(first - second)
        return np.column_stack([x, y, 20.0 * eta])

    mesh = grid(n, m, shape, kind)
    tip = np.arange(len(mesh.coords) - m - 1, len(mesh.coords))
    share = np.array([0.5, *(m - 1) * [1.0], 0.5]) / m
    force = np.zeros(mesh.n_dof)
    force[dof(tip, 3)] = share
    held = dof(np.arange(m + 1), 1, 2, 3, 4, 5, 6)
    u = solve(mesh.stiffness(shell_section(2.0, 3300.0, 0.35), held), force, held)
    return float(u[dof(tip, 3)] @ share / HOOK)


def scordelis_lo(n: int, kind: str = "quad") -> float:
    """Quarter of the roof, x along the axis from the mid-span, y across."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle = np.deg2rad(40.0) * eta
        return np.column_stack([25 * xi, 25 * np.sin(angle), 25 * np.cos(angle)])

    mesh = grid(n, n, shape, kind)
    weight = mesh.assemble(_shape_mass(mesh, 0.25))
    down = np.zeros(mesh.n_dof)
    down[2::6] = -90.0
    x, y = mesh.coords[:, 0], mesh.coords[:, 1]
    held = np.concatenate(
        [
            dof(np.flatnonzero(x > 25 - 1e-9), 2, 3),
            dof(np.flatnonzero(x < 1e-9), 1, 5, 6),
            dof(np.flatnonzero(y < 1e-9), 2, 4, 6),
        ]
    )
    stiffness = mesh.stiffness(shell_section(0.25, 4.32e8, 0.0), held)
    u = solve(stiffness, weight @ down, np.unique(held))
    corner = np.flatnonzero((x < 1e-9) & (y > y.max() - 1e-9))
    return float(-u[dof(corner, 3)][0] / ROOF)


def _shape_mass(mesh: Mesh, thickness: float) -> np.ndarray:
    return mesh.module.mass(mesh.coords[mesh.elements], shell_section(thickness, 1.0, 0.0, 1 / thickness))


def hemisphere(n: int, kind: str = "quad") -> float:
    """Quarter of the pinched hemisphere with an 18 degree hole."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        around, up = np.pi / 2 * xi, np.deg2rad(72.0) * eta
        return 10 * np.column_stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])

    mesh = grid(n, n, shape, kind)
    x, y, z = mesh.coords.T
    at_x = np.flatnonzero((y < 1e-9) & (z < 1e-9))
    at_y = np.flatnonzero((x < 1e-9) & (z < 1e-9))
    force = np.zeros(mesh.n_dof)
    force[dof(at_x, 1)], force[dof(at_y, 2)] = 1.0, -1.0
    held = np.concatenate(
        [
            dof(np.flatnonzero(y < 1e-9), 2, 4, 6),
            dof(np.flatnonzero(x < 1e-9), 1, 5, 6),
            dof(at_x, 3),
        ]
    )
    u = solve(mesh.stiffness(shell_section(0.04, 6.825e7, 0.3), held), force, np.unique(held))
    return float(u[dof(at_x, 1)][0] / HEMISPHERE)


def cylinder(n: int, kind: str = "quad") -> float:
    """Eighth of the pinched cylinder with end diaphragms."""

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        angle = np.pi / 2 * eta
        return np.column_stack([300 * xi, 300 * np.sin(angle), 300 * np.cos(angle)])

    mesh = grid(n, n, shape, kind)
    x, y, z = mesh.coords.T
    held = np.concatenate(
        [
            dof(np.flatnonzero(x > 300 - 1e-6), 2, 3),
            dof(np.flatnonzero(x < 1e-6), 1, 5, 6),
            dof(np.flatnonzero(y < 1e-6), 2, 4, 6),
            dof(np.flatnonzero(z < 1e-6), 3, 4, 5),
        ]
    )
    force = np.zeros(mesh.n_dof)
    under = np.flatnonzero((x < 1e-6) & (y < 1e-6))
    force[dof(under, 3)] = -0.25
    u = solve(mesh.stiffness(shell_section(3.0, 3e6, 0.3), held), force, np.unique(held))
    return float(-u[dof(under, 3)][0] / CYLINDER)


STEEL = {"youngs_modulus": 200e9, "poisson_ratio": 0.3, "density": 8000.0}


def plate_frequencies(mesh: Mesh, thickness: float, held: np.ndarray, count: int) -> np.ndarray:
    section = shell_section(thickness, **STEEL)
    return frequencies(mesh.stiffness(section, held), mesh.mass(section), held, count, -1.0)


def out_of_plane_only(mesh: Mesh) -> np.ndarray:
    return dof(np.arange(len(mesh.coords)), 1, 2, 6)


def free_plate(n: int, kind: str = "quad") -> np.ndarray:
    mesh = rectangle(n, n, 10.0, 10.0, kind)
    got = plate_frequencies(mesh, 0.05, out_of_plane_only(mesh), 11)[3:]
    return got / FV12


def cantilever_plate(n: int, kind: str = "quad") -> np.ndarray:
    mesh = rectangle(n, n, 10.0, 10.0, kind)
    root = mesh.nodes(lambda x: x[:, 0] < 1e-9)
    held = np.union1d(out_of_plane_only(mesh), dof(root, 3, 4, 5))
    got = plate_frequencies(mesh, 0.05, held, 6)
    return got / FV16


def tapered_membrane(n: int, m: int, kind: str = "quad") -> np.ndarray:
    """FV32: 10 long, 5 wide at the root and 1 at the tip; u and v are held at the root, drilling is not.

    The root shears, so its material turns in the plane: holding the drilling rotation would be a constraint
    that the reference does not have.
    """

    def shape(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
        return np.column_stack([10 * xi, (eta - 0.5) * (5 - 4 * xi), 0 * xi])

    mesh = grid(n, m, shape, kind)
    root = mesh.nodes(lambda x: x[:, 0] < 1e-9)
    bending = dof(np.arange(len(mesh.coords)), 3, 4, 5)
    got = plate_frequencies(mesh, 0.05, np.union1d(bending, dof(root, 1, 2)), 6)
    return got / FV32


def thick_plate(n: int, kind: str = "quad") -> np.ndarray:
    """Simply supported 10 x 10 x 1, hard supports: w and the tangential rotation are held."""
    mesh = rectangle(n, n, 10.0, 10.0, kind)
    x, y, _ = mesh.coords.T
    on_x = np.flatnonzero((x < 1e-9) | (x > 10 - 1e-9))
    on_y = np.flatnonzero((y < 1e-9) | (y > 10 - 1e-9))
    held = np.unique(np.concatenate([out_of_plane_only(mesh), dof(on_x, 3, 4), dof(on_y, 3, 5)]))
    got = plate_frequencies(mesh, 1.0, held, 4)
    return got / THICK


THIN_PLATES = {
    "FFFF": [13.4682, 19.5961, 24.2702, 34.8009, 34.8009],
    "CFFF": [3.471, 8.507, 21.285, 27.199, 30.956],
    "CCCC": [35.9852, 73.3938, 73.3938, 108.2165],
    "SSSS": [19.7392, 49.3480, 49.3480, 78.9568],
}
"""omega a^2 sqrt(rho h / D) of thin square plates, nu = 0.3: SSSS is exact, the others are converged Ritz values."""


def thin_plate(edges: str, n: int, kind: str = "quad", moved: float = 0.0) -> np.ndarray:
    """Square plate, thickness a / 1000; edges x = 0, y = 0, x = a, y = a free, clamped or (hard) simply supported.

    moved : inner corners of elements are moved at random by up to this share of an element; the sides stay straight.
    """
    mesh = rectangle(n, n, 10.0, 10.0, kind)
    if moved:
        _move_corners(mesh, moved * 10.0 / n)
    x, y, _ = mesh.coords.T
    held = [out_of_plane_only(mesh)]
    sides = [(x < 1e-9, 4), (y < 1e-9, 5), (x > 10 - 1e-9, 4), (y > 10 - 1e-9, 5)]
    for edge, (on, along) in zip(edges, sides, strict=True):
        held.append(dof(np.flatnonzero(on), *{"F": (), "C": (3, 4, 5), "S": (3, along)}[edge]))
    reference = np.array(THIN_PLATES[edges])
    rigid = 3 if edges == "FFFF" else 0
    got = plate_frequencies(mesh, 0.01, np.unique(np.concatenate(held)), reference.size + rigid)[rigid:]
    bending = STEEL["youngs_modulus"] * 0.01**3 / (12 * (1 - 0.3**2))
    return 2 * np.pi * got * 10.0**2 * np.sqrt(STEEL["density"] * 0.01 / bending) / reference


def _move_corners(mesh: Mesh, by: float) -> None:
    """Of elements with middle nodes: those inside the plate, by up to `by` in x and in y."""
    x, k = mesh.coords, mesh.elements.shape[1] // 2
    corners = np.unique(mesh.elements[:, :k])
    inner = corners[(np.abs(x[corners, :2] - 5.0) < 5.0 - 1e-9).all(axis=1)]
    x[inner, :2] += np.random.default_rng(1).uniform(-by, by, (inner.size, 2))
    ends = mesh.elements[:, :k], np.roll(mesh.elements[:, :k], -1, axis=1)
    x[mesh.elements[:, k:]] = 0.5 * (x[ends[0]] + x[ends[1]])


def fitted_slope(n: np.ndarray, values: np.ndarray) -> tuple[float, np.ndarray, float]:
    """p of values = limit + C n^-p: the slope of log(error) against log(h), h ~ 1/n, without a reference.

    Parameters
    ----------
    n : (n_mesh,) elements along a side. values : (n_mesh, n_value); one p for all, a limit and a C for each.

    Returns
    -------
    p between 0.2 and 6; (n_value,) limits; misfit, the rms residual over the rms change between the meshes.
    """
    n, values = np.asarray(n, dtype=float), np.asarray(values, dtype=float).reshape(len(n), -1)
    best = (0.0, values[-1], np.inf)
    for p in np.arange(0.2, 6.001, 0.02):
        A = np.column_stack([np.ones(len(n)), n**-p])
        x = np.linalg.lstsq(A, values, rcond=None)[0]
        misfit = float(np.linalg.norm(values - A @ x) / np.linalg.norm(values - values.mean(axis=0)))
        if misfit < best[2]:
            best = (float(p), x[0], misfit)
    return best
