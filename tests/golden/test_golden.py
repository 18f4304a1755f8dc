"""The agreed cases come out to their tolerances, through the code that runs on the robot."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from surefetch.belief import cases as belief_cases
from surefetch.common.cases import Case, read_cases, solve_cases
from surefetch.planner import cases as planner_cases

CASES = Path(__file__).parent / "cases"

COMMANDS: dict[str, tuple[dict[str, type[Case]], Callable[[list[str]], int]]] = {
    "filter": (belief_cases.KINDS, belief_cases.main),
    "conformal": (belief_cases.KINDS, belief_cases.main),
    "association": (belief_cases.KINDS, belief_cases.main),
    "plan": (planner_cases.KINDS, planner_cases.main),
}

DIAGNOSTIC = {"nodes"}
"""Fields of `expected` that an answer may leave out or count its own way."""

ABSOLUTE = {"cost", "total"}
"""Association costs: compared to 1e-6 absolute; everything else to 1e-9 relative."""


def raw_cases(kind: str) -> list[dict[str, Any]]:
    cases: list[dict[str, Any]] = json.loads((CASES / f"{kind}.json").read_text(encoding="utf-8"))
    return cases


def differences(expected: Any, found: Any, where: str = "", absolute: bool = False) -> list[str]:
    """Where `found` is not as expected, by the README's tolerances."""
    if isinstance(expected, bool) or isinstance(found, bool):
        return [] if expected is found else [f"{where}: {found} is not {expected}"]
    if isinstance(expected, float) and isinstance(found, int | float):
        close = found == (
            pytest.approx(expected, rel=0.0, abs=1e-6)
            if absolute
            else pytest.approx(expected, rel=1e-9, abs=0.0)
        )
        return [] if close else [f"{where}: {found!r} is not {expected!r}"]
    if isinstance(expected, dict) and isinstance(found, dict):
        if list(expected) != list(found):
            return [f"{where}: fields {list(found)} are not {list(expected)}"]
        pairs = [(f"{where}.{k}", expected[k], found[k], k in ABSOLUTE) for k in expected]
    elif isinstance(expected, list) and isinstance(found, list):
        if len(expected) != len(found):
            return [f"{where}: {len(found)} entries, expected {len(expected)}"]
        pairs = [
            (f"{where}[{i}]", e, f, absolute)
            for i, (e, f) in enumerate(zip(expected, found, strict=True))
        ]
    else:
        return [] if expected == found else [f"{where}: {found!r} is not {expected!r}"]
    return [d for w, e, f, a in pairs for d in differences(e, f, w, a)]


def check(case: dict[str, Any], answer: dict[str, Any]) -> None:
    expected = {k: v for k, v in case["expected"].items() if k not in DIAGNOSTIC}
    found = {k: answer[k] for k in expected}
    assert answer["name"] == case["name"]
    assert differences(expected, found) == []


PARAMETERS = [
    pytest.param(kind, i, id=f"{kind}-{case['name']}")
    for kind in COMMANDS
    for i, case in enumerate(raw_cases(kind))
]


@pytest.mark.parametrize(("kind", "i"), PARAMETERS)
def test_a_golden_case_comes_out_as_agreed(kind: str, i: int) -> None:
    kinds, _ = COMMANDS[kind]
    case = read_cases(CASES / f"{kind}.json", kinds, command="test")[i]
    check(raw_cases(kind)[i], solve_cases([case])[0])


@pytest.mark.parametrize("kind", COMMANDS)
def test_the_command_prints_every_answer_in_order_without_reading_what_is_expected(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cases = raw_cases(kind)
    unsolved = [{k: v for k, v in case.items() if k != "expected"} for case in cases]
    path = tmp_path / "cases.json"
    path.write_text(json.dumps(unsolved), encoding="utf-8")
    _, main = COMMANDS[kind]
    assert main([str(path)]) == 0
    answers = json.loads(capsys.readouterr().out)
    assert len(answers) == len(cases)
    for case, answer in zip(cases, answers, strict=True):
        check(case, answer)


def test_the_comparison_notices_a_difference_of_two_parts_in_a_billion() -> None:
    assert differences({"b": [1e-300]}, {"b": [1.000000002e-300]}) != []
    assert differences({"b": [1e-300]}, {"b": [1.0000000002e-300]}) == []
