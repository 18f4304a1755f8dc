"""`surefetch study report`: every table and figure from stored results and recordings."""

import argparse
import hashlib
import json
import sys
import time
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, Final

from rich.console import Console

from surefetch.common.errors import BadInput
from surefetch.common.version import VERSION
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.reporting import causes, findings, gallery, inputs, plan, report, retold
from surefetch.evaluation.reporting.commit import commit
from surefetch.evaluation.reporting.inputs import Inputs, Sources
from surefetch.evaluation.reporting.page import Page, Picture, as_page, as_text, document
from surefetch.evaluation.reporting.plan import OURS
from surefetch.evaluation.reporting.scene_facts import Facts
from surefetch.evaluation.showing import trace_figure
from surefetch.evaluation.showing.observed import Observed

REPORT: Final = "report"
FIGURES: Final = "figures"


def main(argv: list[str]) -> int:
    """Read, test, draw, write."""
    asked = _parser().parse_args(argv)
    began_s = time.monotonic()
    sources = Sources(
        results=asked.results,
        recordings=asked.recordings,
        also=tuple(asked.also or ()),
        parameters=asked.parameters,
        calibration=asked.calibration,
        perception=asked.perception,
        trials=asked.trials,
        audit=asked.audit,
    )
    read = inputs.read(sources)
    found = findings.find(read)
    folder = asked.out or asked.results / REPORT
    (folder / FIGURES).mkdir(parents=True, exist_ok=True)
    traces = list(_traces(read, asked.recordings, folder, asked.episode))
    command = f"surefetch study report {' '.join(argv)}"
    page = report.page(read, found, traces, (command, commit()))
    links = _gallery(read, asked.recordings, folder)
    _write(page, links, folder, asked.markdown)
    told = findings.summary(read, found) | {
        "commit": commit(),
        "surefetch": VERSION,
        "at": datetime.now(UTC).isoformat(timespec="seconds"),
        "sources": {name: _plain(value) for name, value in vars(sources).items()},
        "results": {"hash": _hash(asked.results), **read.study.manifest.made_with},
        "command": command,
        "took_s": round(time.monotonic() - began_s, 1),
    }
    (folder / "manifest.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    _say(told, folder, as_json=asked.json)
    return 0


def _traces(
    read: Inputs, recordings: Path | None, folder: Path, wanted: str | None
) -> Iterator[Picture]:
    """The chosen episode, or the one by rule, and the first failures."""
    ours = read.study.played.get(OURS, ())
    chosen = [_named(ours, wanted)] if wanted is not None else [retold.first_trace(ours)]
    if recordings is None:
        return
    for episode in [e for e in (*chosen, *retold.first_failures(ours)) if e is not None]:
        name = f"trace-{episode.family}-{episode.seed}.png"
        path = folder / FIGURES / name
        trace_figure.draw(_retell(recordings, episode), path)
        told = episode.verdict.replace("_", " ")
        caption = f"{episode.family}:{episode.seed}, {told}."
        yield Picture(name, caption, path.read_bytes())


def _named(episodes: Sequence[EpisodeResult], address: str) -> EpisodeResult:
    for episode in episodes:
        if f"{episode.family}:{episode.seed}" == address:
            return episode
    raise BadInput(f"ours did not play {address}; --episode takes FAMILY:SEED of a played scene.")


def _gallery(read: Inputs, recordings: Path | None, folder: Path) -> list[tuple[str, str]]:
    """Write the page with every failed episode of ours; a link to it."""
    failed = [e for e in read.study.played.get(OURS, ()) if e.verdict != "success"]
    if recordings is None or read.facts is None or not failed:
        return []
    facts = read.facts

    def cause(episode: EpisodeResult) -> tuple[str, str] | None:
        of: Facts = facts[episode.family, episode.seed]
        return causes.cause(episode, of.known)

    shown = gallery.entries(failed, partial(_retell, recordings), cause, folder)
    title = f"Every failed episode of ours ({len(failed)})"
    (folder / "gallery.html").write_text(document(title, "".join(shown)), encoding="utf-8")
    return [("gallery.html", title)]


def _retell(recordings: Path, episode: EpisodeResult) -> Observed:
    scene = episode.family, episode.seed
    return retold.retold(
        episode,
        recording_store.load(recordings, *scene),
        recording_store.load_pictures(recordings, *scene),
    )


def _write(
    page: Page, links: Sequence[tuple[str, str]], folder: Path, markdown: Path | None
) -> None:
    (folder / "index.html").write_text(as_page(page, links), encoding="utf-8")
    (folder / "results.md").write_text(_with_figures(page, folder, FIGURES), encoding="utf-8")
    if markdown is not None:
        markdown.parent.mkdir(parents=True, exist_ok=True)
        text = _with_figures(page, markdown.parent, markdown.stem)
        markdown.write_text(text, encoding="utf-8")


def _with_figures(page: Page, folder: Path, figures: str) -> str:
    """The Markdown, its figures written beside it."""
    (folder / figures).mkdir(parents=True, exist_ok=True)
    pictures = [picture for part in page.parts for picture in part.pictures]
    for picture in pictures:
        (folder / figures / picture.name).write_bytes(picture.content)
    return as_text(page, figures)


def _say(told: dict[str, Any], folder: Path, *, as_json: bool) -> None:
    if as_json:
        sys.stdout.write(json.dumps(told) + "\n")
        return
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"{told['size']}. Plan {plan.SHA256[:12]}.")
    for reason in told["why_not_headline"]:
        console.print(f"  not headline: {reason}")
    for claim in told["claims"]:
        mark = {True: "holds", False: "does not hold", None: "not known"}[claim["holds"]]
        console.print(f"  {mark:13}  {claim['claim']}: {claim['found']}")
    console.print(f"Wrote {folder / 'index.html'} in {told['took_s']} s.")


def _hash(folder: Path) -> str:
    whole = hashlib.sha256()
    for path in sorted(folder.glob("*.json*")):
        whole.update(path.name.encode() + path.read_bytes())
    return whole.hexdigest()


def _plain(value: Path | tuple[Path, ...] | None) -> Any:
    if isinstance(value, tuple):
        return [str(path) for path in value]
    return None if value is None else str(value)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch study report",
        description="Tables I to IV with the paper's numbers beside ours, tests as the analysis "
        "plan declares them, figures, and every failed episode of ours with its pictures. What "
        "was not measured is n/a.",
        epilog="example: surefetch study report results --recordings evaluation "
        "--also injected-view --perception perception/perception.json --markdown docs/results.md",
    )
    parser.add_argument("results", type=Path, metavar="DIR", help="of `study evaluate --out`")
    parser.add_argument(
        "--recordings", type=Path, metavar="DIR", help="of these results: truth, pictures, ledger"
    )
    parser.add_argument(
        "--also",
        type=Path,
        action="append",
        metavar="DIR",
        help="further results: with injected failures, or with other outcomes; again for more",
    )
    parser.add_argument(
        "--parameters", type=Path, metavar="FOLDER", help="default: those that ship"
    )
    parser.add_argument(
        "--calibration",
        type=Path,
        metavar="DIR",
        help="calibration recordings: coverage at levels other than the calibrated one (minutes)",
    )
    parser.add_argument("--perception", type=Path, metavar="JSON", help="of `study perception`")
    parser.add_argument(
        "--trials", type=Path, metavar="JSONL", help="episodes.jsonl of `study episodes`"
    )
    parser.add_argument("--audit", type=Path, metavar="JSON", help="of `study audit --json`")
    parser.add_argument(
        "--episode", metavar="FAMILY:SEED", help="whose trace to show; default: by the rule"
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: report in the results")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="also write the page there")
    parser.add_argument("--json", action="store_true", help="the manifest on stdout")
    return parser
