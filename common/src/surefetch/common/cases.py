"""Golden-format case files: a JSON list in, a JSON list of answers out."""

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import msgspec

from surefetch.common.errors import BadInput
from surefetch.common.parameters import CountTable, PairedTable

Emissions = CountTable
Paired = PairedTable
QHat = float | Literal["inf"]


class Case(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What every case has; `expected` is for whoever compares and is never read here."""

    kind: str
    name: str
    note: str = ""
    expected: Any = None

    def solve(self) -> dict[str, Any]:
        """The fields of `expected`. Raises ValueError or KeyError for what makes no sense."""
        raise NotImplementedError


def as_q_hat(q_hat: QHat) -> float:
    """The conformal threshold as a number."""
    return math.inf if q_hat == "inf" else q_hat


def read_cases(path: Path, kinds: Mapping[str, type[Case]], *, command: str) -> list[Case]:
    """The cases of a file, checked. Raises BadInput naming the file, the case and the field."""
    try:
        found = msgspec.json.decode(path.read_bytes(), type=list[dict[str, Any]])
    except OSError as error:
        raise BadInput(f"case file {path} cannot be read: {error.strerror}") from None
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise BadInput(f"case file {path} is no JSON list of cases: {error}") from None
    return [_case(raw, f"{path}, case {i}", kinds, command) for i, raw in enumerate(found)]


def solve_cases(cases: Sequence[Case]) -> list[dict[str, Any]]:
    """Name and answer of each case, in order. Raises BadInput naming the case."""
    return [{"name": case.name, **_solved(case)} for case in cases]


def print_answers(answers: Sequence[dict[str, Any]]) -> None:
    """One JSON list on stdout, an answer a line."""
    lines = ",\n".join(msgspec.json.encode(answer).decode() for answer in answers)
    sys.stdout.write(f"[\n{lines}\n]\n" if lines else "[]\n")


def _case(raw: dict[str, Any], where: str, kinds: Mapping[str, type[Case]], command: str) -> Case:
    kind = str(raw.get("kind"))
    if kind not in kinds:
        raise BadInput(
            f'{where}: kind "{kind}" is not one that {command} takes.\n  Kinds: {", ".join(kinds)}'
        )
    try:
        return msgspec.convert(raw, kinds[kind])
    except msgspec.ValidationError as error:
        raise BadInput(f"{where} ({raw.get('name')}): {error}") from None


def _solved(case: Case) -> dict[str, Any]:
    try:
        return case.solve()
    except (ValueError, KeyError) as error:
        raise BadInput(f"case {case.name}: {error}") from None
