"""The page of modes beside a test as a reader sees it."""

import numpy as np
import pytest

from creak.report.correlation_page import write_correlation
from creak.studies.models.beside_test import deck_beside_test
from helpers_frfs import function
from helpers_modal import COUNT, every_mode, measured_strip, points_15, strip_deck

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The page of a clamped strip, in place of that of a run."""
    folder = tmp_path_factory.mktemp("correlation")
    deck, test = strip_deck(folder), folder / "test.unv"
    t, freq = measured_strip(deck)[1], np.linspace(10.0, 1000.0, 200)
    functions = [function(1.0 / (1.0 + 1j * freq / f), (n, 3), (39, 3), freq=freq) for n, f in ((7, 90.0), (39, 400.0))]
    test.write_bytes((points_15(t) + every_mode(t)).encode() + b"".join(functions))
    write_correlation(deck_beside_test(deck, test), folder / "page.html")
    return folder / "page.html"


@pytest.fixture
def opened(report, chromium):
    page = chromium.new_page(viewport={"width": 1300, "height": 900})
    page.problems = []
    page.on("console", lambda m: page.problems.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda e: page.problems.append(str(e)))
    page.goto(report.as_uri())
    yield page
    page.close()


def test_maps_and_shapes_are_drawn_pair_by_pair(opened):
    page = opened
    for name in ("mac", "auto"):
        page.locator(f"#plot-{name}").scroll_into_view_if_needed()
        page.wait_for_selector(f"#plot-{name} .main-svg", state="attached")
    page.locator("#view-motion").scroll_into_view_if_needed()
    page.wait_for_selector("#view-motion.ready canvas")
    assert page.locator("#motion-event option").count() == COUNT

    def pixels():
        page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        return page.evaluate("document.querySelector('#view-motion canvas').toDataURL()")

    first = pixels()
    page.select_option("#motion-event", "1")
    second = pixels()
    page.get_by_role("button", name="measured points").click()
    assert len({first, second, pixels()}) == 3
    assert page.locator("#pairs tbody tr").count() == COUNT
    assert page.problems == []


def test_a_list_chooses_the_function(opened):
    page = opened
    page.locator("#plot-frfs").scroll_into_view_if_needed()
    page.wait_for_selector("#plot-frfs .main-svg", state="attached")
    drawn = "[...document.querySelectorAll('#plot-frfs .scatterlayer .js-line')].map(l => l.getAttribute('d')).join()"
    first = page.evaluate(drawn)
    page.select_option("select[data-chooses=frfs]", "1")
    page.wait_for_function(f"({drawn}) !== {first!r}")
    assert page.evaluate(f"({drawn}).split('M').length") == first.count("M") + 1
    page.get_by_role("button", name="dark / light").click()
    page.wait_for_timeout(300)
    assert page.evaluate(drawn) != first
    assert page.problems == []
