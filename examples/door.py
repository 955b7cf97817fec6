"""# The door

A car's front door: steel frame, plastic carrier and trim panel, meshed at 20 mm, hung at two hinges.
The road shakes the upper hinge with 1 to 100 Hz; the panel's edge rattles on the frame's flange.
Only a small part of the surfaces can touch: a linear run finds it, the rest is left out.
Each part is reduced to what is touched, joined or driven and its modes below 1500 Hz.
The unreduced door runs through the same five seconds, and every event of both is compared.
"""

import sys
import tempfile

import creak

COLOURS = {"reference": "0.2", "reduced": "C1"}


def run(mesh_size: float, periods: int) -> creak.Result:
    """The study of the door as `creak example door` writes it."""
    with tempfile.TemporaryDirectory() as folder:
        creak.write_door(folder, mesh_size)
        study = creak.read_study(f"{folder}/door.toml")
        return creak.run(
            creak.change_study(study, {"time.periods": periods, "reference.run": "whole", "reference.until": 1.0})
        )


def main(picture: str | None = None, mesh_size: float = 20.0, periods: int = 5) -> dict[str, float]:
    """Size of both models, events of the last second, and how well they agree."""
    result = run(mesh_size, periods)
    runs, match, check = result.summary["runs"], result.agreement, result.summary["verification"]
    assert match is not None
    if picture:
        draw(result, picture)
    return {
        "dof": float(runs["reference"]["dof"]),
        "dof_reduced": float(runs["reduced"]["dof"]),
        "events": float(len(match.pairs) + len(match.missed)),
        "missed": float(len(match.missed)),
        "extra": float(len(match.extra)),
        "impulse_ratio": check["events"]["impulse_ratio_mean"],
        "lowest_mac": min(check["mac"]),
        "nrmse": check["nrmse"]["all"],
        "speed_up": runs["reference"]["wall_s"] / runs["reduced"]["wall_s"],
    }


def draw(result: creak.Result, picture: str) -> None:
    """Force and impulse of the events of the last second, and the mean spectrum of the relative motion."""
    import matplotlib.pyplot as plt
    import numpy as np

    figure, (top, middle, low) = plt.subplots(3, 1, figsize=(8.0, 8.4), layout="constrained")
    begin, end = result.found.window
    spectra = result.found.spectra
    assert spectra is not None
    for name, color in COLOURS.items():
        run, style = result.runs[name], "-" if name == "reference" else "--"
        late = run.history.time >= begin
        top.plot(run.history.time[late], run.history.force[late].sum(axis=1), style, color=color, label=name)
        marker = "o" if name == "reference" else "x"
        events = [e for e in run.events if e.t_start >= begin]
        t, impulse = [e.t_start for e in events], [1e3 * e.impulse for e in events]
        middle.plot(t, impulse, marker, color=color, markersize=8, label=name)
        size = np.sqrt(np.mean(np.abs(spectra.spectra[name]) ** 2, axis=(1, 2)))
        low.semilogy(spectra.freq, size, style, color=color, linewidth=1.2, label=name)
    top.set(ylabel="contact force, N", xlim=(begin, end), title="Door on a rough road: panel against frame")
    middle.set(ylabel="impulse of the event, N ms", xlabel="time, s", xlim=(begin, end))
    low.set(ylabel="panel against frame, rms, mm", xlabel="frequency, Hz", xlim=(0.0, 500.0))
    for axis in (top, middle, low):
        axis.grid(color="0.9")
        axis.legend(loc="upper right", ncols=2)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    print(main("door.png", float(sys.argv[1]) if len(sys.argv) > 1 else 20.0))
