"""What the paper prints, to stand in columns of its own; never pooled with ours."""

from dataclasses import dataclass
from typing import Final

from surefetch.evaluation.recordings.splits import FAMILIES


@dataclass(frozen=True)
class PaperRow:
    """One row of Table II or III, or a condition of it."""

    name: str
    successes: tuple[int, ...]
    """By family."""
    analyzed: tuple[int, ...] = (5, 5, 5, 5, 5)

    @property
    def total(self) -> tuple[int, int]:
        """Successes and analysed episodes."""
        return sum(self.successes), sum(self.analyzed)


BASELINES: Final[dict[str, PaperRow]] = {
    "roboexp": PaperRow("RoboEXP", (2, 0, 5, 0, 0)),
    "dovsg": PaperRow("DovSG", (2, 0, 0, 0, 5), (5, 5, 5, 4, 5)),
    "introplan": PaperRow("IntroPlan", (5, 0, 0, 2, 5)),
    "actpermoma": PaperRow("ActPerMoMa", (0, 0, 0, 1, 5), (5, 5, 5, 4, 5)),
    "paper-method": PaperRow("Ours (the paper's)", (5, 3, 3, 3, 5)),
}
"""Table II, `tab:main_baseline_comparison`."""

ABLATIONS: Final[dict[str, PaperRow]] = {
    "full": PaperRow("full method", (5, 3, 3, 3, 5)),
    "a1": PaperRow("A1 observations pooled across views", (5, 2, 3, 3, 5)),
    "a2": PaperRow("A2 no cross-view memory", (4, 0, 5, 4, 5)),
    "a3": PaperRow("A3 factorised belief over identity and relation", (5, 3, 4, 3, 5)),
    "a4": PaperRow("A4 hypothesis-independent future observations", (5, 4, 4, 3, 5)),
    "a5": PaperRow("A5 no terminal execution-risk term", (5, 2, 4, 3, 5)),
    "a6": PaperRow("A6 no conformal grasp rule", (5, 3, 3, 3, 5)),
    "a7": PaperRow("A7 no defer action", (5, 2, 3, 3, 0)),
    "a8": PaperRow("A8 no conformal grasp rule or defer", (5, 4, 5, 3, 0)),
}
"""Table III, `tab:ablation_study`."""

CHALLENGES: Final[dict[str, tuple[str, str]]] = dict(
    zip(
        FAMILIES,
        (
            (
                "Visible/Open",
                "Identify and retrieve the visible target without unnecessary sensing.",
            ),
            (
                "Partially Occluded",
                "Acquire another view to resolve incomplete identity or visibility before "
                "commitment.",
            ),
            (
                "Covered Container",
                "Remove the cover and re-observe before deciding to grasp or defer.",
            ),
            (
                "Ambiguous Inside/Outside",
                "Resolve conflicting identity and container-relation evidence among similar "
                "candidates.",
            ),
            (
                "Target Absent",
                "Preserve uncertainty when target evidence remains unresolved. Defer rather than "
                "commit to a distractor.",
            ),
        ),
        strict=True,
    )
)
"""Table I, `tab:evaluation_scenario_families`: scenario and decision challenge."""


@dataclass(frozen=True)
class PhysicalRow:
    """One condition of Table IV: five trials of the authors' robot."""

    name: str
    successes: int
    mean_duration_s: int
    n: int = 5


PHYSICAL: Final[dict[str, PhysicalRow]] = {
    "visible": PhysicalRow("Visible/Open", 5, 134),
    "right": PhysicalRow("Viewpoint change (right)", 5, 160),
    "covered": PhysicalRow("Covered Container", 5, 209),
    "absent": PhysicalRow("Target Absent", 5, 175),
    "grasp": PhysicalRow("Injected grasp-failure report", 5, 180),
    "view": PhysicalRow("Injected viewpoint-failure report", 0, 166),
}
"""Table IV, `tab:real_robot_evaluation`."""

PERCEPTION: Final[dict[str, float]] = {
    "target_recall_5": 0.974,
    "container_f1_uncut": 1.0,
    "mask_ap_50_95": 0.544,
    "miou_all": 0.827,
}
"""Of 150 images: Grounding DINO-Base, with SAM 2.1 Hiera-L for masks."""

FUTURE_CELLS: Final = 15
"""Fitted cells of the planner's observation model."""
