"""What signals say of themselves, against the functions of time that they make."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from creak.signals import sources
from creak.studies.file.signals.tables import SignalTable

TABLES = {
    "multisine": {"f_min": 2, "f_max": 40, "amplitude": 0.3, "period": 0.5, "seed": 7},
    "sine": {"frequency": 8, "amplitude": 2.0},
    "step": {"amplitude": 3.0},
    "table": {"values": [[0, 0], [0.5, 1], [1, 0]]},
    "record": {"file": "acc.csv", "high_pass": 5},
    "smooth-step": {"values": [[0, 0], [1, 2]]},
    "periodic": {"frequency": 4, "cosine": [1.0], "sine": [0.0, 0.5, 0.25]},
    "psd": {"unit": "unit2/Hz", "values": [[5, 1], [60, 2]], "duration": 2.0, "seed": 3},
    "sweep": {"f_start": 50, "f_end": 10, "amplitude": 1.0, "duration": 2.0},
    "half-sine": {"amplitude": 5.0, "duration": 0.02},
    "trapezoid": {"amplitude": 5.0, "rise": 0.01, "hold": 0.02, "fall": 0.04},
}


def signal(kind):
    return TypeAdapter(SignalTable).validate_python({"type": kind, **TABLES[kind]})


def test_every_signal_is_here():
    members = get_args(get_args(SignalTable)[0])
    assert {get_args(m.model_fields["type"].annotation)[0] for m in members} == set(TABLES)


@pytest.mark.parametrize("kind", ["multisine", "sine", "periodic"])
def test_signals_repeat_after_their_period(kind):
    s = signal(kind)
    t = np.linspace(0.0, 0.2, 41)
    x = s.made().values(t)
    assert np.ptp(x) > 0.1
    assert s.made().values(t + s.repeats) == pytest.approx(x, abs=1e-12)
    assert not np.allclose(s.made().values(t + 0.5 * s.repeats), x, atol=0.1 * np.ptp(x))


@pytest.mark.parametrize("kind", ["multisine", "sine", "periodic"])
def test_the_highest_frequency_is_the_last_line_of_the_spectrum(kind):
    s = signal(kind)
    t = np.arange(1000) / 1000.0  # 1 s: lines at whole Hz
    lines = np.flatnonzero(np.abs(np.fft.rfft(s.made().values(t))) > 1e-9 * t.size)
    assert s.stated
    assert s.highest == lines[-1]


@pytest.mark.parametrize(("kind", "share"), [("half-sine", 0.95), ("trapezoid", 0.85)])
def test_most_of_a_shock_lies_below_its_highest_frequency(kind, share):
    s = signal(kind)
    t = np.arange(20_000) / 10_000.0
    power = np.abs(np.fft.rfft(s.made().values(t))) ** 2
    below = np.fft.rfftfreq(t.size, t[1]) <= s.highest
    assert not s.stated
    assert share < power[below].sum() / power.sum() < 1.0
    assert s.resolving < 0.2 / s.highest


def test_what_other_signals_say():
    assert {k: signal(k).highest for k in ("step", "table", "record", "smooth-step")} == dict.fromkeys(
        ("step", "table", "record", "smooth-step"), 0.0
    )
    assert (signal("sweep").highest, signal("psd").highest, signal("psd").repeats) == (50, 60, 2.0)
    assert {k for k in TABLES if signal(k).random is not None} == {"multisine", "psd"}
    assert {k for k in TABLES if signal(k).repeats is None} == set(TABLES) - {"multisine", "sine", "periodic", "psd"}
    assert {k for k in TABLES if signal(k).made() is None} == {"record", "psd"}


def test_words_hold_the_numbers_as_the_reader_shows_them():
    said = {k: signal(k).words("mm", lambda x: f"<{x:g}>") for k in TABLES}
    assert said["multisine"] == "multisine <2> to <40> Hz, <0.3> mm a line, period <0.5> s, seed 7"
    assert said["trapezoid"] == "trapezoidal shock of <0.01>, <0.02> and <0.04> s, <5> mm"
    assert said["periodic"] == "periodic, <4> Hz, 3 term(s), mm"
    assert said["record"] == "record acc.csv, above <5> Hz"
    assert len(set(said.values())) == len(TABLES)


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"type": "multisine", "f_max": 100.0, "amplitude": 1.0}, "period"),
        ({"type": "psd", "unit": "unit2/Hz", "values": [[1.0, 1.0], [100.0, 1.0]]}, "duration"),
    ],
)
@pytest.mark.parametrize("length", [1e6, 1e30, 1e59])
def test_the_lines_of_a_signal_have_a_bound_that_is_told(table, key, length):
    """Before anything is computed: 1e6 s of a multisine up to 100 Hz took 62 GiB."""
    with pytest.raises(ValidationError, match=r"lines, 1 / .* a signal has at most 10*,0"):
        TypeAdapter(SignalTable).validate_python({**table, key: length})


def test_a_multisine_of_many_lines_and_instants_is_summed_in_blocks(monkeypatch):
    """The same to round-off of a sum of 50 cosines, whatever memory holds at once."""
    t, signal = np.linspace(0.0, 1.0, 400), sources.Multisine(1.0, 50.0, 1.0)
    whole = [signal.derivative(t, order) for order in (0, 2)]
    monkeypatch.setattr(sources, "AT_ONCE", 120)
    for order, x in zip((0, 2), whole, strict=True):
        np.testing.assert_allclose(
            signal.derivative(t, order), x, atol=50 * 2e-16 * np.abs(signal.lines[0][-1]) ** order * 50
        )
