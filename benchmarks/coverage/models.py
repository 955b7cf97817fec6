"""Random decks of two parts that touch, with studies that say nothing numerical: what a user would write."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

UNITS = {"mm-t-s": (1e-3, 1e3), "m-kg-s": (1.0, 1.0), "in-lbf-s": (0.0254, 175.126835)}
"""m and kg in the units of length and mass."""
MATERIALS = {
    "STEEL": (210e9, 0.3, 7850.0),
    "ALUMINIUM": (70e9, 0.33, 2700.0),
    "GLASS_FILLED": (8e9, 0.35, 1400.0),
    "PLASTIC": (2.2e9, 0.38, 1050.0),
}
"""Pa, 1, kg/m^3."""


@dataclass
class Deck:
    """Lines of an Abaqus deck in SI that grow part by part, and the names that a study needs."""

    scale: float
    """Units of length in 1 m."""
    nodes: list[str] = field(default_factory=list)
    blocks: list[str] = field(default_factory=list)
    sections: list[str] = field(default_factory=list)
    count: int = 0
    elements: int = 0

    def add_nodes(self, points: np.ndarray) -> np.ndarray:
        """Labels of new nodes at points (n, 3), m."""
        labels = self.count + 1 + np.arange(len(points))
        self.nodes += [
            f"{a}, {x:.12g}, {y:.12g}, {z:.12g}" for a, (x, y, z) in zip(labels, points * self.scale, strict=True)
        ]
        self.count += len(points)
        return labels

    def add_elements(self, kind: str, name: str, members: np.ndarray) -> np.ndarray:
        """Labels of new elements."""
        labels = self.elements + 1 + np.arange(len(members))
        self.blocks.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        self.blocks += [", ".join(map(str, [e, *row])) for e, row in zip(labels, members.tolist(), strict=True)]
        self.elements += len(members)
        return labels

    def add_set(self, kind: str, name: str, labels: np.ndarray) -> None:
        """A node or element set."""
        self.blocks += [f"*{kind}, {kind}={name}", *(f"{a}," for a in np.atleast_1d(labels))]


@dataclass(frozen=True)
class Case:
    """One random model, its files and what it is."""

    seed: int
    folder: Path
    words: str
    fastest: float
    """Hz, highest frequency of the excitation."""

    @property
    def study(self) -> Path:
        """The study file."""
        return self.folder / "study.toml"


@dataclass(frozen=True)
class Part:
    """One of the two: its extent, and names of its sets."""

    kind: str
    top: float
    """m above its middle plane to the face that may touch."""
    name: str
    frequency: float
    """Hz, about, of its first bending mode."""


def draw(seed: int) -> dict[str, Any]:
    """All that is random of a model, in SI."""
    rng = np.random.default_rng([34, seed])
    upper = str(rng.choice(["strip", "strip", "beam", "solid"]))
    lower = str(rng.choice(["strip", "strip", "solid", "block"]))
    how = str(rng.choice(["surface", "surface", "node", "play"]))
    if upper == "beam" and how == "surface":
        how = "node"
    if how == "play" and rng.random() < 0.3:
        lower = "beam"
    size = float(10.0 ** rng.uniform(-0.5, 0.5))
    length, width = size * rng.uniform(0.08, 0.2), size * rng.uniform(0.015, 0.04)
    thick = [float(size * rng.uniform(1.0e-3, 4.0e-3)) for _ in range(2)]
    return {
        "rng": rng,
        "units": str(rng.choice(list(UNITS))),
        "upper": upper,
        "lower": lower,
        "how": how,
        "and_play": bool(how != "play" and rng.random() < 0.2),
        "size": size,
        "length": float(length),
        "width": float(width),
        "thick": thick,
        "materials": [str(rng.choice(list(MATERIALS))) for _ in range(2)],
        "gap": float(size * 10.0 ** rng.uniform(np.log10(0.05e-3), np.log10(2e-3))),
        "friction": bool(how != "play" and rng.random() < 0.4),
        "signal": str(rng.choice(["multisine", "psd", "sine"])),
        "drive": str(rng.choice(["both", "upper", "force"])),
        "zeta": float(0.0 if rng.random() < 0.1 else rng.uniform(0.002, 0.05)),
        "rayleigh": bool(rng.random() < 0.4),
        "stiffness": "auto" if rng.random() < 0.6 else float(10.0 ** rng.uniform(-1.5, 0.0)),
    }


def bending(length: float, thick: float, material: str) -> float:
    """Hz, first mode of a clamped strip."""
    E, _, rho = MATERIALS[material]
    return float(1.875104**2 / (2.0 * np.pi) * np.sqrt(E / (12.0 * rho)) * thick / length**2)


def add_part(deck: Deck, kind: str, name: str, d: dict[str, Any], which: int, z: float, up: bool) -> float:
    """A part along x whose face towards the other lies at height z; returns its first frequency, Hz.

    Parameters
    ----------
    up : it lies above z.
    """
    rng, L, b, t = d["rng"], d["length"], d["width"], d["thick"][which]
    L = L if which == 0 else L * rng.uniform(0.7, 1.0)
    first = 0.0 if which == 0 or rng.random() < 0.5 else d["length"] - L
    material, way = d["materials"][which], 1.0 if up else -1.0
    E, nu, rho = MATERIALS[material]
    m_unit, kg_unit = UNITS[d["units"]]
    nx, ny = int(rng.integers(6, 14)), int(rng.integers(1, 4))
    x = first + L * np.arange(nx + 1) / nx
    root_at_end = bool(which == 1 and rng.random() < 0.3)
    deck.sections += [
        f"*MATERIAL, NAME=M_{name}",
        "*ELASTIC",
        f"{E * m_unit / kg_unit:.9g}, {nu}",
        "*DENSITY",
        f"{rho * m_unit**3 / kg_unit:.9g},",
    ]
    if kind == "beam":
        side = 0.5 * min(b, 2.0 * t)
        labels = deck.add_nodes(
            np.column_stack([x, np.full_like(x, 0.5 * d["width"]), np.full_like(x, z + way * side)])
        )
        elements = deck.add_elements("B31", name, np.column_stack([labels[:-1], labels[1:]]))
        deck.sections += [
            f"*BEAM SECTION, SECTION=RECT, ELSET={name}, MATERIAL=M_{name}",
            f"{2 * side * deck.scale:.9g}, {2 * side * deck.scale:.9g}",
            "0., 1., 0.",
        ]
        grid, thick = labels[:, None], 2.0 * side
        face, touching = grid, elements
    elif kind == "strip":
        y = b * np.arange(ny + 1) / ny
        X, Y = np.meshgrid(x, y, indexing="ij")
        grid = deck.add_nodes(np.column_stack([X.ravel(), Y.ravel(), np.full(X.size, z + 0.5 * way * t)]))
        grid = grid.reshape(nx + 1, ny + 1)
        shells = np.column_stack([a.ravel() for a in (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])])
        elements = deck.add_elements("S4", name, shells)
        deck.sections += [f"*SHELL SECTION, ELSET={name}, MATERIAL=M_{name}", f"{t * deck.scale:.9g},"]
        face, thick, touching = grid, t, elements.reshape(nx, ny)
    else:
        nz = 1 if kind == "solid" else 2
        thick = 2.0 * t if kind == "solid" else d["length"] * rng.uniform(0.1, 0.3)
        nx = nx if kind == "solid" else 5
        x = first + L * np.arange(nx + 1) / nx
        y, heights = b * np.arange(ny + 1) / ny, z + way * thick * np.arange(nz + 1) / nz
        heights = heights if up else heights[::-1]
        X, Y, Z = np.meshgrid(x, y, heights, indexing="ij")
        grid = deck.add_nodes(np.column_stack([X.ravel(), Y.ravel(), Z.ravel()])).reshape(nx + 1, ny + 1, nz + 1)
        low, high = grid[:, :, :-1], grid[:, :, 1:]
        corners = [
            a.ravel() for layer in (low, high) for a in (layer[:-1, :-1], layer[1:, :-1], layer[1:, 1:], layer[:-1, 1:])
        ]
        elements = deck.add_elements("C3D8I", name, np.column_stack(corners))
        deck.sections += [f"*SOLID SECTION, ELSET={name}, MATERIAL=M_{name}"]
        face, touching = grid[:, :, 0 if up else -1], elements.reshape(nx, ny, nz)
    root = grid[-1:] if root_at_end else grid[:1]
    if kind == "block":
        root = grid[:, :, -1] if up else grid[:, :, 0]
    tip = slice(None) if root_at_end or kind == "block" else slice(nx - nx // 2, None)
    deck.add_set("NSET", f"{name}_ROOT", np.unique(root))
    deck.add_set("NSET", f"{name}_TIP", np.unique(face[0] if root_at_end else face[-1]))
    deck.add_set("NSET", f"{name}_FACE", np.unique(face[: nx // 2 + 1] if root_at_end else face[nx - nx // 2 :]))
    deck.add_set("NSET", f"{name}_POINT", np.atleast_1d(face[0 if root_at_end else -1].ravel()[0]))
    deck.add_set("ELSET", f"{name}_NEAR", np.unique(touching[tip]))
    held = "1, 2" if kind in ("solid", "block") else "1, 2\n{0}_ROOT, 4, 6"
    more = f"{name}_ROOT, {held.format(name)}"
    deck.blocks += ["*BOUNDARY", *more.split("\n")]
    if not moves_root(d, which):
        deck.blocks += [f"{name}_ROOT, 3"]
    return bending(L, thick, material) if kind != "block" else 0.0


def moves_root(d: dict[str, Any], which: int) -> bool:
    """Whether the excitation moves the support of a part."""
    return d["drive"] == "both" or (d["drive"] == "upper" and which == 0)


def write_case(seed: int, folder: Path, amplitude: float = 1.0, stiffness: float | None = None) -> Case:
    """Deck and study file of a seed in a folder.

    Parameters
    ----------
    amplitude : factor on the excitation. stiffness : what "auto" is of one channel (of its area with surfaces); needed
        where the study gives a share of it.
    """
    d = draw(seed)
    rng, (metre, kg) = d["rng"], UNITS[d["units"]]
    deck = Deck(1.0 / metre)
    f = [
        add_part(deck, d["upper"], "UPPER", d, 0, d["gap"], True),
        add_part(deck, d["lower"], "LOWER", d, 1, 0.0, False),
    ]
    roots = [f"{name}_ROOT" for k, name in enumerate(("UPPER", "LOWER")) if moves_root(d, k)]
    if roots:
        deck.blocks += ["*NSET, NSET=BASE", ", ".join(roots)]
    lowest = min(x for x in f if x > 0.0)
    signal, fastest, cycles = signal_of(d, rng, lowest)
    end = float(cycles / lowest)
    kind, node_set = ("displacement", "BASE") if roots else ("force", "UPPER_TIP")
    unit = 1.0 / metre if roots else 1.0 / (kg * metre)
    if d["signal"] == "psd":
        kind = "acceleration" if roots else "force"
        signal["values"] = [[f0, level * (unit * amplitude) ** 2] for f0, level in signal["values"]]
        signal["duration"] = end
    else:
        signal["amplitude"] *= unit * amplitude
    tables: dict[str, Any] = {
        "title": f"Random model {seed}",
        "model": {"deck": "deck.inp", "units": d["units"]},
        "damping": damping_of(d, lowest),
        "excitation": {"drive": {"node_set": node_set, "dof": "z", "kind": kind, "signal": signal}},
        "reduction": {"f_max": "auto"},
        "time": {"end": end},
    }
    contacts_of(d, tables, stiffness, metre)
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["*HEADING", tables["title"], "*NODE", *deck.nodes, *deck.blocks, *deck.sections]
    (folder / "deck.inp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    from creak.studies.file.toml_text import toml_text

    (folder / "study.toml").write_text(toml_text(tables), encoding="utf-8")
    said = [d["upper"], d["lower"], d["how"] + ("+play" if d["and_play"] else ""), d["signal"], d["drive"], d["units"]]
    if d["friction"]:
        said.append("friction")
    said.append("auto" if d["stiffness"] == "auto" else f"{d['stiffness']:.2g} auto")
    return Case(seed, folder, " ".join(said), fastest)


def signal_of(d: dict[str, Any], rng: np.random.Generator, lowest: float) -> tuple[dict[str, Any], float, float]:
    """Table of the excitation with a unit amplitude, its highest frequency in Hz, and periods of the lowest mode."""
    cycles = float(rng.uniform(6.0, 25.0))
    if d["signal"] == "sine":
        f = round(float(lowest * rng.uniform(0.3, 1.3)), 2)
        return {"type": "sine", "frequency": f, "amplitude": 1e-4}, f, cycles
    top = round(float(lowest * rng.uniform(0.8, 3.0)), 2)
    low = round(0.1 * top, 3)
    seed = int(rng.integers(1, 1000))
    if d["signal"] == "psd":
        return {"type": "psd", "unit": "unit2/Hz", "values": [[low, 1.0], [top, 1.0]], "seed": seed}, top, cycles
    period = float(f"{rng.uniform(0.3, 1.0) * cycles / lowest:.6g}")
    table = {"type": "multisine", "f_min": low, "f_max": top, "amplitude": 1e-4, "period": period, "seed": seed}
    return table, top, cycles


def damping_of(d: dict[str, Any], lowest: float) -> dict[str, Any]:
    """Modal, or Rayleigh with that share of critical at the lowest mode and at five times it."""
    if not d["rayleigh"]:
        return {"modal": d["zeta"]}
    one, two = 2.0 * np.pi * lowest, 10.0 * np.pi * lowest
    return {"rayleigh": {"alpha": 2.0 * d["zeta"] * one * two / (one + two), "beta": 2.0 * d["zeta"] / (one + two)}}


def contacts_of(d: dict[str, Any], tables: dict[str, Any], stiffness: float | None, metre: float) -> None:
    """Contact tables and connectors of a study."""
    rng = d["rng"]
    static = float(rng.uniform(0.1, 0.6))
    kinetic = static * float(rng.uniform(0.6, 1.0))
    decay = float(0.0 if rng.random() < 0.5 else 10.0 ** rng.uniform(-2.0, 0.0)) / metre
    upward = float(rng.uniform(1.0, 3.0))
    given = None if d["stiffness"] == "auto" or stiffness is None else float(d["stiffness"] * stiffness)
    if d["how"] != "play":
        table: dict[str, Any] = {"secondary": "UPPER_NEAR", "main": "LOWER_NEAR"}
        if d["how"] == "node":
            table |= {"method": "node-to-surface", "secondary": "UPPER_FACE"}
        if given is not None:
            table["stiffness"] = given
        if d["friction"]:
            table["friction"] = {"static": static, "kinetic": kinetic, "decay": decay}
        tables["contact"] = {"touch": table}
    if d["how"] == "play" or d["and_play"]:
        elastic = MATERIALS[d["materials"][0]][0] * d["thick"][0] / UNITS[d["units"]][1]
        stiff = float(elastic * 10.0 ** rng.uniform(-1.0, 0.5))
        gap = d["gap"] / metre
        tables["connector"] = [
            {
                "type": "play",
                "name": "clip",
                "nodes": ["LOWER_POINT", "UPPER_POINT"],
                "dof": "z",
                "lower": -gap * (1.0 if d["how"] == "play" else 0.8),
                "upper": gap * upward,
                "stiffness": stiff,
            }
        ]
