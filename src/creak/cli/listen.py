"""`creak listen`: the sound of an earlier run as WAV files."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import typer

from creak.cli.output import AS_JSON, QUIET, VERBOSE, Output, writable_folder


def listen(
    folder: Path = typer.Argument(..., metavar="RESULTS", help="Folder that `creak run` wrote."),
    out: Path | None = typer.Option(
        None, "--out", metavar="DIR", help="Folder for the files; default: sound/ in RESULTS."
    ),
    samples: Literal["16", "24", "float"] = typer.Option("24", "--samples", help="Bits of a sample, or floats of 32."),
    quiet: bool = QUIET,
    verbose: bool = VERBOSE,
    as_json: bool = AS_JSON,
) -> None:
    """Write WAV files of 48 kHz: what each listener hears of each place by itself, and of all contact together.

    All have the same full scale, which their comment tells in Pa. Nothing outside the band in which the model can be
    believed is in them.

    Example: creak listen RESULTS --out FOLDER
    """
    from creak.formats.stored.sound import read_sound, write_sound
    from creak.formats.wav import full_scale_level

    target = out if out is not None else folder / "sound"
    with Output(quiet, verbose, as_json) as output:
        sound = read_sound(folder)
        writable_folder(target)
        output.wrote(*write_sound(sound, target, samples))
        level = full_scale_level(sound.full_scale)
        output.say(
            f"{sound.band[0]:.0f} to {sound.band[1]:.0f} Hz, nothing outside; full scale {sound.full_scale:.4g} Pa, "
            f"a full-scale sine is {level:.0f} dB re 20 uPa"
        )
        output.tell_written()
        output.result(
            {
                "written": [str(path) for path in output.written],
                "band": list(sound.band),
                "full_scale_pa": sound.full_scale,
                "full_scale_sine_db": level,
            }
        )
