"""The report as a reader sees it: it plays, sorts, links its cursors, and stays within the screen."""

import csv
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

SCREENSHOTS = Path(__file__).parents[2] / "build" / "screenshots"
PLOTS = ("force", "gap", "mac", "spectra", "energy", "precheck")


def seen(page, query):
    """The element, scrolled to."""
    element = page.locator(query).first
    element.scroll_into_view_if_needed()
    return element


def draw_all(page):
    """Scroll through, so that everything is drawn."""
    for name in PLOTS:
        seen(page, f"#plot-{name}")
        page.wait_for_selector(f"#plot-{name} .main-svg", state="attached")
    seen(page, "#view-motion")
    page.wait_for_selector("#view-motion.ready canvas")


def moving(page):
    """The view of the motion, ready and at rest."""
    seen(page, "#view-motion")
    page.wait_for_selector("#view-motion.ready")
    if page.inner_text("#play") != "Play":
        page.click("#play")
    return "#view-motion canvas"


def pixels(page, query):
    """The canvas as drawn now, after two frames."""
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return page.evaluate("q => document.querySelector(q).toDataURL()", query)


def test_everything_is_drawn_without_errors_and_nothing_is_fetched(opened):
    """On a wide screen no section is empty or overflows it, no table is cut; for people a picture of each in build/."""
    page = opened()
    draw_all(page)
    assert page.problems == []
    assert page.locator("#view-places canvas").count() == 1
    assert len(set(pixels(page, "#view-places canvas"))) > 20
    assert page.locator("#precheck .scroll").count() == 1
    cut = "[...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth + 1)"
    assert page.evaluate(f"{cut}.map(e => e.closest('section').id)") == []
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    sections = page.locator("section[id]")
    names = [sections.nth(k).get_attribute("id") for k in range(sections.count())]
    assert len(names) == len(set(names)) > 8
    for name in names:
        picture = seen(page, f"section#{name}").screenshot(path=SCREENSHOTS / f"{name}.png")
        box = page.locator(f"section#{name}").bounding_box()
        assert box["height"] > 60
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 1300
        assert len(picture) > 3_000, name  # an empty one of this size has less


def test_animation_plays_and_stops(opened):
    page = opened()
    canvas = moving(page)
    words, before = page.inner_text("#frame-counter"), pixels(page, canvas)
    page.click("#play")
    page.wait_for_function("was => document.getElementById('frame-counter').textContent !== was", arg=words)
    page.click("#play")
    assert page.inner_text("#play") == "Play"
    stopped = page.inner_text("#frame-counter")
    assert pixels(page, canvas) != before
    page.wait_for_timeout(300)
    assert page.inner_text("#frame-counter") == stopped
    assert page.problems == []


def test_parts_exaggeration_event_and_turning_change_the_view(opened):
    page = opened()
    canvas = moving(page)
    looks = [pixels(page, canvas)]
    page.click("#parts-motion button:has-text('UPPER')")
    looks.append(pixels(page, canvas))
    page.evaluate(
        "e => { e = document.getElementById('exaggeration'); e.value = 0.8; e.dispatchEvent(new Event('input')); }"
    )
    looks.append(pixels(page, canvas))
    page.select_option("#motion-event", "1")
    looks.append(pixels(page, canvas))
    page.focus(canvas)
    page.keyboard.press("ArrowLeft")
    looks.append(pixels(page, canvas))
    assert len(set(looks)) == 5
    page.click("#parts-motion button:has-text('UPPER')")  # shown again: the page is that of the other tests too


def test_a_place_leads_to_its_motion(opened):
    page = opened()
    moving(page)
    page.select_option("#motion-event", "2")
    words = page.inner_text("#frame-counter")
    page.locator("[data-animate]").first.click()
    page.wait_for_function("document.getElementById('motion-event').value === '0'")
    page.wait_for_function("was => document.getElementById('frame-counter').textContent !== was", arg=words)
    moving(page)


def test_events_sort_by_keyboard_both_ways(opened):
    page = opened()
    heading = page.locator("#events table.sortable th button").nth(3)
    heading.focus()
    column = (
        "[...document.querySelector('#events table.sortable').tBodies[0].rows].map(r => figure(r.cells[3].textContent))"
    )
    page.keyboard.press("Enter")
    up = page.evaluate(column)
    page.keyboard.press("Enter")
    down = page.evaluate(column)
    assert len(up) > 2
    assert up == sorted(up)
    assert down == sorted(up, reverse=True)
    assert up != down
    assert page.locator("#events th[aria-sort=descending]").count() == 1


def test_csv_holds_every_event_of_both_runs(opened, tmp_path):
    page = opened()
    with page.expect_download() as download:
        page.click("button[data-csv]")
    download.value.save_as(tmp_path / "events.csv")
    rows = list(csv.DictReader((tmp_path / "events.csv").read_text().splitlines()))
    shown = page.locator("#events table.sortable").first.locator("tbody tr").count()
    assert len([r for r in rows if r["run"] == "reference"]) == shown
    assert {r["run"] for r in rows} == {"reduced", "reference"}
    assert all(float(r["force_N"]) > 0.0 for r in rows)
    assert all(float(r["t_start_s"]) < float(r["t_end_s"]) for r in rows)


def test_cursors_and_zoom_of_force_and_gap_are_linked(opened):
    page = opened()
    for name in ("force", "gap"):
        seen(page, f"#plot-{name}")
        page.wait_for_selector(f"#plot-{name} .cursor", state="attached")
    box = page.locator("#plot-force").bounding_box()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_selector("#plot-gap .cursor:not([hidden])", state="attached")
    left = page.evaluate(
        "['force', 'gap'].map(n => wires[n].at._fullLayout.xaxis.p2d("
        "parseFloat(wires[n].bar.style.left) - wires[n].at._fullLayout.xaxis._offset))"
    )
    assert left[0] == pytest.approx(left[1], abs=1e-6)
    assert "tip gap" in page.inner_text("#readout")
    page.evaluate("Plotly.relayout('plot-force', { 'xaxis.range': [0.025, 0.03] })")
    page.wait_for_function("document.getElementById('plot-gap').layout.xaxis.range[1] === 0.03")
    page.evaluate("Plotly.relayout('plot-gap', { 'xaxis.range': [0.026, 0.031] })")
    page.wait_for_function("document.getElementById('plot-force').layout.xaxis.range[0] === 0.026")


def luminance(colour):
    return sum(float(x) for x in colour.split("(")[1].rstrip(")").split(",")[:3]) / 3


def test_dark_and_light_follow_the_system_and_the_button(opened):
    paper, title = (
        "getComputedStyle(document.body).backgroundColor",
        "getComputedStyle(document.querySelector('#plot-force .ytitle')).fill",
    )
    light, dark = opened(scheme="light"), opened(scheme="dark")
    for page in (light, dark):
        seen(page, "#plot-force")
        page.wait_for_selector("#plot-force .ytitle")
    assert luminance(light.evaluate(paper)) > 240 > 100 > luminance(light.evaluate(title))
    assert luminance(dark.evaluate(paper)) < 40 < 150 < luminance(dark.evaluate(title))
    dark.click("#theme")
    dark.wait_for_function(f"{title} !== 'rgb(230, 234, 238)'")
    assert luminance(dark.evaluate(paper)) > 240
    assert luminance(dark.evaluate(title)) < 100
    assert light.problems == dark.problems == []


def test_no_sideways_scrolling_on_narrow_screens(opened):
    page = opened(360)
    draw_all(page)
    for width in (360, 768):  # the second by turning the screen
        page.set_viewport_size({"width": width, "height": 900})
        page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        cut = page.evaluate(
            "[...document.querySelectorAll('main p, main h1, main h2, main select, main .view, main .plot')]"
            ".filter(e => e.getBoundingClientRect().right > innerWidth + 1).map(e => e.outerHTML.slice(0, 80))"
        )
        assert cut == []


def test_every_player_loads_and_plays(opened, strips):
    """As long as the window."""
    first, last = strips[0].window
    page = opened()
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
        assert found[0] == pytest.approx(last - first, abs=2e-3)
