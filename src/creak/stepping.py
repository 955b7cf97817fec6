"""The pieces of a step, for time integrations of your own.

`march` drives a `Stepper` through its loads and keeps the energy balance and what an `OutputRequest` asks for: `start`
gives the first `Instant` (`first_instant`), `advance` those up to the next output. `LinearTerms` hold M, C, K, supports
and forces; `begin` opens a step and `LinearTerms.advance` ends it, once its acceleration is known; `channel_matrices`
has G of g = g0 + G q. `CondensedStepper` is the one of `creak.simulate` with a scheme.
"""

from __future__ import annotations

from creak.arrays import to_dense
from creak.dynamics.channels import channel_matrices
from creak.dynamics.instant import Instant, begin, first_instant
from creak.dynamics.record.recorder import OutputRequest
from creak.dynamics.simulate import CondensedStepper, Stepper, march
from creak.dynamics.state import LinearTerms
from creak.dynamics.step_matrix import StepFactor, step_matrix
from creak.linalg.factor import Factor, factor
from creak.linalg.threads import one_blas_thread

__all__ = [
    "CondensedStepper",
    "Factor",
    "Instant",
    "LinearTerms",
    "OutputRequest",
    "StepFactor",
    "Stepper",
    "begin",
    "channel_matrices",
    "factor",
    "first_instant",
    "march",
    "one_blas_thread",
    "step_matrix",
    "to_dense",
]
