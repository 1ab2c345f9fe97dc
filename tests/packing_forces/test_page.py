"""The report in a real browser: whole, offline, by keyboard, on a narrow screen."""

from __future__ import annotations

import os
import re
import shutil
from contextlib import redirect_stdout
from html.parser import HTMLParser
from io import StringIO

import pytest

from packing_forces.command_line import main
from tests.conftest import packing

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PICTURES = os.environ.get("PAGE_PICTURES")
"""A folder for screenshots, to be looked at."""
VOID = {"meta", "img", "path", "use", "br", "rect", "circle"}


@pytest.fixture(scope="module")
def page(files):
    """The page of the six-digit dumps, made once."""
    words = (
        "report", files / "atoms.dump", "--contacts", files / "contacts.dump", "--stiffness", "1",
        "--method", "optimal", "--out", files / "report.html",
    )  # fmt: skip
    with redirect_stdout(StringIO()):
        assert main([str(word) for word in words]) == 0
    return files / "report.html"


@pytest.fixture(scope="module")
def browser():
    """A Chromium: that of the system, or the one that playwright brought."""
    sync = pytest.importorskip(
        "playwright.sync_api", reason="the page is opened with playwright (extra test-browser)"
    )
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    with sync.sync_playwright() as playwright:
        if path is None and not os.path.exists(playwright.chromium.executable_path):
            pytest.skip("no Chromium: neither on PATH nor brought by playwright")
        options = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
        made = playwright.chromium.launch(executable_path=path, args=options)
        yield made
        made.close()


class Outline(HTMLParser):
    """Open elements that are never closed, ids, and what the page asks for from elsewhere."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.wanted, self.alts = [], [], [], []

    def handle_starttag(self, tag, attrs):
        known = dict(attrs)
        if tag not in VOID:
            self.open.append(tag)
        if "id" in known:
            self.ids.append(known["id"])
        self.alts += [known.get("alt")] if tag == "img" else []
        self.wanted += [v for k, v in attrs if k in ("src", "href", "xlink:href") and v]

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_is_whole_and_holds_all_it_shows(page):
    text = page.read_text(encoding="utf-8")
    outline = Outline()
    outline.feed(text)
    assert outline.open in ([], ["!DOCTYPE"])
    assert len(outline.ids) == len(set(outline.ids))
    assert all(w.startswith(("data:", "#")) for w in outline.wanted)
    assert all(outline.alts)
    assert len(outline.alts) == 4
    assert "<script" not in text
    assert not re.search(r"@import|url\((?!#)", text)
    for name in ("verdict", "chains", "errors", "curve", "intervals", "checks", "inputs"):
        assert f'id="{name}"' in text
    assert "you are here" in text
    assert "Write dumps with %.10g" in text


def test_a_refusal_is_a_page_too(ask, files, tmp_path):
    code, out, _ = ask(
        "report", files / "atoms.dump", "--contacts", files / "contacts.dump", "--out", "no.html"
    )
    assert code == 1
    assert "written to no.html" in out
    text = (tmp_path / "no.html").read_text(encoding="utf-8")
    assert "give --stiffness" in text
    assert text.count("<img") == 1


def test_names_of_files_are_text(ask, tmp_path):
    """A file called like an element stays a name."""
    name = "<b>&amp;.npz"
    packing(grains=12, delta=1e-2).save(tmp_path / name)
    assert ask("report", name, "--out", "x.html")[0] == 0
    text = (tmp_path / "x.html").read_text(encoding="utf-8")
    assert "<b>" not in text
    assert "&lt;b&gt;&amp;amp;.npz" in text


@pytest.mark.parametrize("width", [1300, 400])
def test_the_page_in_a_browser(page, browser, width):
    """No request leaves the page, nothing is wider than the screen, every picture is drawn."""
    context = browser.new_context(viewport={"width": width, "height": 900}, offline=True)
    tab, asked, complained = context.new_page(), [], []
    tab.on("request", lambda request: asked.append(request.url))
    tab.on("console", lambda message: complained.append(message.text))
    tab.on("pageerror", lambda error: complained.append(str(error)))
    tab.goto(page.as_uri())
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []
    assert complained == []
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    drawn = tab.evaluate("[...document.images].map(i => i.complete && i.naturalWidth > 100)")
    assert drawn == [True] * 4
    if width == 1300:
        left = tab.evaluate(
            "[...document.querySelectorAll('#chains figure')].map(f => f.offsetLeft)"
        )
        assert left[1] > left[0]
    else:
        tops = tab.evaluate(
            "[...document.querySelectorAll('#chains figure')].map(f => f.offsetTop)"
        )
        assert tops[1] > tops[0]
    assert tab.title() == "Forces in atoms.dump"
    if PICTURES:
        tab.screenshot(path=f"{PICTURES}/report-{width}.png", full_page=True)
    context.close()


def test_the_page_by_keyboard(page, browser):
    """Tab goes to the link past the head, the tables that scroll, and what folds; Enter opens."""
    tab = browser.new_page()
    tab.goto(page.as_uri())
    seen = []
    for _ in range(6):
        tab.keyboard.press("Tab")
        seen.append(tab.evaluate("document.activeElement.tagName"))
        if seen[-1] == "SUMMARY":
            break
    assert seen[0] == "A"
    assert "DIV" in seen
    assert seen[-1] == "SUMMARY"
    assert not tab.evaluate("document.querySelector('details').open")
    tab.keyboard.press("Enter")
    assert tab.evaluate("document.querySelector('details').open")
    tab.close()
