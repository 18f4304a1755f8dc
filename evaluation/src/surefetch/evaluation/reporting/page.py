"""The pages of the report: HTML that needs no network, and Markdown. Pure."""

import base64
import html
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from surefetch.evaluation.reporting.table import Table, as_html, as_markdown

STYLE: Final = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1b1f24; max-width: 1280px;
  margin: 2em auto; padding: 0 1.2em; }
h1 { font-size: 1.7em; } h2 { margin-top: 2.2em; border-bottom: 1px solid #d5d9df; }
h3 { margin: 1.6em 0 .4em; } small { font-weight: normal; color: #6b7280; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; font-size: .84em; }
th, td { padding: .22em .6em; text-align: right; border-bottom: 1px solid #e5e7eb;
  vertical-align: top; }
thead th { border-bottom: 1.5px solid #1b1f24; } th:first-child { text-align: left;
  font-weight: 500; min-width: 12em; }
.na { color: #a5acb5; } .note { color: #6b7280; font-size: .85em; max-width: 75em; }
.bad { color: #a33b20; } .warn { background: #fdf0cf; padding: .6em 1em; }
img { max-width: 100%; } figure { margin: 0; } nav a { margin-right: 1.2em; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr)); gap: 1.5em; }
article { border-top: 1px solid #d5d9df; padding: .4em 0 1.2em; }
.steps { display: flex; gap: 1em; overflow-x: auto; } .steps figure { flex: 0 0 420px; }
.bar { display: flex; gap: .5em; align-items: center; font-size: .82em; line-height: 1.35; }
.bar span { width: 11em; } .bar i { height: .75em; } .bar em { font-style: normal; }
.in { background: #0072b2; } .out { background: #c3c9d1; }
"""


@dataclass(frozen=True)
class Picture:
    """A figure and what it shows."""

    name: str
    """Of its file."""
    caption: str
    content: bytes

    @property
    def kind(self) -> str:
        """Its media type."""
        return "image/png" if self.name.endswith(".png") else "image/svg+xml"


@dataclass(frozen=True)
class Part:
    """A heading with sentences, tables and figures under it."""

    title: str
    sentences: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    only_html: bool = False
    """Too long for the Markdown page."""


@dataclass(frozen=True)
class Page:
    """The whole report."""

    title: str
    lead: tuple[str, ...]
    warnings: tuple[str, ...]
    parts: tuple[Part, ...]


def as_page(page: Page, links: Sequence[tuple[str, str]] = ()) -> str:
    """The report as one HTML file, figures inside; links lead to other pages beside it."""
    ways = [(f"#{n}", part.title) for n, part in enumerate(page.parts)]
    nav = "".join(
        f'<a href="{html.escape(to)}">{html.escape(name)}</a>' for to, name in (*ways, *links)
    )
    warned = "".join(f"<p>{html.escape(text)}</p>" for text in page.warnings)
    body = "".join(f"<p>{html.escape(text)}</p>" for text in page.lead)
    body += f"<div class='warn'>{warned}</div>" if warned else ""
    body += "".join(_part(part, n) for n, part in enumerate(page.parts))
    return document(page.title, f"<nav>{nav}</nav>{body}")


def document(title: str, body: str) -> str:
    """A whole HTML file."""
    told = html.escape(title)
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{told}</title>'
        f"<style>{STYLE}</style></head><body><h1>{told}</h1>{body}</body></html>\n"
    )


def as_text(page: Page, figures: str) -> str:
    """The report in Markdown; `figures` is the folder of its figures, as seen from the file."""
    lines = [f"# {page.title}", *page.lead, *(f"> {text}" for text in page.warnings)]
    for part in page.parts:
        if part.only_html:
            continue
        lines.append(f"## {part.title}")
        if part.sentences:
            lines.append("\n".join(f"- {text}" for text in part.sentences))
        lines += [as_markdown(table).rstrip() for table in part.tables]
        lines += [
            f"![{picture.caption}]({figures}/{picture.name})\n\n*{picture.caption}*"
            for picture in part.pictures
        ]
    return "\n\n".join(lines) + "\n"


def _part(part: Part, number: int) -> str:
    sentences = "".join(f"<li>{html.escape(text)}</li>" for text in part.sentences)
    shown = "".join(map(_picture, part.pictures))
    return (
        f'<h2 id="{number}">{html.escape(part.title)}</h2>'
        + (f"<ul>{sentences}</ul>" if sentences else "")
        + (f"<div class='figures'>{shown}</div>" if shown else "")
        + "".join(map(as_html, part.tables))
    )


def _picture(picture: Picture) -> str:
    data = base64.b64encode(picture.content).decode("ascii")
    caption = html.escape(picture.caption)
    return (
        f'<figure><img src="data:{picture.kind};base64,{data}" alt="{caption}">'
        f"<figcaption class='note'>{caption}</figcaption></figure>"
    )
