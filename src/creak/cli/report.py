"""`creak report`: the report of an earlier run once more."""

from __future__ import annotations

from pathlib import Path

import typer

from creak.cli.output import OUTPUT, Output, writable_file


def report(
    folder: Path = typer.Argument(..., metavar="DIR", help="Folder that `creak run` wrote."),
    out: Path | None = typer.Option(None, "--out", metavar="FILE", help="The page; default: report.html in DIR."),
    output: Output = OUTPUT,
) -> None:
    """Write report.html from summary.json and results.h5 of an earlier run, and convergence.csv where it was made.

    It is the page that the run wrote, but for the time of writing. Neither the deck nor the study is needed: run on one
    machine, without the packages of the report, and look at the page on another.

    Example: creak report door/results
    """
    from creak.api.extras import need_report
    from creak.api.saved import open_result
    from creak.formats.deck.command_files import will_read
    from creak.formats.stored.results import reading
    from creak.formats.stored.run_identity import CONVERGENCE, RESULTS, SUMMARY
    from creak.studies.findings.save import save_convergence
    from creak.studies.findings.summary import unreliable_runs

    will_read(folder / RESULTS, folder / SUMMARY)
    if folder.is_file():
        with reading(folder / SUMMARY):
            pass  # refused, before anything is said of the page in it
    page = out if out is not None else folder / "report.html"
    streamed = writable_file(page, kept=True).stream
    need_report()
    with output:
        with output.progress as progress:
            with progress.phase("read the results"):
                saved = open_result(folder)
            if saved.convergence is not None and not streamed:
                writable_file(page.parent / CONVERGENCE, stream=False)
            with progress.phase(f"write {page.name}"):
                output.wrote(saved.report(page))
                if saved.convergence is not None and not streamed:
                    output.wrote(save_convergence(saved.convergence, page.parent, saved.summary["run"]["id"]))
        for text in unreliable_runs(saved.summary):
            output.warn(f"unreliable: {text}")
        output.tell_written()
        output.result({"written": [str(path) for path in output.written]})
