"""The sounds in the page are heard in a real browser: they load, are as long as the window, and play."""

from pathlib import Path

import pytest

from creak.report.found import found_of
from creak.report.html import write_page
from creak.studies.results.places import find_places
from creak.studies.results.summary import summarise
from creak.studies.run.compared import main_run
from creak.studies.sound.heard import Sound, hear

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def heard(strips) -> tuple[Path, float]:
    """A page with players, and the seconds that each plays."""
    result, folder = strips
    sound = hear(result, [p.channels for p in find_places(result, main_run(result.runs))])
    assert isinstance(sound, Sound), sound
    path = folder / "heard.html"
    write_page(found_of(result, sound=sound), summarise(result, sound=sound), path)
    first, last = result.window
    return path, last - first


def test_every_player_loads_and_plays(heard, chromium):
    path, seconds = heard
    page = chromium.new_page()
    page.goto(path.as_uri())
    count = page.locator("audio").count()
    assert count > 1
    for k in range(count):
        page.evaluate(
            """k => { const a = document.querySelectorAll("audio")[k]; a.muted = true; window.heard = a;
                      a.preload = "auto"; return a.play(); }""",
            k,
        )
        page.wait_for_function("() => window.heard.currentTime > 0.02 || window.heard.ended")
        found = page.evaluate("() => [window.heard.duration, window.heard.error && window.heard.error.message]")
        assert found[1] is None
        assert found[0] == pytest.approx(seconds, abs=2e-3)
    page.close()
