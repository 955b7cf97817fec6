"""The pages of modes, functions and time histories beside a test as a reader sees them."""

import numpy as np
import pytest

import creak
from creak.formats.measured.histories import read_histories
from creak.report.correlation_page import write_correlation, write_records
from creak.studies.models.beside_test import deck_beside_test
from helpers_decks import STUDY, write_strips
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


@pytest.fixture(scope="module")
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


def test_a_run_beside_time_histories_of_a_test(chromium, tmp_path):
    """A list chooses the channel; the course, the spectrum and the contacts are drawn."""
    study = STUDY.replace("periods = 2", "periods = 1") + '[reference]\nrun = "none"\n'
    creak.run(write_strips(tmp_path, study=study)).save(tmp_path / "out")
    run = read_histories(tmp_path / "out" / "results.h5")
    rows = zip(run.time, run.displacement[:, 0, 2], run.normal_force.sum(axis=1), strict=True)
    lines = [f"time,{run.node_names[0]} z,tip force", *(",".join(f"{x:.9g}" for x in row) for row in rows)]
    (tmp_path / "test.csv").write_text("\n".join(lines))
    write_records(creak.compare_records(tmp_path / "out", tmp_path / "test.csv"), tmp_path / "records.html")
    page, problems = chromium.new_page(viewport={"width": 1300, "height": 900}), []
    page.on("pageerror", lambda e: problems.append(str(e)))
    page.goto((tmp_path / "records.html").as_uri())
    page.wait_for_selector("#plot-records .main-svg", state="attached")
    count = "document.querySelectorAll('#plot-records .scatterlayer .js-line').length"
    assert page.evaluate(count) == 4
    page.select_option("select[data-chooses=records]", "1")
    page.wait_for_function(f"{count} > 4")
    assert "tip force, N" in page.locator("#plot-records").inner_text()
    assert page.locator("#channels tbody tr").count() == 2
    assert problems == []
    page.close()
