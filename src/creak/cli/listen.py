"""`creak listen`: the sound of an earlier run as WAV files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import typer

from creak.cli.joined import joined
from creak.cli.output import OUTPUT, Output, writable_file, writable_folder
from creak.errors import InputError

if TYPE_CHECKING:
    from creak.studies.sound.beside import SoundComparison

PICTURE = "beside.png"


Gain = tuple[float | None, Path | None, float | None]
"""Of recordings: Pa of full scale; or the recording of a calibrator and its level, dB."""


def _gain(
    calibration: float | None = typer.Option(
        None, "--calibration", metavar="PA_PER_FULL_SCALE", help="Pressure of full scale of the recordings, Pa."
    ),
    calibrator: Path | None = typer.Option(
        None, "--calibrator", metavar="WAV", help="Instead: recording of a calibrator with the same gain."
    ),
    level: float | None = typer.Option(None, "--level", metavar="DB", help="Level of the calibrator, dB re 20 uPa."),
) -> Gain:
    return calibration, calibrator, level


def listen(
    folder: Path = typer.Argument(..., metavar="RESULTS", help="Folder that `creak run` wrote."),
    out: Path | None = typer.Option(
        None, "--out", metavar="DIR", help="Folder for the files; default: sound/ in RESULTS."
    ),
    samples: Literal["16", "24", "float"] = typer.Option("24", "--samples", help="Bits of a sample, or floats of 32."),
    beside: list[Path] = typer.Option(
        [], "--beside", metavar="WAV", help="Recording to be compared with what was computed. Repeatable."
    ),
    gain: Gain = joined(_gain),
    listener: str | None = typer.Option(
        None, "--listener", metavar="NAME", help="Whose sounds are compared; default: those of the first."
    ),
    output: Output = OUTPUT,
) -> None:
    """Write WAV files of 48 kHz: what each listener hears of each place by itself, and of all contact together.
    Files of a listener that faces somewhere have two channels, its left and its right ear.

    All have the same full scale, which their comment tells in Pa. Nothing outside the band in which the model can be
    believed is in them.

    With --beside: loudness, level, sharpness (acum), roughness (asper) and prominence (P) of the sounds and of
    recordings in one table, and N(t) and third octaves in one picture, beside.png.

    Example: creak listen RESULTS --out FOLDER
    """
    from creak.api.compare import compare_sounds
    from creak.formats.measured.recordings import read_recordings
    from creak.formats.stored.sound import read_sound, write_sound
    from creak.formats.wav import full_scale_level

    target = out if out is not None else folder / "sound"
    if not beside and any(x is not None for x in (*gain, listener)):
        raise InputError("a calibration or a listener without a recording", fix="Give --beside recording.wav, too.")
    with output:
        recordings = [r for path in beside for r in read_recordings(path, *gain)]
        sound = read_sound(folder)
        compared = compare_sounds(folder, recordings, listener=listener) if recordings else None
        writable_folder(target)
        if compared is not None:
            writable_file(target / PICTURE)
        output.wrote(*write_sound(sound, target, samples))
        level = full_scale_level(sound.full_scale)
        output.say(
            f"{sound.band[0]:.0f} to {sound.band[1]:.0f} Hz, nothing outside; full scale {sound.full_scale:.4g} Pa, "
            f"a full-scale sine is {level:.0f} dB re 20 uPa"
        )
        if compared is not None:
            _tell(output, compared, target)
        output.tell_written()
        output.result(
            {
                **({} if compared is None else {"compared": compared.as_dict()}),
                "written": [str(path) for path in output.written],
                "band": list(sound.band),
                "full_scale_pa": sound.full_scale,
                "full_scale_sine_db": level,
            }
        )


def _tell(output: Output, compared: SoundComparison, folder: Path) -> None:
    """Table and picture of recordings beside the run's sounds."""
    from creak.api.extras import missing_for_report, no_report_text
    from creak.report.sounds_beside import reasons, rows, write_picture

    output.table(f"At {compared.listener}, the loudest first; N in sone", rows(compared))
    for text in compared.warnings:
        output.warn(text)
    for text in (*compared.notes, *reasons(compared)):
        output.say(text)
    if missing_for_report():
        output.warn(no_report_text())
    else:
        picture = folder / PICTURE
        write_picture(compared, picture)
        output.wrote(picture)
