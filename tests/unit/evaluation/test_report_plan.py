"""The plan in words is the plan in code, and openings of the evaluation split leave their mark."""

import hashlib
import re
from pathlib import Path

import made_up_results
import pytest

from surefetch.common.errors import BadInput
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.replaying.manifest import Manifest
from surefetch.evaluation.reporting import ledger, plan, study_results
from surefetch.evaluation.reporting.ledger import Opening

PLAN = Path(__file__).parents[3] / "docs" / "analysis-plan.md"
MADE = {"parameters": {"paper": "p", "extended": "e"}, "outcomes": {"draw": 0}, "injected": []}


def test_the_hash_is_that_of_the_plan() -> None:
    assert hashlib.sha256(PLAN.read_bytes()).hexdigest() == plan.SHA256


def test_the_groups_of_the_plan_are_those_that_are_tested() -> None:
    rows = re.findall(r"^\| (.+) \| (.+) \| (\S+@\S+) \| (.+) \|$", PLAN.read_text("utf-8"), re.M)
    written = [(name, test, first, against.split()) for name, test, first, against in rows]
    tested = [
        (group.name, group.test, "@".join(group.first), ["@".join(key) for key in group.against])
        for group in plan.GROUPS
    ]
    assert written == tested


@pytest.mark.parametrize(
    "told",
    [
        f"| draws of every resampling and permutation | {plan.DRAWS:,} |",
        f"| their seed, each anew | {plan.SEED} |",
        f"| margin of not being worse | {100 * plan.MARGIN:.0f} points |",
        f"| margin in a single family | {100 * plan.FAMILY_MARGIN:.0f} points |",
        f"| level | {plan.LEVEL} |",
        f"exceeds {plan.LARGEST_PSI:.2f} for a primary pair that is at most "
        f"{100 * plan.CLOSE:.0f} points apart",
        f"the first {plan.PER_FAMILY['paper-size']} scenes of each family",
        f"{5 * plan.PER_FAMILY['headline']} scenes",
    ],
)
def test_the_numbers_of_the_plan_are_those_of_the_code(told: str) -> None:
    assert told in PLAN.read_text("utf-8")


def test_development_recordings_need_no_ledger(tmp_path: Path) -> None:
    _recordings(tmp_path, 100_000)
    ledger.note(tmp_path, MADE, {"ours": "c"}, "study evaluate")
    assert ledger.read(tmp_path) == []
    assert ledger.sealed(tmp_path) == {}


def test_every_opening_of_the_evaluation_split_is_a_line(tmp_path: Path) -> None:
    _recordings(tmp_path, 300_000, 300_001)
    assert ledger.sealed(tmp_path) == {"plan": plan.SHA256}
    for code in "ab":
        ledger.note(tmp_path, MADE, {"ours": code}, f"study evaluate {code}")
    first, second = ledger.read(tmp_path)
    assert (first.previous, first.seeds, first.n_scenes) == (ledger.FIRST, (300_000, 300_001), 2)
    assert first.plan == plan.SHA256
    assert second.command.endswith("b")


@pytest.mark.parametrize("change", ["edit", "remove"])
def test_a_ledger_that_was_changed_afterwards_is_refused(tmp_path: Path, change: str) -> None:
    _recordings(tmp_path, 300_000)
    for code in "abc":
        ledger.note(tmp_path, MADE, {"ours": code}, "study evaluate")
    path = tmp_path / ledger.NAME
    lines = path.read_text().splitlines(keepends=True)
    lines[1:2] = [] if change == "remove" else [lines[1].replace('"b"', '"x"')]
    path.write_text("".join(lines))
    with pytest.raises(BadInput, match=r"line [23] does not follow"):
        ledger.read(tmp_path)
    with pytest.raises(BadInput, match="does not follow"):
        ledger.note(tmp_path, MADE, {"ours": "d"}, "study evaluate")


def test_results_that_kept_to_the_plan_are_headline() -> None:
    assert study_results.why_not_headline(_study(), [_opening()]) == []


@pytest.mark.parametrize(
    ("openings", "changes", "told"),
    [
        ([], {}, "no line for ours"),
        (["other code"], {}, "no line for ours"),
        (["", "other parameters"], {}, "with other parameters"),
        (["", "other plan"], {}, "under another plan"),
        ([""], {"plan": "f" * 64}, "not the plan"),
        ([""], {"plan": None}, "not the plan"),
        ([""], {"injected": ["view@1"]}, "injected"),
    ],
)
def test_results_that_did_not_are_not(
    openings: list[str], changes: dict[str, object], told: str
) -> None:
    reasons = study_results.why_not_headline(_study(changes), [_opening(o) for o in openings])
    assert len(reasons) == 1
    assert told in reasons[0]


@pytest.mark.parametrize(
    ("first_seed", "n", "told"),
    [(100_000, 600, "of development"), (300_000, 25, "5 scenes per family")],
)
def test_few_or_other_scenes_are_not_headline(first_seed: int, n: int, told: str) -> None:
    reasons = study_results.why_not_headline(_study(first_seed=first_seed, n=n), [_opening()])
    assert told in reasons[0]


def _recordings(folder: Path, *seeds: int) -> None:
    for seed in seeds:
        (folder / f"partial-{seed}{recording_store.SUFFIX}").touch()


def _opening(change: str = "") -> Opening:
    return Opening(
        at="2030-01-01T00:00:00+00:00",
        surefetch="0",
        commit="",
        plan="f" * 64 if change == "other plan" else plan.SHA256,
        parameters={"paper": "x" if change == "other parameters" else "p", "extended": "e"},
        policies={"ours": "x" if change == "other code" else "c"},
        seeds=(300_000, 300_119),
        n_scenes=600,
        outcomes={},
        injected=[],
        command="",
        previous="",
    )


def _study(
    changes: dict[str, object] | None = None, first_seed: int = 300_000, n: int = 600
) -> study_results.Study:
    told: dict[str, object] = {"plan": plan.SHA256} | (changes or {})
    made = made_up_results.manifest(**told).made_with
    played = {"ours": made_up_results.episodes(["success"] * n, first_seed=first_seed)}
    return study_results.study(Manifest(made, {"ours": {"code": "c"}}), played)
