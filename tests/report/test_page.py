"""The report in a real browser: it asks for nothing, sorts, filters, and keeps nobody out."""

from typing import Any

import pytest

from tests.browser import without_tools

WIDE, NARROW, NIGHT = (
    {"viewport": {"width": 1280, "height": 900}},
    {"viewport": {"width": 390, "height": 844}},
    {"color_scheme": "dark"},
)


@pytest.fixture
def page(browser: Any, report: Any, request: pytest.FixtureRequest) -> Any:
    context = browser.new_context(**WIDE | getattr(request, "param", {}))
    context.set_default_timeout(20_000)
    opened, complaints, requests = context.new_page(), [], []
    opened.on("console", lambda message: complaints.append(message.text))
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("request", lambda request: requests.append(request.url))
    opened.goto(report.as_uri())
    yield opened
    context.close()
    assert complaints == []
    assert [url for url in requests if not url.startswith(("data:", "blob:"))] == [report.as_uri()]


def column(page: Any, table: str, at: int) -> list[str]:
    """Keys of the rows that a table shows, in order."""
    script = """([table, at]) => [...document.querySelectorAll(`[id$="${table}"] tbody tr:not([hidden])`)]
        .map((row) => key(row.cells[at]))"""
    return list(page.evaluate(script, [table, at]))


def test_a_table_sorts_by_numbers_both_ways_and_filters(page):
    table = page.locator('[id$="-comparison"]')
    before = column(page, "-comparison", 4)
    headings = column(page, "-comparison", 3)
    assert len(set(headings)) == 1  # one metric at first
    heading = table.get_by_role("button", name="value")
    heading.focus()
    page.keyboard.press("Enter")
    rising = [float(each) for each in column(page, "-comparison", 4) if each]
    assert rising == sorted(rising)
    assert sorted(map(float, filter(None, before))) == rising
    assert table.locator("th[aria-sort]").get_attribute("aria-sort") == "ascending"
    heading.click()
    assert [float(each) for each in column(page, "-comparison", 4) if each] == rising[::-1]
    agent = table.get_by_role("combobox", name="agent", exact=True)
    chosen = agent.locator("option").nth(1).text_content()
    agent.select_option(chosen)
    assert set(column(page, "-comparison", 0)) == {chosen}
    assert f"{len(column(page, '-comparison', 0))} of " in table.locator("output").inner_text()


def test_what_is_not_known_comes_last(page):
    at, table = 5, page.locator('[id$="-runs"]').first  # cycle duration; random action has none
    table.get_by_role("combobox", name="experiment").select_option("")
    table.get_by_role("button", name="cycle duration").click()
    name = table.get_attribute("id")
    for _ in range(2):
        keys = column(page, name, at)
        known = [each for each in keys if each]
        assert 0 < len(known) <= len(keys)
        assert keys[: len(known)] == known
        table.get_by_role("button", name="cycle duration").click()


def test_claims_are_filtered_by_verdict_and_words(page):
    claims = page.locator(".claims")
    everything = claims.locator(".claim:visible").count()
    button = claims.locator(".verdicts button").nth(1)
    button.click()
    shown = claims.locator(".claim:visible")
    assert shown.count() == int(button.locator(".count").inner_text()) < everything
    assert set(shown.evaluate_all("them => them.map((it) => it.dataset.verdict)")) == {
        button.get_attribute("data-verdict")
    }
    claims.get_by_role("searchbox").fill("no such words")
    assert shown.count() == 0
    claims.get_by_role("searchbox").fill("")
    claims.locator(".verdicts button").first.click()
    assert claims.locator(".claim:visible").count() == everything


def test_a_claim_has_its_figure_and_its_command(page):
    claim = page.locator(".claim", has=page.locator(".peek")).first
    assert claim.locator("code").inner_text().startswith("crawler-bench reproduce --claim")
    claim.locator(".peek summary").click()
    image = claim.locator("img")
    assert image.evaluate("async (it) => (await it.decode(), it.naturalWidth)") > 300
    assert page.locator(".claim").count() - page.locator(".claim .peek").count() <= 2


def test_films_play(page):
    for film in page.locator("video").all():
        film.evaluate("(it) => it.play()")
        page.wait_for_function("(it) => it.currentTime > 0", arg=film.element_handle())


def first_chart(page: Any) -> Any:
    """The first chart, scrolled to and drawn."""
    chart = page.locator(".chart").first
    chart.scroll_into_view_if_needed()
    page.wait_for_function("(it) => 'drawn' in it.dataset", arg=chart.element_handle())
    return chart


def test_a_chart_is_drawn_when_it_comes_near(page):
    assert page.evaluate("window.Plotly === undefined")
    chart = first_chart(page)
    assert 1 <= page.locator(".chart[data-drawn]").count() < page.locator(".chart").count()
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_function("(it) => it.querySelector('svg').clientWidth < 390", arg=chart.element_handle())


def test_a_curve_says_its_numbers_under_the_pointer(page):
    chart = first_chart(page)
    chart.locator(".scatterlayer .points path").first.hover(force=True)
    page.wait_for_function("document.querySelector('.hoverlayer .hovertext') !== null")
    assert "n = " in chart.locator(".hovertext").first.text_content()


@pytest.mark.parametrize("page", [NIGHT], indirect=True)
def test_paper_is_white_and_shows_figures_in_place_of_what_moves(page):
    page.emulate_media(media="print")
    for name in (".curves", ".films", "nav", ".copy"):
        assert page.locator(name).count() > 0
        assert page.locator(name).locator("visible=true").count() == 0, name
    assert page.locator(".claim:visible").count() == page.locator(".claim").count()
    assert page.locator("#paper-1-fig_3c img").is_visible()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"


@pytest.mark.parametrize("page", [NIGHT, NARROW], indirect=True)
def test_nobody_is_kept_out(page):
    try:
        from axe_playwright_python.sync_playwright import Axe
    except ImportError:
        without_tools("no accessibility checker: pip install axe-playwright-python")

    def violations() -> list[Any]:
        options = {"preload": False, "resultTypes": ["violations"]}
        found = Axe().run(page, options=options).response["violations"]
        return [(each["id"], each["nodes"][0]["html"][:200]) for each in found]

    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    # Rows are all made alike: a few of each tell as much as thousands, which take a minute to check.
    page.evaluate(
        "all(document, 'tbody tr:nth-child(n+4), .policy:nth-child(n+4)').forEach((it) => it.remove())"
    )
    first_chart(page)
    page.locator(".peek summary").first.click()
    page.locator("details.run > summary").first.click()
    assert violations() == []
    page.evaluate(
        "document.querySelector('select').parentElement.replaceWith(document.querySelector('select'))"
    )
    assert [rule for rule, _ in violations()] == ["select-name"]
