"""The cases of the thesis: which reductions of which door under which loads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from creak_thesis.door import LOADS as AMPLITUDES

LOADS = ("A1", "A2", "A3", "A4")
RATTLING = LOADS[1:]
"""Loads with contact."""
CHECKED_BY = "A4"
"""The reference load: the pre-check looks at it (thesis 3.3.2)."""
PAIRS, FEW_PAIRS = "PAIRS", "PAIRS15"
"""Node sets of the 44 verification pairs, and of the 15 of the spacing study."""
F_MAX = 1500.0
"""Fixed-interface modes, Hz (thesis 3.3.3)."""

ETAS = (25, 30, 35, 37, 40, 45)
"""Of the thesis, %."""
FINE_ETAS = (2, 5, 10, 15, 20)
"""Below them, %."""
SCHEME: Mapping[str, Any] = MappingProxyType(
    {
        "time.integrator": "hht",
        "time.alpha": -0.05,
        "time.step": 1e-3,
        "verification.merge": 0.005,
        "reduction.f_max": F_MAX,
    }
)
"""The thesis's own time integration, 1 kHz (its 3.6), and modes, 15 times the excitation: all its cases are run with
them, whatever creak's defaults are. Five of its steps without contact are within one event."""


@dataclass(frozen=True)
class Setting:
    """A door and how its contact is defined: what the cases that share one unreduced model have in common."""

    name: str
    coarsen: int = 1
    """Elements of the frame's flange merged into one."""
    hook_play: float | None = None
    """Play of the hooks between panel and frame to either side, mm; None: rigid."""
    changes: Mapping[str, Any] = field(default_factory=dict)
    """Dotted keys of the study file."""
    channels_of: str = ""
    """Another one whose pre-check is taken over: the same secondary nodes stay in contact."""


StS = Setting("StS")
NtS = Setting("NtS", changes={"contact.flange.method": "node-to-surface"}, channels_of="StS")
WHOLE_FLANGE = Setting("whole flange", changes={"precheck.enabled": False, "verification.pairs": FEW_PAIRS})
M1, M2 = (Setting(f"M{n - 1}", coarsen=n, channels_of="StS") for n in (2, 3))
PLAY = Setting("hooks with play", hook_play=0.2, channels_of="StS")
FINE_STEP = Setting("StS, a quarter of the step near contact", changes={"time.substeps": 4}, channels_of="StS")


@dataclass(frozen=True)
class Case:
    """One reduced model, or an unreduced one, under some of the loads."""

    name: str
    study: str
    """The section of the page that it belongs to."""
    reduction: Mapping[str, Any] | None
    """The table [reduction]; None: the unreduced model."""
    variant: Setting = StS
    loads: tuple[str, ...] = LOADS
    against: str = "Ref StS"
    """The unreduced case that it is compared with."""
    newton: bool = False
    """Time steps of plain Newton with refactorisation as well."""

    @property
    def key(self) -> dict[str, Any]:
        """What the result depends on besides the mesh."""
        return {
            "reduction": None if self.reduction is None else dict(self.reduction),
            "variant": self.variant.name,
            "coarsen": self.variant.coarsen,
            "hook_play": self.variant.hook_play,
            "changes": dict(self.variant.changes),
            "loads": {name: AMPLITUDES[name] for name in self.loads},
            "against": self.against,
            "newton": self.newton,
        }


def _d8(**more: Any) -> dict[str, Any]:
    return {"keep_out": 8.0, "f_max": F_MAX} | more


def plan() -> list[Case]:
    """All cases, unreduced ones before those that are compared with them."""
    return [
        Case("Ref StS", "reference", None, newton=True),
        Case("Ref NtS", "reference", None, NtS, RATTLING, "Ref NtS", newton=True),
        *_spacing(),
        *(Case(f"F{f}", "range", _d8(f_max=float(f))) for f in (300, 500, 700, 900, 1100, 1300, 2000)),
        Case("D8", "distance", _d8(), newton=True),
        *(Case(f"D{d}", "distance", _d8(keep_out=float(d)), newton=True) for d in (40, 90)),
        *(
            Case(
                f"P{eta}", "participation", _d8(interface={"type": "participation", "eta": eta / 100}), newton=eta == 35
            )
            for eta in (*FINE_ETAS, *ETAS)
        ),
        *(Case(v.name, "coarse", _d8(), v, newton=v is M2) for v in (M1, M2)),
        Case("Ref M2", "coarse", None, M2, ("A4",), "Ref M2"),
        Case("M2 own", "coarse", _d8(), M2, ("A4",), "Ref M2"),
        *(Case(f"I{n}", "coarse", _d8(interface={"type": "interpolation", "n": n}), newton=n == 3) for n in (2, 3)),
        Case("Red NtS", "node to surface", {"f_max": F_MAX}, NtS, RATTLING, "Ref NtS", newton=True),
        Case("D8 NtS", "node to surface", _d8(), NtS, RATTLING, "Ref NtS"),
        *_beyond(),
    ]


def _spacing() -> list[Case]:
    """Contact on the whole flange, panel unreduced, every n-th interface node of the frame retained (table 3.5)."""
    cases = [Case("Ref C", "spacing", None, WHOLE_FLANGE, (), "Ref C", newton=True)]
    for k, n in enumerate((1, 2, 4, 8, 16), start=1):
        reduction = _d8(interface={"type": "spacing", "n": n}, unreduced=["PANEL"])
        cases.append(Case(f"C{k}", "spacing", reduction, WHOLE_FLANGE, (), "Ref C", newton=True))
    return cases


def _beyond() -> list[Case]:
    """Interfaces with generalised coordinates, bases of the whole assembly, and shorter steps near contact."""
    characteristic = [
        Case(f"X{n}", "beyond", _d8(interface={"type": "characteristic", "n": n}), newton=n == 100)
        for n in (50, 100, 200)
    ]
    return [
        *characteristic,
        Case("CB", "beyond", {"f_max": F_MAX}),
        Case("G700", "beyond", {"method": "gap-modes", "f_max": 700.0}),
        Case("Ref play", "play", None, PLAY, ("A3", "A4"), "Ref play"),
        Case("D8 play", "play", _d8(), PLAY, ("A3", "A4"), "Ref play"),
        Case("Ref StS h/4", "step", None, FINE_STEP, ("A4",), "Ref StS h/4"),
        Case("D8 h/4", "step", _d8(), FINE_STEP, ("A4",), "Ref StS h/4"),
    ]
