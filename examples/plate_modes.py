"""# Modes of a cantilevered plate

A square steel plate, 10 m x 10 m x 50 mm, is clamped along one edge (NAFEMS FV16).
Its lowest modes are waves along and across the clamp: bending, twist, second bending, ...
The Ritz method with many products of beam functions gives their frequencies to four digits.
Shells of the mesh size h miss a mode of wave number k by about (kh)²/24, from above or below;
the error falls with h², so that 24 x 24 elements are within a half per cent.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

import creak

SIDE, THICKNESS, ELEMENTS = 10.0, 0.05, 24
RITZ = np.array([0.4179, 1.0242, 2.5628, 3.2749, 3.7273, 6.5244])
"""Hz, converged Ritz values."""


def deck() -> str:
    """The plate as an Abaqus deck in m, kg, s."""
    n = ELEMENTS + 1
    x = np.linspace(0.0, SIDE, n)
    nodes = [f"{1 + i * n + j}, {x[i]:.9g}, {x[j]:.9g}, 0." for i in range(n) for j in range(n)]
    first = [1 + i * n + j for i in range(n - 1) for j in range(n - 1)]
    shells = [f"{k + 1}, {a}, {a + n}, {a + n + 1}, {a + 1}" for k, a in enumerate(first)]
    return "\n".join(
        [
            "*NODE",
            *nodes,
            "*ELEMENT, TYPE=S4, ELSET=PLATE",
            *shells,
            "*MATERIAL, NAME=STEEL",
            "*ELASTIC",
            "200e9, 0.3",
            "*DENSITY",
            "8000.,",
            "*SHELL SECTION, ELSET=PLATE, MATERIAL=STEEL",
            f"{THICKNESS},",
            "*NSET, NSET=EDGE, GENERATE",
            f"1, {n}, 1",
            "*BOUNDARY",
            "EDGE, 1, 6",
            "",
        ]
    )


def main(picture: str | None = None) -> dict[str, float]:
    """Largest relative error of six frequencies, mass and its error; draws the modes into `picture`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plate.inp"
        path.write_text(deck())
        modes = creak.deck_modes(path, count=6)
    if picture:
        draw(modes, picture)
    return {
        "frequency_error": float(np.abs(np.array(modes.frequencies) / RITZ - 1.0).max()),
        "mass_error": modes.mass / (8000.0 * SIDE**2 * THICKNESS) - 1.0,
        "rigid": float(modes.rigid),
    }


def draw(modes: creak.DeckModes, picture: str) -> None:
    """Deflection of the six modes, blue down, red up."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 3, figsize=(9.6, 6.2), layout="constrained", sharex=True, sharey=True)
    x = np.linspace(0.0, SIDE, ELEMENTS + 1)
    for axis, frequency, exact, u in zip(axes.flat, modes.frequencies, RITZ, modes.translations(), strict=True):
        w = u[:, 2].reshape(x.size, x.size).T
        levels = np.linspace(-1.0, 1.0, 22) * np.abs(w).max()
        drawn = axis.contourf(x, x, w, levels, cmap="RdBu_r")
        axis.contour(x, x, w, [0.0], colors="0.2", linewidths=1.0)
        axis.set_title(f"{frequency:.4f} Hz  (Ritz {exact:.4f}, {100 * (frequency / exact - 1):+.2f} %)", fontsize=9)
        axis.plot([0, 0], [0, SIDE], color="black", linewidth=5, clip_on=False)
        axis.set_aspect("equal")
    bar = figure.colorbar(drawn, ax=axes, label="deflection, share of the largest", shrink=0.7)
    bar.set_ticks([levels[0], 0.0, levels[-1]], labels=["-1", "0", "1"])
    figure.suptitle("Cantilevered plate: lowest modes; clamped edge black, nodal lines thin")
    figure.supxlabel("x, m")
    figure.supylabel("y, m")
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    print(main(sys.argv[1] if len(sys.argv) > 1 else "plate_modes.png"))
