"""Between the lines of a measured frequency response function: its level is kept where its phase turns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from creak.arrays import BoolArray, ComplexArray, FloatArray, IntArray

CLOSE, APART = np.pi / 6.0, np.pi / 3.0
"""rad that the phase turns from line to line, up to which real and imaginary part are interpolated, and from which on
amplitude and phase: a chord lies 0.3 dB below its arc at the first, 1.2 dB at the second."""
FAR = 0.5 * np.pi
"""rad from which on the way that the phase turned is not known."""
FINE = 0.25 * np.pi
"""rad that it should turn at most."""
LOUD = 0.5
"""Of the root mean square of all amplitudes, from which on a line counts for the level."""
SLIGHT = np.pi / 12.0
"""rad over the widest step, up to which a delay of all is left as it is."""
COHERENT = 0.5
"""Mean cosine of what is left of the turns, from which on they are those of a delay."""
EARLY = 0.125
"""Of the longest delay that lines can tell, that may be a lead instead."""
VALLEY = 1.2
"""Times as high as both lines of a step that the next ones on either side are, where a zero lies in it or near."""
PER_TURN = 4
"""Delays that are tried for each turn over the widest step."""
SAME = 1e-6
"""Of the smallest step, within which steps are alike."""
ROUNDS = 4
"""Of least squares."""


@dataclass(frozen=True)
class Lines:
    """A function H that is known at frequencies.

    A delay of all of it is taken off and put back. What is left is between lines real and imaginary part, each by
    monotone cubics over log frequency (Fritsch, Carlson, SIAM J. Numer. Anal. 17, 1980), which go through zeros; and
    where the phase turns far from one line to the next, amplitude by the same cubics and phase, linear over frequency,
    so that nothing of the level is lost. It turns far at zeros too: a step in a valley of the amplitude is one.
    """

    freq: FloatArray
    """(n,) Hz above 0, upwards, two or more."""
    value: ComplexArray
    """(n,)"""

    def at(self, freq: FloatArray) -> ComplexArray:
        """(k,) H at frequencies (k,) within those that are known, Hz."""
        real, imag, amplitude = self._cubics(np.log(freq)).T
        plain = real + 1j * imag
        phase = np.interp(freq, self.freq, self._phase)
        polar = self._polar[np.clip(np.searchsorted(self.freq, freq, side="right") - 1, 0, self._polar.size - 1)]
        found = plain + polar * (amplitude * np.exp(1j * phase) - plain)
        return np.asarray(found * np.exp(-2j * np.pi * freq * self.delay))

    @cached_property
    def delay(self) -> float:
        """s by which all of it is late: that which leaves least of the turns from line to line; 0: none to speak of."""
        step, turn = np.diff(self.freq), _turns(self.value)
        size, which = np.unique(np.round(step / (SAME * step.min())), return_inverse=True)
        size = size * SAME * step.min()
        alike = np.zeros(size.size, dtype=complex)
        np.add.at(alike, which, np.exp(1j * turn))
        longest, closest = 1.0 / float(size[0]), 1.0 / (PER_TURN * float(size[-1]))
        tried = np.arange(-EARLY * longest, (1.0 - EARLY) * longest, closest)
        left = [float((alike * np.exp(2j * np.pi * size * tau)).real.sum()) for tau in tried.tolist()]
        tau = float(tried[int(np.argmax(left))])
        for _ in range(ROUNDS):
            off = np.asarray(np.angle(np.exp(1j * (turn + 2.0 * np.pi * step * tau))))
            near = step * (np.abs(off) < FAR)
            tau -= float(near @ off) / max(2.0 * np.pi * float(near @ near), 1e-300)
        if size.size == 1:  # of even lines each delay is one of many
            tau = float(np.mod(tau + EARLY * longest, longest)) - EARLY * longest
        coherent = np.cos(turn + 2.0 * np.pi * step * tau).mean() > COHERENT
        return tau if coherent and 2.0 * np.pi * float(size[-1]) * abs(tau) > SLIGHT else 0.0

    @cached_property
    def unknown(self) -> IntArray:
        """Steps from a line to the next over which the phase of loud lines turns too far to tell which way."""
        size = np.abs(self._still)
        loud = size > LOUD * np.sqrt(np.mean(size**2))
        return np.flatnonzero((np.abs(self.turns) >= FAR) & loud[1:] & loud[:-1] & ~self._valleys)

    @cached_property
    def turns(self) -> FloatArray:
        """(n - 1,) rad by which the phase turns from line to line without the delay, within half a turn."""
        return _turns(self._still)

    def fine(self, steps: IntArray) -> float:
        """Hz that lines may lie apart where the phase turns as over some steps: an eighth of a turn each."""
        return float((np.diff(self.freq) * FINE / np.abs(self.turns))[steps].min())

    @cached_property
    def _still(self) -> ComplexArray:
        return np.asarray(self.value * np.exp(2j * np.pi * self.freq * self.delay))

    @cached_property
    def _phase(self) -> FloatArray:
        return np.asarray(np.angle(self._still[0]) + np.concatenate([[0.0], np.cumsum(self.turns)]))

    @cached_property
    def _cubics(self) -> Any:
        from scipy.interpolate import PchipInterpolator  # see `signals.spectra.low_pass`

        z = self._still
        return PchipInterpolator(np.log(self.freq), np.column_stack([z.real, z.imag, np.abs(z)]))

    @cached_property
    def _valleys(self) -> BoolArray:
        size, calm = np.abs(self._still), np.abs(self.turns) < FAR
        falls = np.concatenate([[False], (size[:-2] > VALLEY * size[1:-1]) & calm[:-1]])
        rises = np.concatenate([(size[2:] > VALLEY * size[1:-1]) & calm[1:], [False]])
        return np.asarray(falls & rises)

    @cached_property
    def _polar(self) -> FloatArray:
        """(n - 1,) share of amplitude and phase."""
        share = np.clip((np.abs(self.turns) - CLOSE) / (APART - CLOSE), 0.0, 1.0)
        return np.where(self._valleys, 0.0, share)


def _turns(value: ComplexArray) -> FloatArray:
    return np.asarray(np.angle(value[1:] * value[:-1].conj()))
