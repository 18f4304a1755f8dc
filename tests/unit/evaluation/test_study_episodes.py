"""The table of closed-loop episodes, and what the fit reads from them."""

import json
from pathlib import Path
from typing import Any

import made_up_episode
import pytest
from msgspec.structs import replace

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.messages import ActionRecord
from surefetch.evaluation.fitting import fit_command as study_fit
from surefetch.evaluation.running import study_episodes
from surefetch.evaluation.running.metrics import VERDICTS, Verdict
from surefetch.evaluation.running.study_episode import _cost
from surefetch.planner.actions import Costs


def row(family: str, seed: int, verdict: Verdict, **more: Any) -> dict[str, Any]:
    actions = [{"action": "grasp", "status": "done", "duration_s": 4.0}]
    told = {"family": family, "seed": seed, "verdict": verdict, "begun": True, "cost": 0.008}
    return told | {"actions": actions, "outcome": "grasped"} | more


def test_every_episode_is_in_one_class() -> None:
    rows = [row("covered", seed, verdict) for seed, verdict in enumerate(VERDICTS)]
    told = study_episodes.report(rows)
    assert sum(told["families"]["covered"]["classes"].values()) == len(VERDICTS)
    assert told["all"]["successes"] == 1


def test_a_look_under_the_cover_has_its_cost_too() -> None:
    cell, words = simulated_cell(), ("look", "right_covered", "grasp")
    acted = tuple(ActionRecord(action=word, status="done", duration_s=1.0) for word in words)
    took = replace(made_up_episode.ended(), actions=acted)
    assert _cost(took, cell) == pytest.approx(cell.inform("right_covered").cost + Costs().grasp)


def test_an_episode_that_did_not_begin_does_not_count() -> None:
    rows = [row("covered", 1, "success"), row("covered", 2, "aborted", begun=False)]
    told = study_episodes.report(rows)
    assert (told["all"]["episodes"], told["excluded"]) == (1, 1)


def test_the_fit_reads_the_attempts(tmp_path: Path) -> None:
    path = tmp_path / study_episodes.EPISODES
    failed = [{"action": "remove_cover", "status": "failed", "duration_s": 9.0}]
    rows = [row("covered", 100_001, "success"), row("covered", 100_002, "success", actions=failed)]
    path.write_text("".join(json.dumps(r) + "\n" for r in rows))
    attempts = study_fit.read_attempts(path)
    assert [(a.scene, a.action, a.succeeded) for a in attempts] == [
        ("covered:100001", "grasp", True),
        ("covered:100002", "remove_cover", False),
    ]


def test_a_study_with_other_rules_needs_another_folder(tmp_path: Path) -> None:
    done = json.dumps(row("visible", 0, "success", cause=None, why=""))
    words = ["--seeds", "0:1", "--families", "visible", "--out", str(tmp_path)]
    (tmp_path / study_episodes.EPISODES).write_text(done + "\n")
    assert study_episodes.main([*words, "--json"]) == 0
    with pytest.raises(BadInput, match="Name another folder"):
        study_episodes.main([*words, "--profile", "paper"])


def test_what_is_there_is_not_run_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done = json.dumps(row("visible", 0, "wrong_object", cause="belief", why="twins"))
    (tmp_path / study_episodes.EPISODES).write_text(done + "\n")
    words = ["--seeds", "0:1", "--families", "visible", "--out", str(tmp_path), "--json"]
    assert study_episodes.main(words) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert told["families"]["visible"]["wrong_object"] == 1
    assert (told["profile"], told["policy"]) == ("extended", "ours")


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / study_episodes.EPISODES).write_text('{"family": "vis')
    with pytest.raises(BadInput, match="damaged"):
        study_episodes.main(["--seeds", "0:1", "--out", str(tmp_path)])
