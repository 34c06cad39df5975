"""HTML of the reports: escaped tables that can be copied, figures, and the page that needs nothing from outside.

Style and script are files of ``static/``, put into the page when it is written.  The page's own security policy forbids
every request, so that a reference to the network that slipped in would show as a console error.
"""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

_STATIC = Path(__file__).parent / "static"
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
_NARROWEST = 0.7  # of its drawn width a picture keeps on a small screen, where it then scrolls in its box


class Cell(NamedTuple):
    """A table's cell: the text shown, and the one that is copied and sorted by (default: the same)."""

    text: str
    raw: str | None = None
    kind: str = ""  # CSS classes, such as "number" or "missing"
    span: int = 1  # columns that it takes
    bar: float | None = None  # 0 to 1: drawn as a bar of that length instead of the text


class Section(NamedTuple):
    """A titled part of a page; ``body`` is HTML."""

    anchor: str
    title: str
    body: str


def number(text: str, raw: float | None = None) -> Cell:
    """A cell aligned as a number, with a true minus sign; ``raw`` is copied in its place, with twelve digits."""
    return Cell(text.replace("-", "−"), text if raw is None else f"{raw:.12g}", "number")


def table(
    heads: Sequence[str], rows: Iterable[Sequence[str | Cell]], *, label: str, titled: bool = False, note: str = "",
    sortable: bool = False, kind: str = "",
) -> str:  # fmt: skip
    """A table in its own scrolling box with a button that copies it as tab-separated text; "" without rows.

    ``label``: what it holds, for readers that do not see it, and its title when ``titled``; ``note``: a sentence above it;
    ``sortable``: a click on a head sorts by it; ``kind``: CSS classes.
    """
    body = "".join(f"<tr>{''.join(_cell(cell) for cell in row)}</tr>" for row in rows)
    if not body:
        return ""
    named = f' class="{escape(kind)}"' if kind else ""
    start = '<th scope="col" aria-sort="none"><button type="button">' if sortable else '<th scope="col">'
    end = "</button></th>" if sortable else "</th>"
    head = "".join(f"{start}{escape(text)}{end}" for text in heads)
    title = f"<h3>{escape(label)}</h3>" if titled else "<span></span>"
    return (
        f'<div class="table"><div class="head">{title}'
        '<button type="button" class="copy" hidden>copy</button></div>'
        f"{_note(note)}"
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(label)}">'
        f"<table{named}><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div></div>\n"
    )


def _cell(cell: str | Cell) -> str:
    if isinstance(cell, str):
        return f"<td>{escape(cell)}</td>"
    if cell.bar is not None:
        return f'<td class="bars"><span class="bar" style="width:{100.0 * cell.bar:.1f}%"></span></td>'
    kind = f' class="{escape(cell.kind)}"' if cell.kind else ""
    raw = "" if cell.raw is None or cell.raw == cell.text else f' data-raw="{escape(cell.raw)}"'
    span = f' colspan="{cell.span}"' if cell.span > 1 else ""
    return f"<td{kind}{raw}{span}>{escape(cell.text)}</td>"


def _note(text: str) -> str:
    return f'<p class="note">{escape(text)}</p>' if text else ""


def bullets(lines: Iterable[str]) -> str:
    """A list; "" without lines."""
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f"<ul>{items}</ul>\n" if items else ""


def figure(title: str, caption: str, png: bytes, dpi: float) -> str:
    """A PNG as wide as it was drawn, so that all figures have one size of print."""
    width, height = (round(int.from_bytes(png[k : k + 4], "big") * 96 / dpi) for k in (16, 20))  # of the PNG's header
    data = base64.b64encode(png).decode("ascii")
    return (
        f'<figure><h3>{escape(title)}</h3><div class="scroll" tabindex="0" role="region" aria-label="{escape(title)}">'
        f'<img alt="{escape(title + ": " + caption)}" width="{width}" height="{height}"'
        f' style="min-width:{_NARROWEST * width:.0f}px" src="data:image/png;base64,{data}"></div>'
        f"<figcaption>{escape(caption)}</figcaption></figure>\n"
    )


def document(title: str, lead: str, sections: Iterable[Section]) -> str:
    """The whole page; sections without body are left out."""
    shown = [s for s in sections if s.body]
    links = "".join(f'<a href="#{s.anchor}">{escape(s.title)}</a> ' for s in shown)
    body = "".join(f'<section id="{s.anchor}"><h2>{escape(s.title)}</h2>\n{s.body}</section>\n' for s in shown)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(title)}</title><link rel="icon" href="data:,">\n<style>\n{_static("style.css")}</style></head>\n<body>\n'
        f'<h1>{escape(title)}</h1><p class="lead">{escape(lead)}</p>\n<nav aria-label="Contents">{links}</nav>\n'
        f"{body}<script>\n{_static('page.js')}</script>\n</body></html>\n"
    )


def _static(name: str) -> str:
    return (_STATIC / name).read_text(encoding="utf-8")
