"""# A block that squeaks on a belt

A block of 1 kg on a spring of 10 kN/m is pressed with 10 N on a belt that moves at 10 mm/s.
It sticks and rides along until the spring pulls with mu_s N, slips back, and sticks again where both speeds meet.
Static friction .5 and kinetic .3 give a stick of 40.000 ms and a slip of 40.689 ms, exactly:
the block squeaks at 12.393 Hz, with .80689 mm of belt a cycle.
In the frame of the belt the spring's foot moves: its pull k v t is the load of the run.
"""

import sys

import numpy as np

import creak

MASS, STIFFNESS, NORMAL, BELT = 1.0, 1e4, 10.0, 0.01
STATIC, KINETIC = 0.5, 0.3
STICK, SLIP = 0.04, 0.04068888
RATE = 12.3932817
"""Hz."""
STEP, END = 1e-4, 0.5


def run() -> tuple[creak.History, list[creak.SlipEvent]]:
    """Half a second; dof 0 slides along the belt, dof 1 is pressed on it."""
    block = creak.system_from_matrices(np.diag([STIFFNESS, STIFFNESS]), np.diag([MASS, MASS]))
    belt = creak.gap_channels(
        [[0.0, 1.0]], 0.0, 1e6, preload=NORMAL, tangents=[[[1.0, 0.0]]], friction=(STATIC, KINETIC), names=["block"]
    )
    time = STEP * np.arange(round(END / STEP) + 1)
    loads = creak.make_loads(block, time, forces=[([0], -STIFFNESS * BELT * time)])
    history = creak.simulate(creak.diagonalise(block), belt, loads, observed=[0])  # diagonal: in compiled code
    return history, creak.find_slips(history, belt, merge=0.1)


def main(picture: str | None = None) -> dict[str, float]:
    """Rate of the squeak, mean stick and slip, and what is left of the energy balance."""
    history, (squeak,) = run()
    slips = np.array(squeak.slips[:-1])
    if picture:
        draw(history, picture)
    return {
        "rate_hz": float(1.0 / np.diff(slips[:, 0]).mean()),
        "stick_s": float((slips[1:, 0] - slips[:-1, 1]).mean()),
        "slip_s": float((slips[:, 1] - slips[:, 0]).mean()),
        "first_slip_s": float(slips[0, 0]),
        "energy_created": history.energy_created,
    }


def draw(history: creak.History, picture: str) -> None:
    """Spring force and speed over the ground."""
    import matplotlib.pyplot as plt

    figure, (top, low) = plt.subplots(2, 1, figsize=(7.6, 5.6), layout="constrained", sharex=True)
    t = 1e3 * history.time[history.output_index]
    spring = STIFFNESS * (BELT * history.time[history.output_index] + history.displacement[:, 0])
    top.plot(t, spring, color="C0", label="spring force")
    for mu, name in ((STATIC, "static limit"), (KINETIC, "kinetic friction")):
        top.axhline(mu * NORMAL, color="0.4", linestyle="--" if mu == STATIC else ":", label=name)
    top.set(ylabel="force, N", ylim=(-0.3, 6.8), title=f"Block on a belt: stick-slip at {RATE:.3f} Hz")
    low.plot(1e3 * history.time, 1e3 * (BELT + history.sliding[:, 0]), color="C3", label="block, over the ground")
    low.axhline(1e3 * BELT, color="0.4", linestyle="--", label="belt")
    low.set(xlabel="time, ms", ylabel="speed, mm/s", ylim=(-26.0, 20.0))
    for axis in (top, low):
        axis.grid(color="0.9")
        axis.legend(loc="upper right", ncols=3)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    print(main(sys.argv[1] if len(sys.argv) > 1 else "stick_slip_belt.png"))
