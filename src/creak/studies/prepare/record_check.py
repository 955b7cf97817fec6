"""What a study should hear of its measured records before it runs: when they move something, and how well."""

from __future__ import annotations

from creak.dynamics.loads import Loads
from creak.signals.omega_arithmetic import wrapped_share
from creak.studies.file.case import Driving
from creak.studies.prepare.excitation import records_of

STANDS = 0.02
"""Share of a run that a record may leave out at its beginning and at its end: it may be a few samples."""
KNOWN = 0.02
"""Share of its displacement up to which a record is known in its middle."""


def record_warnings(driving: Driving, loads: Loads) -> list[str]:
    """Records that cover another time than the run, or are too short for the displacement that is made of them."""
    texts, end = list[str](), float(loads.time[-1])
    names = list(driving.moving)
    for name, record in records_of(driving).items():
        moves = loads.time[loads.support[:, :, names.index(name)].any(axis=0)]
        begins, ends = float(record.time[0]), float(record.time[-1])
        if not moves.size:
            texts.append(
                f"[excitation.{name}] is zero throughout the run: its record holds {begins:.4g} to {ends:.4g} s, the "
                f"run 0 to {end:.4g} s"
            )
            continue
        if moves[0] > STANDS * end:
            texts.append(
                f"the record of [excitation.{name}] begins at {begins:.4g} s: nothing moves before, and rates are "
                f"those of the whole run to {end:.4g} s. Shift its times to begin at 0"
            )
        if moves[-1] < (1.0 - STANDS) * end:
            texts.append(
                f"the record of [excitation.{name}] ends at {ends:.4g} s, the run at {end:g} s: the motion fades "
                "out there, and nothing moves it any more"
            )
        if (share := wrapped_share(record.value, record.step, record.high_pass)) > KNOWN:
            texts.append(
                f"the displacement made of the record of [excitation.{name}] is off by some {100.0 * share:.2g} % in "
                f"its middle, and by more near its ends: it is {(ends - begins) * record.high_pass:.3g} / high_pass "
                "long, and its ends do not meet. Take a longer record, or one of whole periods"
            )
    return texts
