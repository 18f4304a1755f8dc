"""POMDPX documents of any kind read back, and their exact value; knows nothing of who wrote them.

Only tables are read, and all state but one variable must be fully observed. A document that leaves
a case out, says it twice, or whose chances do not sum to one is refused.

Source: PomdpX File Format (Version 1.0), National University of Singapore.
"""

import itertools
import xml.etree.ElementTree as ET
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Assignment = dict[str, str]


@dataclass(frozen=True)
class Table:
    """Numbers by values of these variables, in this order."""

    variables: tuple[str, ...]
    numbers: Array


@dataclass(frozen=True)
class Document:
    discount: float
    values: dict[str, tuple[str, ...]]
    """By variable; of state variables both as they were and as they are."""
    observed: tuple[tuple[str, str], ...]
    """Fully observed state variables, before and after."""
    hidden: tuple[str, str]
    action: str
    seen: str
    start: dict[str, Table]
    moves: dict[str, Table]
    shown: Table
    rewards: Table

    def value(self) -> float:
        """The largest expected discounted sum of rewards; the document must end by itself."""
        start = {}
        for name, _ in self.observed:
            table = self.start[name]
            assert sorted(set(table.numbers)) == [0.0, 1.0]
            start[name] = self.values[name][int(table.numbers.argmax())]
        belief = self.start[self.hidden[0]].numbers[None]
        return float(self._value(start, belief)[0])

    def _value(self, at: Assignment, masses: Array) -> Array:
        """(b,) of unnormalised beliefs (b, hidden values) in one observed state."""
        if not len(masses) or self._is_over(at):
            return np.zeros(len(masses))
        values = [self._q(at, masses, action) for action in self.values[self.action]]
        best: Array = np.max(values, axis=0)
        return best

    def _q(self, at: Assignment, masses: Array, action: str) -> Array:
        at = {**at, self.action: action}
        value: Array = masses @ self._row(self.rewards, at, self.hidden[0])
        before, after = self.hidden
        moved = masses @ self._row(self.moves[after], at, before, after)
        for following, p in self._following(at):
            chances = self._row(self.shown, {**following, self.action: action}, after, self.seen)
            following_masses = (moved[:, None, :] * chances.T).reshape(-1, moved.shape[1])
            possible = following_masses.sum(axis=1) > 0.0
            below = np.zeros(len(following_masses))
            below[possible] = self._value(self._renamed(following), following_masses[possible])
            value = value + self.discount * p * below.reshape(len(masses), -1).sum(axis=1)
        return value

    def _following(self, at: Assignment) -> list[tuple[Assignment, float]]:
        """Observed states after an action, and their chances."""
        after: list[tuple[Assignment, float]] = [({}, 1.0)]
        for _, name in self.observed:
            row = self._row(self.moves[name], at, name)
            after = [
                ({**one, name: value}, p * float(q))
                for one, p in after
                for value, q in zip(self.values[name], row, strict=True)
                if q > 0.0
            ]
        return after

    def _is_over(self, at: Assignment) -> bool:
        """Whether nothing is earned any more, whatever is done."""
        known, open_ends = [at], [at]
        while open_ends:
            here = open_ends.pop()
            for action in self.values[self.action]:
                acting = {**here, self.action: action}
                if self._row(self.rewards, acting, self.hidden[0]).any():
                    return False
                after = [self._renamed(one) for one, _ in self._following(acting)]
                new = [one for one in after if one not in known]
                known, open_ends = known + new, open_ends + new
        return True

    def _renamed(self, after: Assignment) -> Assignment:
        return {name: after[new] for name, new in self.observed}

    def _row(self, table: Table, at: Assignment, *free: str) -> Array:
        """A table at some values, along the variables that are left; those must be `free`."""
        index = tuple(
            slice(None) if name in free else self.values[name].index(at[name])
            for name in table.variables
        )
        left = tuple(name for name in table.variables if name in free)
        numbers: Array = table.numbers[index]
        if left == free:
            return numbers
        assert not left or left == free[-len(left) :], (left, free)
        shape = tuple(len(self.values[name]) for name in free)
        return np.broadcast_to(numbers, shape)


def read(document: bytes) -> Document:
    """A document, checked."""
    root = ET.fromstring(document)
    assert root.tag == "pomdpx" and root.get("version") == "1.0"
    values, observed, hidden = _state_variables(root)
    action, seen = (_named(root, tag, values) for tag in ("ActionVar", "ObsVar"))
    (_,) = root.iterfind("Variable/RewardVar")
    shown = _tables(root, "ObsFunction/CondProb", values)
    rewards = [_table(func, values, "ValueTable") for func in root.iterfind("RewardFunction/Func")]
    assert len(hidden) == 1 and list(shown) == [seen] and len(rewards) == 1
    return Document(
        discount=float(root.findtext("Discount", "")),
        values=values,
        observed=tuple(observed),
        hidden=hidden[0],
        action=action,
        seen=seen,
        start=_tables(root, "InitialStateBelief/CondProb", values),
        moves=_tables(root, "StateTransitionFunction/CondProb", values),
        shown=shown[seen],
        rewards=rewards[0],
    )


def _state_variables(
    root: ET.Element,
) -> tuple[dict[str, tuple[str, ...]], list[tuple[str, str]], list[tuple[str, str]]]:
    values: dict[str, tuple[str, ...]] = {}
    observed: list[tuple[str, str]] = []
    hidden: list[tuple[str, str]] = []
    for variable in root.iterfind("Variable/StateVar"):
        names = variable.attrib["vnamePrev"], variable.attrib["vnameCurr"]
        values |= dict.fromkeys(names, tuple(variable.findtext("ValueEnum", "").split()))
        (observed if variable.get("fullyObs") == "true" else hidden).append(names)
    return values, observed, hidden


def _named(root: ET.Element, tag: str, values: dict[str, tuple[str, ...]]) -> str:
    (variable,) = root.iterfind(f"Variable/{tag}")
    values[variable.attrib["vname"]] = tuple(variable.findtext("ValueEnum", "").split())
    return variable.attrib["vname"]


def _tables(root: ET.Element, path: str, values: dict[str, tuple[str, ...]]) -> dict[str, Table]:
    tables = {}
    for one in root.iterfind(path):
        table = _table(one, values, "ProbTable")
        assert np.allclose(table.numbers.sum(axis=-1), 1.0, rtol=0.0, atol=1e-12)
        assert (table.numbers >= 0.0).all()
        tables[table.variables[-1]] = table
    return tables


def _table(one: ET.Element, values: dict[str, tuple[str, ...]], tag: str) -> Table:
    """Numbers of a table. Of chances, what is not mentioned beside a mentioned value is zero."""
    variables = tuple(name for name in one.findtext("Parent", "").split() if name != "null")
    if tag == "ProbTable":
        variables = (*variables, one.findtext("Var", ""))
    sets = [values[name] for name in variables]
    numbers = np.zeros([len(each) for each in sets])
    said = np.zeros(numbers.shape, dtype=np.int64)
    for entry in one.iterfind("Parameter[@type='TBL']/Entry"):
        instance = entry.findtext("Instance", "").split()
        row = np.array(entry.findtext(tag, "").split(), dtype=np.float64)
        index = [
            np.arange(len(each)) if word in "-*" else np.array([each.index(word)])
            for word, each in zip(instance, sets, strict=True)
        ]
        shape = [len(each) if word == "-" else 1 for word, each in zip(instance, sets, strict=True)]
        numbers[np.ix_(*index)] = row.reshape(shape)
        said[np.ix_(*index)] += 1
    assert said.max() == 1, f"{variables}: said twice"
    once = said.any(axis=-1) if tag == "ProbTable" else said
    assert once.all(), f"{variables}: left out {list(itertools.islice(np.argwhere(~once), 3))}"
    return Table(variables, numbers)
