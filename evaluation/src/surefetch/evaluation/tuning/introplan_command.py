"""`surefetch study fit-introplan`: development and calibration scenes to what IntroPlan knows."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import track

from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.parameters import PROFILES, Provenance, check_origin, profile_parameters
from surefetch.evaluation.fitting.provenance import one_backend, provenance
from surefetch.evaluation.policies import introplan_knowledge
from surefetch.evaluation.policies.introplan_knowledge import Origin
from surefetch.evaluation.policies.introplan_situation import feature_names
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.replaying.contenders import WITH, Contender, contender
from surefetch.evaluation.replaying.manifest import parameters_hash
from surefetch.evaluation.replaying.scene import ready
from surefetch.evaluation.tuning.introplan_fit import learned, table_of
from surefetch.evaluation.tuning.introplan_lessons import Lesson, lessons_of

ANY: str = "always-defer"
"""A policy whose belief is believed along; what it would do is not asked."""


def main(argv: list[str]) -> int:
    """Learn for each belief, and write a file for each."""
    asked = _parser().parse_args(argv)
    cell = simulated_cell()
    numbers = {name: profile_parameters(name, asked.parameters) for name in PROFILES}
    for profile in PROFILES if asked.profile is None else (asked.profile,):
        one = contender(f"{ANY}{WITH}{profile}", profile, numbers)
        development, lessons_from = _lessons(asked.recordings, "development", one, cell)
        calibration, calibrated_on = _lessons(asked.calibration, "calibration", one, cell)
        origin = Origin(
            profile=profile,
            parameters=parameters_hash(numbers[profile]),
            features=feature_names(cell),
            lessons=lessons_from,
            calibration=calibrated_on,
            command=f"surefetch study fit-introplan {' '.join(argv)}",
        )
        known = learned(origin, table_of(development), list(calibration.values()))
        path = introplan_knowledge.write(asked.out, known)
        print(
            f"{profile}: {len(known.situations)} situations of {len(development)} scenes, "
            f"calibrated on {len(calibration)}; wrote {path} ({path.stat().st_size // 1000} kB)."
        )
    return 0


def _lessons(
    folder: Path, split: str, one: Contender, cell: Cell
) -> tuple[dict[tuple[str, int], Sequence[Lesson]], Provenance]:
    """Of all scenes. Raises BadInput for scenes of another split."""
    scenes = recording_store.scenes(folder)
    splits.require(split, [seed for _, seed in scenes], "study fit-introplan")
    found: dict[tuple[str, int], Sequence[Lesson]] = {}
    backend = ""
    console = Console(stderr=True)
    for address in track(scenes, f"{one.profile.name}, {split}", transient=True, console=console):
        recording = recording_store.load(folder, *address)
        backend = one_backend(backend, recording)
        check_origin(one.parameters, cell=recording.cell, backend=recording.backend)
        scene = ready(recording, recording_store.load_truth(folder, *address))
        found[address] = lessons_of(scene, one, cell)
    return found, provenance(cell, backend, split, scenes, "right in hindsight")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch study fit-introplan",
        description="Let IntroPlan learn: from development recordings, which options were right "
        "in which situations; from calibration recordings, the scores that its threshold is "
        "drawn from. Writes FOLDER/introplan-knowledge@PROFILE.npz. Needs scikit-learn.",
        epilog="example: surefetch study fit-introplan development --calibration calibration "
        "--out knowledge",
    )
    parser.add_argument("recordings", type=Path, metavar="DIR")
    parser.add_argument("--calibration", type=Path, required=True, metavar="DIR")
    parser.add_argument("--profile", choices=PROFILES, help="only this belief; default: both")
    parser.add_argument(
        "--parameters", type=Path, metavar="FOLDER", help="default: those that ship"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    return parser
