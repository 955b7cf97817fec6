"""docs/door.md on the amplitudes of the loads: its arithmetic, from the thesis's table and the door's own loads."""

import math

import numpy as np
import pytest

from creak.signals.sources import Multisine
from creak_thesis.door import LOADS
from creak_thesis.report.facts import thesis
from helpers_docs import ROOT

SAMPLES = 1000
"""Of one period: 1 s at 1 kHz (thesis 3.2.1)."""
LINES = np.arange(1, 101)
GRAVITY = 9810.0
"""mm/s^2"""
WITH_CONTACT = ("A2", "A3", "A4")


def line(amplitude: float) -> float:
    """mm, sine of 10 Hz in what an inverse FFT makes of an amplitude at +f and -f."""
    spectrum = np.zeros(SAMPLES, dtype=complex)
    spectrum[[10, -10]] = amplitude
    return float(np.fft.ifft(spectrum).real.max())


def rms_g(amplitude: float) -> float:
    return float(amplitude * (2 * math.pi) ** 2 * np.sqrt(np.sum(LINES**4.0) / 2.0) / GRAVITY)


def peak_of_sum(amplitude: float) -> float:
    """mm, of the multisine that the door's study has."""
    signal = Multisine(1.0, 100.0, amplitude, 1.0, 1)
    return float(np.abs(signal.derivative(np.arange(0.0, 1.0, 1e-4), 0)).max())


def row(start: str) -> list[str]:
    text = (ROOT / "docs" / "door.md").read_text(encoding="utf-8")
    (found,) = (x for x in text.splitlines() if x.startswith(f"| {start}"))
    return [cell.strip() for cell in found.strip("|").split("|")]


def test_the_inverse_fft_leaves_amplitudes_like_the_doors():
    loads = thesis()["loads"]
    assert line(1.9) == pytest.approx(2 * 1.9 / SAMPLES, rel=1e-12)
    for name in WITH_CONTACT:
        assert 1.7 < LOADS[name] / line(loads[name]["amplitude"]) < 1.8
        assert 279 < loads[name]["amplitude"] / LOADS[name] < 284


@pytest.mark.parametrize(
    ("start", "amplitude"),
    [
        ("table 3.4", 1.9),
        ("1.9 mm through", line(1.9)),
        ("the peak of the sum", 1.9 * 1.9 / peak_of_sum(1.9)),
        ("creak, A4", LOADS["A4"]),
    ],
)
def test_each_row_of_the_page_is_its_arithmetic(start, amplitude):
    _, shown, displacement, acceleration, closes = row(start)
    assert float(shown) == pytest.approx(amplitude, rel=0.01)  # two digits
    assert float(displacement) == pytest.approx(amplitude * math.sqrt(50), rel=0.02)
    assert float(acceleration) == pytest.approx(rms_g(amplitude), rel=0.01)
    assert float(closes.replace(",", "")) == pytest.approx(5.9 * amplitude / LOADS["A4"], rel=0.02)
