"""The page of modes beside a test as a reader sees it."""

import pytest

import creak
from creak.report.correlation_page import write_correlation
from helpers_modal import COUNT, csv_text, measured_strip, strip_deck

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The page of a clamped strip, in place of that of a run."""
    folder = tmp_path_factory.mktemp("correlation")
    deck, test = strip_deck(folder), folder / "test.csv"
    test.write_text(csv_text(measured_strip(deck)[1]))
    write_correlation(creak.correlate(deck, test), folder / "page.html")
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
