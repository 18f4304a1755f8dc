"""Grasping alone, from observed points: seen, proposed, reached, closed, lifted, delivered.

pytest -s -m long tests/system/test_grasp_benchmark.py
"""

import sys
from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from grasp_scenes import Trial, crowded, single
from grasp_trials import Bench, Result

from surefetch.evaluation.running.metrics import wilson

TRIALS = 300


def test_a_few_objects_alone_and_in_tight_places_are_fetched() -> None:
    results = attempts(single, range(900, 904)) + attempts(crowded, range(900, 904))
    assert sum(not result.cause for result in results) >= 7, report("", results)


@pytest.mark.long
@pytest.mark.timeout(5400)
def test_97_percent_of_single_objects_are_lifted_and_delivered() -> None:
    results = attempts(single, range(TRIALS))
    print(report("single objects", results))
    assert sum(not result.cause for result in results) >= 0.97 * TRIALS


@pytest.mark.long
@pytest.mark.timeout(5400)
def test_90_percent_are_delivered_with_a_neighbour_or_wall_within_40_mm() -> None:
    results = attempts(crowded, range(TRIALS))
    print(report("a neighbour or wall within 40 mm", results))
    assert sum(not result.cause for result in results) >= 0.90 * TRIALS


def attempts(draw: Callable[[int], Trial], seeds: Sequence[int]) -> list[Result]:
    """Trials one after another on one simulated cell; failures are told as they come."""
    bench = Bench()
    try:
        results = []
        for seed in seeds:
            results.append(bench.attempt(draw(seed)))
            if results[-1].cause:
                print(results[-1], file=sys.stderr)
        return results
    finally:
        bench.close()


def report(title: str, results: Sequence[Result]) -> str:
    """Delivered by place and by shape with 95 % Wilson intervals; causes; seconds a step."""
    places = sorted({result.trial.where for result in results})
    shapes = sorted({result.trial.target.shape for result in results})
    rows = [_row("all", results)]
    rows += [_row(name, [r for r in results if r.trial.where == name]) for name in places]
    rows += [_row(name, [r for r in results if r.trial.target.shape == name]) for name in shapes]
    causes = Counter(result.cause for result in results if result.cause)
    seconds = {
        step: float(np.median([r.seconds[step] for r in results if step in r.seconds]))
        for step in sorted({step for result in results for step in result.seconds})
    }
    failures = [f"  {result}" for result in results if result.cause]
    told = ", ".join(f"{step} {median:.2f}" for step, median in seconds.items())
    return "\n".join(
        ["", title, *rows, f"causes: {dict(causes)}", *failures, f"median seconds: {told}"]
    )


def _row(name: str, results: Sequence[Result]) -> str:
    done, n = sum(not result.cause for result in results), len(results)
    low, high = wilson(done, n)
    share = f"{100 * done / n:5.1f} %  [{100 * low:.1f}, {100 * high:.1f}]"
    return f"  {name:18} {done:3}/{n:<3} {share}"
