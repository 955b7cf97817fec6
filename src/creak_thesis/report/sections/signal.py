"""From the road record to the excitation (thesis 3.1.1 and 3.2)."""

from __future__ import annotations

from creak.report_tools import NONE, Table, fixed, number, tidy
from creak_thesis.record import HIGH_PASS, RecordStudy
from creak_thesis.report.blocks import Section, TableBlock, Text, absent, agree, differ
from creak_thesis.report.facts import thesis
from creak_thesis.report.figures import density_figure, record_line


def signal_section(study: RecordStudy | None) -> Section:
    section = Section("signal", "The road record and the excitation")
    if study is None:
        section.blocks.append(absent("The record was not studied."))
        return section
    section.blocks += [
        Text(
            "The thesis's record of the Pave track is confidential. creak makes one of the same length, rate and "
            "peak: a random motion between 7.5 and 95 Hz whose displacement is known exactly, measured by a sensor "
            "with an offset, a slow wander and white noise."
        ),
        record_line(
            "Figure 3.1",
            study,
            study.drifting / 1e3,
            "m",
            "Acceleration integrated twice in time: the "
            "sensor's offset and wander become a drift that hides the motion.",
        ),
        record_line(
            "Figure 3.2",
            study,
            study.filtered,
            "mm",
            f"The same by omega arithmetic, all content below {HIGH_PASS:g} Hz dropped.",
        ),
        density_figure(
            "Figure 3.3",
            study,
            "One-sided density of the measured acceleration; shaded: where it stands "
            "ten times above the sensor's noise.",
        ),
        TableBlock("Section 3.1.1 and 3.2 in numbers", _table(study)),
        agree(_agree(study), study.drift > study.peak),
        differ(_differ(study)),
    ]
    return section


def _table(study: RecordStudy) -> Table:
    t = thesis()["signal"]
    band = f"{number(study.band[0], 3)}–{number(study.band[1], 3)}"
    rows = [
        ["length, s", tidy(t["duration"]), tidy(study.duration)],
        ["sampling, Hz", number(int(t["rate"])), number(int(study.rate))],
        ["drift at the end, mm", NONE, number(study.drift, 3)],
        ["mean after the cut, mm", "0", number(study.mean, 2) if abs(study.mean) > 1e-9 else "0"],
        ["peak displacement after the cut, mm", tidy(t["peak"]), fixed(study.peak, 4)],
        ["true peak, mm", NONE, fixed(study.true_peak, 4)],
        ["error against the truth, root mean square, mm", NONE, number(study.error_rms, 3)],
        ["the same as theory has it for the noise, mm", NONE, number(study.error_expected, 3)],
        ["largest error, mm", NONE, number(study.error_max, 3)],
        ["content, Hz", f"below {t['f_max']:g}", band],
        ["excitation: sines up to, Hz", tidy(t["f_max"]), tidy(study.signal.f_max)],
        ["excitation: amplitude of each sine, mm", tidy(t["peak"]), fixed(study.signal.amplitude, 4)],
        ["excitation: peak of their sum, mm", NONE, fixed(study.signal_peak, 1)],
        ["signal type record of a study file: largest error, mm", NONE, number(study.record_signal_error, 3)],
    ]
    return Table(["", "thesis", "creak"], rows)


def _agree(study: RecordStudy) -> str:
    drifts = study.drift > study.peak
    first = (
        f"Integrated twice in time the displacement is {number(study.drift / 1e3, 3)} m off at the end"
        if drifts
        else "Integrated twice in time this record does not drift by more than its peak"
    )
    return (
        f"{first}; omega arithmetic with a cut at {HIGH_PASS:g} Hz has zero mean and a peak of "
        f"{fixed(study.peak, 3)} mm. The content ends at {number(study.band[1], 3)} Hz, so that a multisine up to "
        f"{study.signal.f_max:g} Hz covers it."
    )


def _differ(study: RecordStudy) -> str:
    return (
        "The thesis could only see that the mean is zero; here the truth is known, and what is left after the cut is "
        f"the sensor's noise above it: {number(study.error_rms, 2)} mm by measurement, "
        f"{number(study.error_expected, 2)} "
        "mm by theory. The thesis takes the record's peak as the amplitude of every sine: the sum of the sines then "
        f"peaks at {fixed(study.signal_peak, 1)} mm, {study.signal_peak / study.peak:.0f} times the record. creak "
        "therefore sets the amplitudes by the number of contact events (table 3.4), and can also drive a study with "
        "the record itself: as signal type record it stays within "
        f"{number(study.record_signal_error, 2)} mm of the truth."
    )
