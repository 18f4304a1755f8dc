"""Units of work over processes: each is done once, whatever becomes of the workers."""

import sys
from pathlib import Path

import pytest
from dying_units import Unit, done, work

from surefetch.common.errors import BadInput, InfrastructureError
from surefetch.evaluation.recordings import spread


@pytest.mark.parametrize("cores", [1, 2])
def test_every_unit_is_done(tmp_path: Path, cores: int) -> None:
    units = [Unit(tmp_path, f"unit {n}") for n in range(4)]
    assert sorted(spread.over_cores(work, units, cores, done)) == [u.name for u in units]


@pytest.mark.timeout(60)
def test_workers_are_replaced_and_every_unit_is_still_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(spread, "UNITS_PER_WORKER", 2)
    units = [Unit(tmp_path, f"unit {n}") for n in range(9)]
    assert sorted(spread.over_cores(work, units, 2, done)) == [u.name for u in units]


def test_a_killed_worker_costs_nothing_but_its_unit_again(tmp_path: Path) -> None:
    units = [Unit(tmp_path, f"unit {n}", dies=int(n == 1)) for n in range(4)]
    list(spread.over_cores(work, units, 2, done))
    assert all(map(done, units))


def test_workers_that_die_again_and_again_are_reported(tmp_path: Path) -> None:
    units = [Unit(tmp_path, "unit 0"), Unit(tmp_path, "unit 1", dies=99)]
    with pytest.raises(InfrastructureError, match="fewer --jobs"):
        list(spread.over_cores(work, units, 2, done))


def test_without_ray_the_command_says_how_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(BadInput, match=r"surefetch-evaluation\[ray\]"):
        list(spread.over_ray(work, [Unit(tmp_path, "unit 0")], "local"))


def test_a_ray_cluster_does_every_unit_though_a_worker_dies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ray")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))  # workers import dying_units
    units = [Unit(tmp_path, f"unit {n}", dies=int(n == 1)) for n in range(4)]
    assert sorted(spread.over_ray(work, units, "local")) == [u.name for u in units]


def test_an_address_without_a_ray_cluster_is_told(tmp_path: Path) -> None:
    pytest.importorskip("ray")
    with pytest.raises(BadInput, match="no Ray cluster at auto"):
        list(spread.over_ray(work, [Unit(tmp_path, "unit 0")], "auto"))
