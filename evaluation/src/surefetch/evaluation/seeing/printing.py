"""The perception table in the terminal."""

from collections.abc import Mapping
from typing import Any, Final

from rich.console import Console
from rich.table import Table

ROWS: Final = (
    ("target in the best five", "target_recall_5"),
    ("objects in the best five", "object_recall_5"),
    ("container F1, uncut", "container_f1_uncut"),
    ("container F1, cut by the border", "container_f1_cut"),
    ("container F1 by masks", "container_f1_mask"),
    ("mask AP50:95", "mask_ap_50_95"),
    ("mean IoU, unmatched count 0", "miou_all"),
    ("mean IoU, matched only", "miou_matched"),
)


def show(tables: Mapping[str, Mapping[str, Any]], console: Console) -> None:
    """Print both sets of pictures."""
    for name, figures in tables.items():
        columns = {"all": figures["all"]} | dict(figures["views"])
        console.print(_found(name, columns))
        console.print(_answers(name, columns))


def _found(name: str, columns: Mapping[str, Mapping[str, Any]]) -> Table:
    titles = [f"{view} ({figures['images']})" for view, figures in columns.items()]
    table = Table(f"{name}, %", *titles, title="What is found")
    for title, key in ROWS:
        table.add_row(title, *(_figure(figures[key]) for figures in columns.values()))
    return table


def _figure(figure: Mapping[str, Any]) -> str:
    if figure["value"] is None:
        return "n/a"
    text = f"{100 * figure['value']:.1f}"
    if "n" in figure:
        text += f" ({figure['n']}/{figure['of']})"
    if "hit" in figure:
        text += f" (+{figure['hit']} -{figure['missed']} !{figure['false']})"
    low, high = figure.get("interval_95", (None, None))
    return text if low is None else f"{text}\n{100 * low:.1f}–{100 * high:.1f}"


def _answers(name: str, columns: Mapping[str, Mapping[str, Any]]) -> Table:
    table = Table(
        name,
        *columns,
        title="What is answered: supported / contradicted / unobservable, "
        "of membership inside / outside / unknown",
    )
    for question in columns["all"]["answers"]:
        for truth in ("true", "false"):
            table.add_row(
                f"{question}, asked of the {truth}",
                *(_labels(figures["answers"][question][truth]) for figures in columns.values()),
            )
        for key in ("wrong", "abstained"):
            table.add_row(
                f"{question}, {key}, %",
                *(_percent(figures["answers"][question][key]) for figures in columns.values()),
            )
    return table


def _labels(row: Mapping[str, int]) -> str:
    return " / ".join(str(n) for n in row.values())


def _percent(value: float | None) -> str:
    return "n/a" if value is None else f"{100 * value:.2f}"
