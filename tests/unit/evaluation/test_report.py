"""The report says what the results say: n/a where nothing is, no word without its test."""

import json
import re
from pathlib import Path
from typing import Any

import made_up_results
import msgspec
import numpy as np
import pytest
from recorded_table import numbers, record, save
from scripted_table import CELL, Table, thing, thing_inside

from surefetch.common.conformal import quantile
from surefetch.common.errors import BadInput
from surefetch.common.messages import Mask, Observations
from surefetch.common.parameters import FULL, write_parameters
from surefetch.evaluation.fitting import calibrate, calibrate_command
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.recordings.pictures import Picture, Pictures
from surefetch.evaluation.recordings.recording import FORMAT, BodyMatch, Recording
from surefetch.evaluation.replaying import command as evaluate
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.reporting import (
    calibration_scores,
    causes,
    checks,
    claims,
    command,
    comparisons,
    findings,
    injected_table,
    method_table,
    plan,
    report,
    retold,
    study_results,
)
from surefetch.evaluation.reporting.causes import Known
from surefetch.evaluation.reporting.inputs import Inputs
from surefetch.evaluation.reporting.page import as_page, as_text
from surefetch.evaluation.reporting.study_results import Study
from surefetch.evaluation.reporting.table import NA, as_html, as_markdown
from surefetch.evaluation.reporting.table import Table as Printed
from surefetch.evaluation.running.metrics import VERDICTS, Verdict

GOOD = made_up_results.so_many(success=40)
BAD: list[Verdict] = ["success", "wrong_object", "false_defer", "grasp_failed"] * 10
STEP = made_up_results.STEP
KNOWN = Known("inside", {("center", "none"): 0.9}, {})
TABLES = {
    "visible": (Table((thing(0.9, -0.1), thing(0.9, 0.1, "other"))), 0),
    "partial": (Table((thing(0.9, -0.1), thing(0.9, 0.1))), 1),
    "covered": (Table((thing_inside(), thing(0.8, 0.2, "other")), covered=True), 0),
    "ambiguous": (Table((thing(0.9, -0.1, center="unread"), thing(0.9, 0.1, "other"))), 0),
    "absent": (Table((thing(0.9, -0.1), thing(0.9, 0.1, "other"))), None),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recordings of scripted tables with pictures, and the results of four policies on them."""
    made = tmp_path_factory.mktemp("campaign")
    for profile in ("paper", "extended"):
        write_parameters(made / f"{profile}.json", numbers(profile))
    for family, (table, wanted) in TABLES.items():
        recording, truth = record(table, wanted=wanted, family=family)
        recording = _with_masks(recording)
        save(made / "recordings", recording, truth)
        gray = np.full((480, 640, 3), 127, np.uint8)
        pictures = tuple(Picture.of(shot.state, gray) for shot in recording.shots)
        recording_store.save_pictures(
            made / "recordings", Pictures(FORMAT, family, recording.seed, pictures)
        )
    words = ["--recordings", str(made / "recordings"), "--parameters", str(made), "--json"]
    policies = "ours,paper-method,a6@extended,exhaustive-look@extended"
    evaluate.main([*words, "--policies", policies, "--out", str(made / "results")])
    injected = ["--inject", "view@1", "--policies", "ours", "--out", str(made / "injected")]
    evaluate.main([*words, *injected])
    _report(made)
    return made


def test_the_command_writes_pages_that_need_nothing_else(folder: Path) -> None:
    told = _manifest(folder)
    index = (folder / "results/report/index.html").read_text("utf-8")
    assert not re.search(r"(src|href)=.?https?:", index)
    assert index.count("data:image/svg+xml") >= 6
    text = (folder / "doc/results.md").read_text("utf-8")
    for picture in re.findall(r"\]\((\S+)\)", text):
        assert (folder / "doc" / picture).stat().st_size > 1000
    assert told["headline"] is False
    assert told["plan"] == plan.SHA256


def test_every_failed_episode_of_ours_is_in_the_gallery(folder: Path) -> None:
    told = _manifest(folder)
    gallery = (folder / "results/report/gallery.html").read_text("utf-8")
    ours = told["policies"]["ours@extended"]
    failed = ours["episodes"] - ours["successes"]
    assert failed > 0
    assert gallery.count("<article") == failed
    for frame in re.findall(r'src="(\S+)"', gallery):
        assert (folder / "results/report" / frame).stat().st_size > 500


def test_an_episode_is_traced_on_request(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    _report(folder, "--episode", "covered:100000", "--out", str(tmp_path))
    assert json.loads(capsys.readouterr().out) == json.loads(
        (tmp_path / "manifest.json").read_text("utf-8")
    )
    assert (tmp_path / "figures/trace-covered-100000.png").exists()
    with pytest.raises(BadInput, match="FAMILY:SEED"):
        _report(folder, "--episode", "covered:7", "--out", str(tmp_path))


def test_other_parameters_or_recordings_are_not_taken_for_the_results_own(
    folder: Path, tmp_path: Path
) -> None:
    for profile in ("paper", "extended"):
        write_parameters(tmp_path / f"{profile}.json", numbers(profile, q_hat=0.5))
    with pytest.raises(BadInput, match="not made with the parameters"):
        command.main([str(folder / "results"), "--parameters", str(tmp_path)])
    (tmp_path / "manifest.json").write_text('{"cell": "another"}')
    with pytest.raises(BadInput, match="not made on the recordings"):
        command.main([str(folder / "results"), "--recordings", str(tmp_path)])


def test_a_retold_episode_shows_what_was_seen_believed_and_done(folder: Path) -> None:
    recordings = folder / "recordings"
    (episode,) = [e for e in _results(folder, "ours") if e.family == "covered"]
    observed = retold.retold(
        episode,
        recording_store.load(recordings, "covered", 100_000),
        recording_store.load_pictures(recordings, "covered", 100_000),
    )
    assert len(observed.frames) == len(episode.steps) == len(observed.observations)
    ended = observed.ended
    assert ended is not None
    assert ended.outcome == episode.outcome


def test_what_was_not_measured_is_not_there() -> None:
    inputs = _inputs(ours=GOOD)
    found = findings.find(inputs)
    page = report.page(inputs, found, (), ("", ""))
    text = as_text(page, "figures")
    assert "<table" in as_page(page)
    row = next(line for line in text.splitlines() if line.startswith("| RoboEXP strong"))
    assert set(row.split("|")[2:-1]) == {f" {NA} "}
    perception = text.split("### Perception")[1].split("###")[0]
    assert "97.4 % | n/a" in perception
    assert "no mixed pixels at edges" in perception
    assert "not known" in text


@pytest.mark.parametrize("n_paper", [0, 20, 40])
def test_higher_is_said_only_where_the_test_says_it(n_paper: int) -> None:
    theirs = made_up_results.so_many(success=n_paper, false_defer=40 - n_paper)
    inputs = _inputs(ours=GOOD, **{"paper-method@paper": theirs})
    found = findings.find(inputs)
    said = as_text(report.page(inputs, found, (), ("", "")), "figures").split("### What holds")[0]
    one = found.groups["primary"][0]
    assert one.p_holm is not None
    significant = one.p_holm < 0.05
    assert ("higher than that of paper-method" in said) == significant
    assert ("is not told apart" in said) == (not significant)


def test_lower_success_is_said_too() -> None:
    played = {
        plan.OURS: made_up_results.episodes(BAD),
        plan.PAPER_METHOD: made_up_results.episodes(["success"] * 40),
    }
    one = comparisons.compare(played, plan.GROUPS[0])[0]
    assert "lower than that of paper-method" in claims.sentence(one)


def test_claims_without_data_are_not_known() -> None:
    found = findings.find(_inputs(**{"a1@paper": made_up_results.so_many(success=1)}))
    assert {claim.holds for claim in found.claims} == {None}


def test_the_classes_of_every_row_sum_to_its_episodes() -> None:
    study = _study({"ours": BAD})
    for cells in [method_table.cells(study.played[plan.OURS])]:
        assert [cell.split("/")[1] for cell in cells[:5]] == ["8"] * 5
    table = report.page(_inputs(ours=BAD), findings.find(_inputs(ours=BAD)), (), ("", ""))
    endings = next(
        t for part in table.parts for t in part.tables if t.title == "How episodes ended"
    )
    for row in endings.rows:
        assert sum(map(int, row[1:-1])) == int(row[-1]) == 40


def test_no_number_of_the_paper_stands_in_a_column_of_ours() -> None:
    inputs = _inputs(ours=GOOD)
    page = report.page(inputs, findings.find(inputs), (), ("", ""))
    tables = [table for part in page.parts for table in part.tables]
    paper = next(table for table in tables if table.title.startswith("Table II a"))
    assert [row[-2] for row in paper.rows] == ["28.0 %", "29.2 %", "48.0 %", "25.0 %", "76.0 %"]
    ours = next(table for table in tables if table.title.startswith("Table II d"))
    assert "76.0 %" not in {cell for row in ours.rows for cell in row}
    physical = next(table for table in tables if table.title.startswith("Table IV"))
    assert "no physical robot" in physical.title
    assert [row[1:3] for row in physical.rows][0] == ("5/5", "134")


def test_injected_failures_count_where_they_struck() -> None:
    base = made_up_results.episodes(["success", "success", "false_defer"])
    hit = [
        msgspec.structs.replace(
            e,
            actions=("right (failed, injected)", *e.actions) if n != 1 else e.actions,
            n_actions=3,
        )
        for n, e in enumerate(base)
    ]
    injected = study_results.study(made_up_results.manifest(injected="view@1"), {"ours": hit})
    without = study_results.study(made_up_results.manifest(), {"ours": base})
    (found,) = injected_table.struck([injected], [without])
    assert (found.n_scenes, len(found.with_it), found.successes) == (3, 2, 1)
    assert found.recovered == (1, 1)


def test_looks_that_were_not_the_same_are_found() -> None:
    study = _study({"ours": ["success"], "paper-method@paper": ["success"]})
    assert checks.equal_looks(study) == (1, 0)
    other = msgspec.structs.replace(STEP, delivered="1")
    moved = [msgspec.structs.replace(e, steps=(other,)) for e in study.played[plan.PAPER_METHOD]]
    mixed = {plan.OURS: study.played[plan.OURS], plan.PAPER_METHOD: moved}
    assert checks.equal_looks(Study(study.manifest, mixed, study.labels)) == (1, 1)


def test_too_many_episodes_that_saw_nothing_stop_the_report() -> None:
    study = _study({"ours": ["success"] * 50})
    blind = [
        msgspec.structs.replace(e, verdict="aborted", steps=()) if e.seed == 100_000 else e
        for e in study.played[plan.OURS]
    ]
    with pytest.raises(BadInput, match="first look"):
        checks.refuse_exclusions(Study(study.manifest, {plan.OURS: blind}, study.labels))


def test_an_audit_is_told_with_every_difference() -> None:
    row = {"policy": "ours", "live": "four processes", "family": "partial", "seed": 1}
    row |= {"same_actions": True, "same_outcome": True, "same_beliefs": True, "apart": 0.0}
    told = {"episodes": [row | {"why": ""}, row | {"same_actions": False, "why": "slipped"}]}
    table = checks.audit_table(told)
    assert table.rows[0][2:5] == ("1/2", "2/2", "2/2")
    assert table.notes == ("ours, partial:1: slipped",)


def test_policies_on_other_scenes_do_not_share_a_report() -> None:
    with pytest.raises(BadInput, match="same scenes"):
        _study({"ours": ["success"], "a1": ["success"] * 2})


@pytest.mark.parametrize(
    ("verdict", "changes", "cause"),
    [
        ("aborted", {}, "infrastructure"),
        ("grasp_failed", {}, "execution"),
        ("step_limit", {}, "planning"),
        ("false_defer", {"z_true": "unobs"}, "perception"),
        ("false_defer", {"z_true": "unobs", "view": "right"}, "planning"),
        ("false_defer", {"observations": ("1 mismatch",)}, "perception"),
        ("false_defer", {"observations": ("1 MO",)}, "perception"),
        ("false_defer", {}, "execution"),
        ("false_defer", {"gamma": ("1:inside", "abs")}, "planning"),
    ],
)
def test_a_failure_is_put_down_to_what_went_wrong_first(
    verdict: Verdict, changes: dict[str, object], cause: str
) -> None:
    step = msgspec.structs.replace(STEP, **changes)
    found = causes.cause(made_up_results.episode(verdict, steps=[step]), KNOWN)
    assert found is not None
    assert found[0] == cause


def test_an_undecided_target_after_all_views_is_the_beliefs_fault() -> None:
    steps = [
        msgspec.structs.replace(STEP, view=view, gamma=("1:inside", "abs"))
        for view in ("center", "right", "close_high")
    ]
    found = causes.cause(made_up_results.episode("false_defer", steps=steps), KNOWN)
    assert found is not None and found[0] == "emission"


def test_a_target_that_changed_its_track_was_lost_by_association() -> None:
    steps = [STEP, msgspec.structs.replace(STEP, view="right", z_true="2:inside")]
    found = causes.cause(made_up_results.episode("false_defer", steps=steps), KNOWN)
    assert found is not None and found[0] == "association"


@pytest.mark.parametrize(
    ("answered", "z_true", "fits", "cause"),
    [
        ("MI", "2:inside", False, "perception"),
        ("MI", "2:inside", True, "emission"),
        ("UI", "2:inside", False, "planning"),
        ("mismatch", "2:inside", False, "emission"),
        ("MI", "1:inside", False, "association"),
    ],
)
def test_a_wrong_object_is_put_down_to_what_was_answered_of_it(
    answered: str, z_true: str, fits: bool, cause: str
) -> None:
    step = msgspec.structs.replace(STEP, observations=(f"1 {answered}",), z_true=z_true)
    match = BodyMatch(color=True, shape=fits, marking=None, relation="inside")
    known = Known("inside", KNOWN.shown, {"other": match})
    found = causes.cause(made_up_results.episode("wrong_object", steps=[step]), known)
    assert found is not None and found[0] == cause


def test_every_verdict_but_success_has_a_cause() -> None:
    for verdict in VERDICTS:
        found = causes.cause(made_up_results.episode(verdict), KNOWN)
        assert (found is None) == (verdict == "success")


@pytest.mark.parametrize("profile", ["paper", "extended"])
def test_scores_for_other_levels_give_the_calibrated_threshold_at_its_own(
    profile: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(calibrate_command, "VARIANTS", (FULL,))
    tables = [TABLES["visible"], TABLES["partial"], TABLES["ambiguous"], TABLES["absent"]]
    n_scenes = calibrate.EPISODES[profile]
    for n in range(n_scenes):
        table, wanted = tables[n * n % 4]
        save(tmp_path, *record(table, wanted=wanted, family=splits.FAMILIES[n % 5],
                               seed=200_000 + n // 5))  # fmt: skip
    found = calibration_scores.scores(numbers(profile), tmp_path, CELL)
    known = calibrate_command.with_threshold(numbers(profile), tmp_path, CELL)
    assert len(found) == n_scenes
    assert quantile(found, calibrate_command.ALPHA) == known.q_hat()


def test_tables_keep_what_would_break_them() -> None:
    table = Printed("a < b", ("x", "y|z"), (("<script>", "1|2"), ("q", NA)), ("note & note",))
    shown, text = as_html(table), as_markdown(table)
    assert "<script>" not in shown and "&lt;script&gt;" in shown
    assert [line.count("|") - line.count(r"\|") for line in text.splitlines()[2:6]] == [3] * 4
    with pytest.raises(ValueError, match="does not fit"):
        Printed("t", ("a", "b"), (("1",),))


def _with_masks(recording: Recording) -> Recording:
    """The same, with empty masks of the pictures' size."""
    empty = Mask(height=480, width=640, counts=(480 * 640,))

    def masked(seen: Observations) -> Observations:
        container = seen.container and msgspec.structs.replace(seen.container, mask=empty)
        found = tuple(msgspec.structs.replace(d, mask=empty) for d in seen.detections)
        return msgspec.structs.replace(seen, detections=found, container=container)

    shots = tuple(
        msgspec.structs.replace(shot, observations=masked(shot.observations))
        for shot in recording.shots
    )
    return msgspec.structs.replace(recording, shots=shots)


def _report(folder: Path, *more: str) -> None:
    words = [str(folder / "results"), "--recordings", str(folder / "recordings")]
    words += ["--parameters", str(folder), "--also", str(folder / "injected"), "--json"]
    assert command.main([*words, "--markdown", str(folder / "doc/results.md"), *more]) == 0


def _manifest(folder: Path) -> dict[str, Any]:
    path = folder / "results/report/manifest.json"
    told: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return told


def _results(folder: Path, policy: str) -> list[EpisodeResult]:
    lines = (folder / f"results/{policy}.jsonl").read_bytes().splitlines()
    return [msgspec.json.decode(line, type=EpisodeResult) for line in lines]


def _study(verdicts: dict[str, list[Verdict]]) -> Study:
    played = {
        label: made_up_results.episodes(
            of, label, "paper" if label.endswith("@paper") else "extended"
        )
        for label, of in verdicts.items()
    }
    return study_results.study(made_up_results.manifest(), played)


def _inputs(**verdicts: list[Verdict]) -> Inputs:
    return Inputs(_study(verdicts), (), (), None, (), None, {}, None, None)
