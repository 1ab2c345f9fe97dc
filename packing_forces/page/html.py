"""The page as text: its skeleton and style, tables and lists.

One file: no script, no font, no picture from elsewhere. Headings, landmarks, a link past the head,
and wide tables that scroll by keyboard.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape as escaped

STYLE = """
:root{color-scheme:light;--ink:#1b1b1b;--soft:#595959;--line:#d0d0d0;--mark:#0072b2}
*{box-sizing:border-box}
body{margin:0 auto;padding:1rem;max-width:72rem;font:16px/1.5 system-ui,sans-serif;
color:var(--ink);background:#fff}
h1{font-size:1.6rem;margin:.5rem 0;overflow-wrap:anywhere}
h2{font-size:1.2rem;margin:2rem 0 .5rem}
p,li,dd{overflow-wrap:anywhere}
.verdict{font-size:1.2rem;border-left:.4rem solid var(--mark);padding:.5rem 1rem;margin:1rem 0;
background:#f3f8fb}
.no{border-color:#d55e00;background:#fdf4ee}
.pair{display:grid;gap:1rem;grid-template-columns:repeat(auto-fit,minmax(min(100%,22rem),1fr))}
figure{margin:0}
figcaption{color:var(--soft);font-size:.9rem}
img,svg{display:block;width:100%;height:auto}
.curve svg{max-width:40rem}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th,td{padding:.25rem .75rem;border-bottom:1px solid var(--line);text-align:right;
white-space:nowrap}
th:first-child,td:first-child{text-align:left}
td.long{white-space:normal;text-align:left;overflow-wrap:anywhere}
:focus-visible{outline:3px solid var(--mark);outline-offset:2px}
.skip{position:absolute;left:-99rem}.skip:focus{left:1rem;top:.5rem;background:#fff;padding:.5rem}
summary{cursor:pointer;font-size:1.2rem;font-weight:bold;margin-top:2rem}
a{color:#005a8c}
@media print{.skip{display:none}details>*{display:block}}
@media(max-width:30rem){th,td{padding:.25rem .4rem}body{padding:.75rem}}
"""


def escape(text: str) -> str:
    """As text of a page; a number and its percent sign stay on one line."""
    return re.sub(r"(?<=\d) %", "\u00a0%", escaped(text))


def page(title: str, parts: Iterable[str]) -> str:
    """The whole document."""
    body = "\n".join(parts)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width,initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        '<a class="skip" href="#verdict">To the verdict</a>\n'
        f"<main>\n<h1>{escape(title)}</h1>\n{body}\n</main>\n</body>\n</html>\n"
    )


def section(name: str, heading: str, *parts: str) -> str:
    """A part of the page, with a heading that it is named by."""
    inner = "\n".join(part for part in parts if part)
    return (
        f'<section id="{name}" aria-labelledby="{name}-h">\n<h2 id="{name}-h">{escape(heading)}'
        f"</h2>\n{inner}\n</section>"
    )


def folded(name: str, heading: str, *parts: str) -> str:
    """A part that is opened when it is wanted."""
    inner = "\n".join(parts)
    return f'<details id="{name}">\n<summary>{escape(heading)}</summary>\n{inner}\n</details>'


def paragraph(text: str, kind: str = "") -> str:
    """A paragraph, of a class if it is named."""
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def figure(picture: str, caption: str, kind: str = "") -> str:
    """A picture with what it shows."""
    attribute = f' class="{kind}"' if kind else ""
    return f"<figure{attribute}>{picture}<figcaption>{escape(caption)}</figcaption></figure>"


def side_by_side(*figures: str) -> str:
    """Beside each other where there is room, below each other where there is none."""
    return f'<div class="pair">{"".join(figures)}</div>'


def table(label: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table that scrolls by itself, by keyboard too, where it is too wide."""
    top = "".join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    lines = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>\n" for row in rows
    )
    return (
        f'<div class="wide" role="region" aria-label="{escape(label)}" tabindex="0"><table>'
        f"<thead><tr>{top}</tr></thead>\n<tbody>\n{lines}</tbody></table></div>"
    )


def listed(items: Iterable[str]) -> str:
    """A list."""
    return "<ul>" + "".join(f"<li>{escape(item)}</li>" for item in items) + "</ul>"


def pairs(of: Iterable[tuple[str, str]]) -> str:
    """Names and values, without a head."""
    rows = "".join(
        f'<tr><th scope="row">{escape(name)}</th><td class="long">{escape(value)}</td></tr>\n'
        for name, value in of
    )
    return f"<table><tbody>\n{rows}</tbody></table>"
