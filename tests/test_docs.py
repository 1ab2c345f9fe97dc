"""The pages: their code runs, their links lead somewhere, their tables come out of the CSV."""

from __future__ import annotations

import pkgutil
import re
import sys
from pathlib import Path

import pytest

from tests.markdown import ROOT, blocks, links, run

sys.path.insert(0, str(ROOT / "docs" / "site" / "extensions"))

import columns

DOCS = ROOT / "docs"
PAGES = sorted(p for p in DOCS.rglob("*.md"))
LINKED = [*PAGES, *(ROOT / f"{name}.md" for name in ("README", "CHANGELOG", "CONTRIBUTING"))]
CONF = (DOCS / "site" / "conf.py").read_text(encoding="utf-8")
CSV = re.compile(r"^```\{csv\} (\w+):(\S+)\n(.*?)^```", re.DOTALL | re.MULTILINE)


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


@pytest.mark.filterwarnings("ignore::scaling.CoarseCoordinatesWarning")
@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p)], ids=name_of)
def test_code_of_the_pages_runs_and_prints_what_it_says(page, monkeypatch, tmp_path):
    (tmp_path / "tests").symlink_to(ROOT / "tests")
    monkeypatch.chdir(tmp_path)
    run(page)


@pytest.mark.parametrize("page", LINKED, ids=name_of)
def test_links_into_the_repository_lead_somewhere(page):
    for target in links(page):
        assert (page.parent / target).exists(), f"{target} in {name_of(page)}"


@pytest.mark.parametrize("page", [p for p in PAGES if CSV.search(p.read_text())], ids=name_of)
def test_tables_can_be_made(page):
    folders = dict(re.findall(r'"(\w+)": "([\w/]+)"', re.search("csv_folders = (.*)", CONF)[1]))
    for folder, name, wanted in CSV.findall(page.read_text()):
        lines = columns.table(ROOT / folders[folder] / name, wanted.splitlines())
        assert len(lines) > 2
        assert len({line.count("|") for line in lines}) == 1


def test_a_table_takes_comments_or_none_and_says_what_is_missing(tmp_path):
    (tmp_path / "new.csv").write_text("Δ,how,E\n0.1,gas,0.5\n0.01,gas,0.25\n")
    (tmp_path / "old.csv").write_text("# {}\nΔ,how,E\n0.1,gas,0.5\n0.01,gas,0.25\n")
    wanted = ["E at ξ = Δ = {E:.2f}", "made from = {how}", "rows: Δ = 0.01"]
    expected = ["| E at ξ = Δ | made from |", "| --- | --- |", "| 0.25 | gas |"]
    for name in ("new.csv", "old.csv"):
        assert columns.table(tmp_path / name, wanted) == expected
    with pytest.raises(KeyError, match="Z"):
        columns.table(tmp_path / "new.csv", ["Z = {Z}"])
    with pytest.raises(ValueError, match="no row is left"):
        columns.table(tmp_path / "new.csv", ["E = {E}", "rows: Δ = 7"])


def test_every_page_is_in_the_contents():
    """A page that no table of contents names would not be found."""
    contents = "".join(p.read_text() for p in (DOCS / "index.md", DOCS / "why" / "derivations.md"))
    for page in PAGES:
        name = page.relative_to(DOCS).with_suffix("").as_posix()
        assert name == "index" or re.search(rf"^{name}$", contents, re.MULTILINE), name


def test_the_glossary_names_the_symbols():
    glossary = (DOCS / "glossary.md").read_text()
    for symbol in "EKCΔξκMQGηZΛh":
        assert f"| {symbol} |" in glossary, symbol


def test_what_has_moved_is_where_the_changelog_says():
    """Every name in the column "now" is a module, or in one."""
    table = (ROOT / "CHANGELOG.md").read_text().partition("### Moved")[2].partition("## 0.1.0")[0]
    rows = [line.split("|")[2] for line in table.splitlines() if line.startswith("| `")]
    assert len(rows) > 20
    for name in re.findall(r"`([\w.]+)`", "".join(rows)):
        assert pkgutil.resolve_name(name), name
