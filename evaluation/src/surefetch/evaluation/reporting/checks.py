"""What could make the results dishonest, looked for. Pure."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

from surefetch.common.errors import BadInput
from surefetch.evaluation.reporting import names
from surefetch.evaluation.reporting.ledger import Opening
from surefetch.evaluation.reporting.study_results import MOST_EXCLUDED, Study
from surefetch.evaluation.reporting.table import Table


def table(study: Study) -> Table:
    """The checks, each with what was found."""
    everything = [e for of in study.played.values() for e in of]
    looks, differing = equal_looks(study)
    aborted = sum(e.verdict == "aborted" for e in everything)
    live = sum(e.finished_live for e in everything)
    rows = (
        ("scenes left out of the tables", "0: every scene counts for every policy"),
        ("episodes that left their recording, or were cut short", str(aborted)),
        (
            "episodes that left their recording and were finished in the simulator",
            f"{live} of {len(everything)}",
        ),
        (
            "looks of several policies at one scene that were not given the same data",
            f"{differing} of {looks}",
        ),
        ("outcomes of actions", str(study.manifest.made_with.get("outcomes"))),
        ("parameters", str(study.manifest.made_with.get("parameters"))),
        ("recordings", str(study.manifest.made_with.get("recordings"))),
    )
    return Table("Checks", ("what", "found"), rows)


def refuse_exclusions(study: Study) -> None:
    """Stop where too many scenes never delivered a first frame.

    Raises:
        BadInput: more than 1 % of some policy's episodes ended before the first look.
    """
    for key, episodes in study.played.items():
        blind = sum(e.verdict == "aborted" and not e.steps for e in episodes)
        if blind > MOST_EXCLUDED * len(episodes):
            raise BadInput(
                f"{blind} of {len(episodes)} episodes of {names.of(key)} ended before the first "
                f"look; no more than {MOST_EXCLUDED:.0%} may.\n  Record these scenes again."
            )


def equal_looks(study: Study) -> tuple[int, int]:
    """Looks from one place at one scene by several policies; how many were not given equal data.

    Of episodes that were finished in the simulator, none count.
    """
    seen: dict[tuple[str, int, str, str], set[str]] = defaultdict(set)
    takers: dict[tuple[str, int, str, str], int] = defaultdict(int)
    for episodes in study.played.values():
        for e in episodes:
            for step in e.steps if not e.finished_live else ():
                if step.counted:
                    address = (e.family, e.seed, step.view, step.cover)
                    seen[address].add(step.delivered)
                    takers[address] += 1
    shared = [address for address, n in takers.items() if n > 1]
    return len(shared), sum(len(seen[address]) > 1 for address in shared)


def ledger_table(openings: Sequence[Opening]) -> Table:
    """Every opening of the evaluation recordings."""
    rows = tuple(
        (
            one.at,
            one.commit[:12] or one.surefetch,
            one.plan[:12],
            _told(one.parameters),
            ", ".join(f"{name} {code}" for name, code in one.policies.items()),
            f"{one.n_scenes} scenes, {one.seeds[0]}–{one.seeds[1]}",
            f"{one.outcomes} {one.injected}".strip(),
            one.command,
        )
        for one in openings
    )
    columns = (
        "when (UTC)", "commit", "plan", "parameters", "policies and their code", "scenes",
        "outcomes", "command",
    )  # fmt: skip
    return Table("Ledger: every opening of these recordings", columns, rows)


def audit_table(told: Mapping[str, Any]) -> Table:
    """Replay against live runs, from `study audit --json`; every difference with its reason."""
    rows = []
    for policy in dict.fromkeys(row["policy"] for row in told["episodes"]):
        mine = [row for row in told["episodes"] if row["policy"] == policy]
        same = (
            f"{sum(row[what] for row in mine)}/{len(mine)}"
            for what in ("same_actions", "same_outcome", "same_beliefs")
        )
        apart = f"{max(row['apart'] for row in mine):.1e}"
        rows.append((policy, str(mine[0]["live"]), *same, apart))
    notes = tuple(
        f"{row['policy']}, {row['family']}:{row['seed']}: {row['why']}"
        for row in told["episodes"]
        if row["why"]
    )
    columns = (
        "policy", "live by", "actions the same", "end the same", "beliefs the same",
        "largest difference",
    )  # fmt: skip
    return Table("Replay against live runs", columns, tuple(rows), notes)


def commands_table(study: Study) -> Table:
    """The command that played each policy."""
    rows = tuple(
        (label, str(told.get("code", "")), str(told.get("command", "")))
        for label, told in study.manifest.policies.items()
    )
    return Table("Commands", ("policy", "code", "command"), rows)


def _told(hashes: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {value}" for name, value in hashes.items())
