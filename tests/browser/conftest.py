"""A report of two strips that rattle, opened in a real browser; without one these tests are skipped."""

import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "unit" / "report"))

from small_study import plates, study_text

from creak.report.html import write_page
from creak.studies.file.reader import read_study
from creak.studies.findings.places import find_places
from creak.studies.prepare.setup import set_up
from creak.studies.run.job import StudyResult, run_study
from creak.studies.sound.heard import Sound
from helpers_decks import write_study
from helpers_findings import sound_of, to_draw

MULTISINE = '{ type = "multisine", f_min = 20, f_max = 100, amplitude = 0.25, period = 0.15, seed = 3 }'
FLAGS = ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-angle=swiftshader"]


def study() -> str:
    """The two strips, shaken long enough for events far apart."""
    text = study_text().replace('{ type = "sine", frequency = 50, amplitude = 0.8 }', MULTISINE)
    return text.replace("end = 0.04", "end = 0.15")


@pytest.fixture(scope="session")
def strips(tmp_path_factory: pytest.TempPathFactory) -> tuple[StudyResult, Path]:
    """A run with recorded motion, and its folder."""
    folder = tmp_path_factory.mktemp("browser")
    return run_study(
        set_up(read_study(write_study(folder, study(), {"plates.inp": plates()}))), lambda *_: None, record=True
    ), folder


@pytest.fixture(scope="session")
def report(strips: tuple[StudyResult, Path]) -> Path:
    """Its report.html, with a player for each place and one for all."""
    result, folder = strips
    sound = sound_of(result, [p.channels for p in find_places(result.scope, result.main)])
    assert isinstance(sound, Sound), sound
    write_page(*to_draw(result, sound=sound), folder / "report.html")
    return folder / "report.html"


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """The machine's own Chromium."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no Chromium on this machine")
    with playwright.sync_playwright() as p:
        browser = p.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def opened(report: Path, chromium: Any) -> Iterator[Callable[..., Any]]:
    """Opens the report at a width and colour scheme, once each; the page lists what went wrong in `problems`."""
    pages: dict[tuple[int, str], Any] = {}

    def open_at(width: int = 1300, scheme: str = "light") -> Any:
        if (width, scheme) in pages:
            return pages[width, scheme]
        page = chromium.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
        pages[width, scheme] = page
        page.problems = []
        page.on("console", lambda m: page.problems.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda e: page.problems.append(str(e)))
        page.on("request", lambda r: page.problems.append(r.url) if r.url.startswith("http") else None)
        page.goto(report.as_uri())
        return page

    yield open_at
    for page in pages.values():
        page.close()
