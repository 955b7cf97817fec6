"""Loads of heat: elements that may expand do so without stress, and those that may not press as E A alpha dT says."""

from __future__ import annotations

import numpy as np
import pytest

from creak.elements.block_matrices import block_heat_load, expands
from creak.elements.registry import FORMULATIONS
from creak.model.elasticity import lamina, orthotropic
from creak.model.expansion import Expansion, isotropic_expansion
from creak.model.faces import FACES
from creak.model.laminates import Ply, homogeneous_shell, laminate
from creak.model.materials import (
    AnisotropicMaterial,
    BeamSection,
    Material,
    SheetMaterial,
    ShellSection,
    SolidSection,
    Spring,
    TrussSection,
)
from creak.model.mesh import COMMON, ElementBlock, Own
from helpers_fem import macneal_patch, random_rotation
from helpers_solids import solid_mesh

ALPHA, RISE = 1.2e-5, 60.0
STEEL = Material("STEEL", 2.1e5, 0.3, 7.85e-9, expansion=isotropic_expansion(ALPHA))
ALONG, ACROSS = 2e-6, 3e-5
CARBON = SheetMaterial(
    "CARBON",
    *lamina(1.4e5, 1e4, 0.3, 5e3, 5e3, 3.5e3),
    1.6e-9,
    expansion=Expansion((ALONG, ACROSS, ACROSS, 0.0, 0.0, 0.0)),
)
WOOD = AnisotropicMaterial(
    "WOOD",
    orthotropic((1.2e4, 8e2, 5e2), (0.4, 0.45, 0.5), (7e2, 6e2, 5e1)),
    5e-10,
    expansion=Expansion((4e-6, 3e-5, 6e-5, 0.0, 0.0, 0.0)),
)
SOLIDS = [*FACES]


def unbalanced(kind: str, coords, elements, section, u, rise, own=COMMON) -> float:
    """|K u - f| over |f| of all elements, u (n_node, 6)."""
    x = coords[elements]
    formulation = FORMULATIONS[kind]
    worst = 0.0
    for stiffness, heated in (
        (formulation.stiffness, formulation.heat_load),
        (formulation.softened, formulation.softened_heat_load),
    ):
        if stiffness is None:
            continue
        f = heated(x, section, own, rise[elements])
        Ku = (stiffness(x, section, own) @ u[elements].reshape(len(elements), -1, 1))[..., 0]
        worst = max(worst, float(np.abs(Ku - f).max() / np.abs(f).max()))
    return worst


def expanded(coords, strain) -> np.ndarray:
    """(n_node, 6) displacements with a constant strain (3, 3)."""
    return np.concatenate([coords @ strain, np.zeros_like(coords)], axis=1)


@pytest.mark.parametrize("kind", SOLIDS)
def test_free_solids_expand_without_stress(kind):
    """Distorted elements, turned in space; of an orthotropic body along its own axes."""
    coords, elements = solid_mesh((2, 2, 2), (3.0, 2.0, 1.0), kind, distortion=0.15)
    turn, axes = random_rotation(1), random_rotation(2)
    coords = coords @ turn.T
    rise = np.full(len(coords), RISE)
    u = expanded(coords, ALPHA * RISE * np.eye(3))
    assert unbalanced(kind, coords, elements, SolidSection("S", STEEL), u, rise) < 1e-10
    own = Own(axis1=np.tile(axes[0], (len(elements), 1)), axis2=np.tile(axes[1], (len(elements), 1)))
    u = expanded(coords, RISE * axes.T @ np.diag([4e-6, 3e-5, 6e-5]) @ axes)
    assert unbalanced(kind, coords, elements, SolidSection("S", WOOD), u, rise, own) < 1e-10


def shell_mesh(kind: str):
    """A flat, distorted patch in space, and its normal."""
    mesh = macneal_patch(kind)
    turn = random_rotation(3)
    return 10.0 * mesh.coords @ turn.T, mesh.elements, turn


@pytest.mark.parametrize(("kind", "shape"), [("quad4", "quad"), ("tri3", "tri")])
def test_free_plates_expand_without_stress(kind, shape):
    coords, elements, turn = shell_mesh(shape)
    rise = np.full(len(coords), RISE)
    own = Own(thickness=np.full(elements.shape, 1.5))
    for section in (ShellSection("S", STEEL, 0.2), homogeneous_shell("S", STEEL, 0.2, 0.3)):
        assert unbalanced(kind, coords, elements, section, expanded(coords, ALPHA * RISE * np.eye(3)), rise) < 1e-9
    u = expanded(coords, ALPHA * RISE * np.eye(3))
    assert unbalanced(kind, coords, elements, ShellSection("S", STEEL, 0.2), u, rise, own) < 1e-9
    axis = turn @ np.array([np.cos(0.4), np.sin(0.4), 0.0])
    other = np.cross(turn[:, 2], axis)
    strain = RISE * (ALONG * np.outer(axis, axis) + ACROSS * np.outer(other, other))
    own = Own(axis1=np.tile(axis, (len(elements), 1)))
    section = laminate("S", [Ply(CARBON, 0.1), Ply(CARBON, 0.1)])
    assert unbalanced(kind, coords, elements, section, expanded(coords, strain), rise, own) < 1e-9


def test_free_warped_shells_expand_without_stress():
    coords, elements, turn = shell_mesh("quad")
    coords = coords + 0.3 * np.cos(2.0 * coords @ turn[:, :1]) * turn[:, 2]
    u, rise = expanded(coords, ALPHA * RISE * np.eye(3)), np.full(len(coords), RISE)
    for section in (ShellSection("S", STEEL, 0.2), homogeneous_shell("S", STEEL, 0.2, 0.3)):
        assert unbalanced("quad4", coords, elements, section, u, rise) < 1e-9


@pytest.mark.parametrize(("kind", "shape"), [("quad4", "quad"), ("tri3", "tri")])
def test_free_unsymmetric_laminate_bends_to_the_laminate_theory(kind, shape):
    """[e; k] = [A B; B D]^-1 [N; M] everywhere, with a quadratic deflection, leaves no force."""
    mesh = macneal_patch(shape)
    coords, elements = 10.0 * mesh.coords, mesh.elements
    section = laminate("S", [Ply(CARBON, 0.1, 0.3), Ply(CARBON, 0.15, np.pi / 2), Ply(STEEL, 0.05)], bottom=-0.1)
    heat = section.expansion
    whole = np.block([[section.A, section.B], [section.B, section.D]])
    e = RISE * np.linalg.solve(whole, np.concatenate([heat.force, heat.moment]))
    x, y, u = coords[:, 0], coords[:, 1], np.zeros((len(coords), 6))
    u[:, 0], u[:, 1] = e[0] * x + 0.5 * e[2] * y, 0.5 * e[2] * x + e[1] * y
    u[:, 2] = -0.5 * (e[3] * x * x + e[4] * y * y + e[5] * x * y)
    u[:, 3], u[:, 4] = -(e[4] * y + 0.5 * e[5] * x), e[3] * x + 0.5 * e[5] * y
    own = Own(axis1=np.tile([1.0, 0.0, 0.0], (len(elements), 1)))
    assert unbalanced(kind, coords, elements, section, u, np.full(len(coords), RISE), own) < 1e-8


def test_bars_expand_freely_and_press_when_clamped():
    coords = np.array([[0.0, 0, 0], [1.0, 2.0, 3.0]])
    elements, rise = np.array([[0, 1]]), np.array([RISE - 10.0, RISE + 10.0])
    truss = TrussSection("T", STEEL, 4.0)
    beam = BeamSection("B", STEEL, 4.0, 1.3, 2.1, 1.1, centroid=(0.3, -0.2), shear_centre=(0.1, 0.4), angle=0.3)
    u = expanded(coords, ALPHA * RISE * np.eye(3))
    for kind, section in (("truss2", truss), ("beam2", beam)):
        assert unbalanced(kind, coords, elements, section, u, rise) < 1e-12
        f = FORMULATIONS[kind].heat_load(coords[elements], section, COMMON, rise[elements])[0]
        pressed = np.linalg.norm(f[:3])
        assert pressed == pytest.approx(2.1e5 * 4.0 * ALPHA * RISE, rel=1e-12)
        assert f[:3] == pytest.approx(-f[6:9])
    assert np.abs(FORMULATIONS["beam2"].heat_load(coords[elements], beam, COMMON, rise[elements])[0, 3:6]).max() > 1.0


def test_a_gradient_along_a_body_strains_it_point_by_point():
    """T = c x in a bar of solids: u_x = alpha c x^2/2 and its lateral parts, which quadratic elements hold."""
    coords, elements = solid_mesh((2, 1, 1), (2.0, 1.0, 1.0), "hex20")
    c = 10.0
    x, y, z = coords.T
    u = np.zeros((len(coords), 6))
    u[:, 0] = 0.5 * ALPHA * c * (x * x - y * y - z * z)
    u[:, 1], u[:, 2] = ALPHA * c * x * y, ALPHA * c * x * z
    for kind in ("hex20", "hex20s", "hex20r"):
        assert unbalanced(kind, coords, elements, SolidSection("S", STEEL), u, c * x) < 1e-10


def test_arms_and_what_does_not_expand():
    """Arms carry the forces to the nodes; springs and materials without expansion have none."""
    coords = np.array([[0.0, 0, 0], [2.0, 0, 0]])
    arms = np.tile([0.0, 0.0, 0.5], (1, 2, 1))
    block = ElementBlock(
        "truss2", np.array([1]), np.array([[0, 1]]), TrussSection("T", STEEL, 1.0), 0, "", Own(arms=arms)
    )
    f = block_heat_load(block, coords, np.full((1, 2), RISE)).reshape(2, 6)
    pressed = 2.1e5 * ALPHA * RISE
    assert f[:, 0] == pytest.approx([-pressed, pressed])
    assert f[:, 4] == pytest.approx([-0.5 * pressed, 0.5 * pressed])
    cold = Material("COLD", 2.1e5, 0.3, 7.85e-9)
    assert not expands("truss2", TrussSection("T", cold, 1.0))
    assert not expands("spring2", Spring("K", 1, 1, 5.0))
    assert expands("truss2", block.section)
