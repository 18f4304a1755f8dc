"""A table as text, and how it reads in HTML and in Markdown. Pure."""

import html
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

NA: Final = "n/a"
"""Where there is no data; never 0."""


@dataclass(frozen=True)
class Table:
    """Cells as they are printed; the first column names the row."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Raises ValueError for a row that does not fit its columns."""
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"{self.title}: {row} does not fit {self.columns}")


def as_html(table: Table) -> str:
    """One `section` with its heading, the table and its notes."""
    head = "".join(f"<th>{html.escape(column)}</th>" for column in table.columns)
    body = "\n".join(
        "<tr>" + "".join(_cell(cell, n) for n, cell in enumerate(row)) + "</tr>"
        for row in table.rows
    )
    notes = "".join(f'<p class="note">{html.escape(note)}</p>' for note in table.notes)
    return (
        f"<section><h3>{html.escape(table.title)}</h3>\n<div class='scroll'><table><thead><tr>"
        f"{head}</tr></thead>\n<tbody>{body}</tbody></table></div>{notes}</section>"
    )


def as_markdown(table: Table) -> str:
    """Heading, table and notes."""
    lines = [
        f"### {table.title}",
        "",
        _line(table.columns),
        "|" + " --- |" * len(table.columns),
        *map(_line, table.rows),
    ]
    return "\n".join([*lines, *(f"\n{note}" for note in table.notes)]) + "\n"


def _cell(cell: str, column: int) -> str:
    kind = "th" if column == 0 else "td"
    faint = ' class="na"' if cell == NA else ""
    return f"<{kind}{faint}>{html.escape(cell)}</{kind}>"


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
