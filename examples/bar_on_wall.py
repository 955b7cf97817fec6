"""# A bar that bounces on a wall

An elastic bar falls on a rigid floor (Doyen, Ern, Piperno, SIAM J. Sci. Comput. 33, 2011).
On impact a compression wave runs up the bar, is reflected at its free top as tension and lifts the foot off again:
contact lasts 2 L / c, the force follows rho A c times the speed and the weight above the front, the impulse is 800/3.
Then the bar flies while it vibrates, and the period of the motion is 16/3 s; nothing is ever lost.
A penalty of ten element stiffnesses and HHT (alpha = -.05) smear the fronts, which rings; impulses hold to 1 %.
"""

import sys

import numpy as np

import creak

LENGTH, YOUNG, HEIGHT, GRAVITY, ELEMENTS = 10.0, 900.0, 5.0, 10.0, 200
"""E = 900, rho = A = 1: waves run at 30."""
SPAN = LENGTH / ELEMENTS
CONTACTS = ((1.0, 5.0 / 3.0), (11.0 / 3.0, 13.0 / 3.0))
FORCES = ((300.0, 500.0), (500.0, 300.0))
"""At the beginning and end of each contact, linear in between."""
FOOT = {0.5: 3.75, 1.8: 0.533333, 2.0: 1.666667, 2.5: 4.027778, 3.0: 4.444444, 3.5: 0.694444, 4.5: 1.527778}
"""Time -> exact height of the foot."""


def run() -> tuple[creak.History, list[creak.Event]]:
    """The first 4.6 s of the fall."""
    n = ELEMENTS + 1
    ends = np.eye(n) * np.where(np.isin(np.arange(n), [0, ELEMENTS]), 0.5, 1.0)
    beside = np.eye(n, k=1) + np.eye(n, k=-1)
    K, M = YOUNG / SPAN * (2.0 * ends - beside), SPAN / 6.0 * (4.0 * ends + beside)
    bar = creak.diagonalise(creak.system_from_matrices(K, M))  # all modes kept: the same bar, in compiled code
    floor = creak.gap_channels(np.eye(1, n), HEIGHT, 10.0 * YOUNG / SPAN, names=["foot"])
    time = 0.5 * SPAN / 30.0 * np.arange(5521)
    weight = np.tile(-GRAVITY * M.sum(axis=1), (time.size, 1))
    loads = creak.make_loads(bar, time, forces=[(np.arange(n), weight)])
    history = creak.simulate(bar, floor, loads, creak.HHT(-0.05), observed=[0])
    return history, creak.find_events(history, floor, merge=0.05, f_max=30.0)


def main(picture: str | None = None) -> dict[str, float]:
    """Errors of times, impulses and motion of the foot, and the energy that the scheme created."""
    history, events = run()
    height = np.interp(list(FOOT), history.time, HEIGHT + history.displacement[:, 0])
    spans = [(e.t_start, e.t_end) for e in events]
    if picture:
        draw(history, picture)
    return {
        "events": float(len(events)),
        "time_error_s": float(np.abs(np.array(spans) - CONTACTS).max()),
        "impulse_error": max(abs(e.impulse * 3.0 / 800.0 - 1.0) for e in events),
        "height_error": float(np.abs(height - list(FOOT.values())).max()),
        "energy_created": history.energy_created,
    }


def draw(history: creak.History, picture: str) -> None:
    """Height of the foot and contact force, computed and exact."""
    import matplotlib.pyplot as plt

    figure, (top, low) = plt.subplots(2, 1, figsize=(7.6, 5.6), layout="constrained", sharex=True)
    top.plot(history.time, HEIGHT + history.displacement[:, 0], color="C0", label="foot, computed")
    top.plot(list(FOOT), list(FOOT.values()), "o", color="black", markerfacecolor="white", label="exact")
    top.axhspan(-0.6, 0.0, color="0.85")
    top.set(ylabel="height of the foot", ylim=(-0.6, 6.4))
    top.set_title("Bouncing bar: E = 900, rho = A = 1, L = 10, g = 10 (consistent units)")
    low.plot(history.time, history.force[:, 0], color="C0", linewidth=1.0, label="force, computed")
    for k, (span, force) in enumerate(zip(CONTACTS, FORCES, strict=True)):
        label = "exact" if k == 0 else None
        low.plot([span[0], *span, span[1]], [0.0, *force, 0.0], color="black", linestyle="--", label=label)
    low.set(xlabel="time, s", ylabel="contact force")
    for axis in (top, low):
        axis.grid(color="0.9")
        axis.legend(loc="upper center", bbox_to_anchor=(0.55, 1.0))
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    print(main(sys.argv[1] if len(sys.argv) > 1 else "bar_on_wall.png"))
