"""Independent units of work over the cores of this machine, or over a Ray cluster.

A unit is done when its result is on disk, so one that is lost with its worker is simply done again.
"""

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from importlib import import_module
from typing import Any, Final, TypeVar

from surefetch.common.errors import BadInput, InfrastructureError

J = TypeVar("J")
D = TypeVar("D")

ONE_THREAD: Final = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
UNITS_PER_WORKER: Final = 40
"""Workers are replaced after so many: a renderer keeps some memory of every scene.

A new pool is made for them. The pool's own `max_tasks_per_child` stands still for good when all
workers of Python 3.11 end at once.
"""
MOST_LOSSES: Final = 3
"""Workers that may be lost before the machine, and not chance, is to blame."""


def over_cores(
    work: Callable[[J], D], units: Sequence[J], cores: int, is_done: Callable[[J], bool]
) -> Iterator[D]:
    """What is said of every unit as it is done; a unit whose worker was lost is tried again.

    Raises:
        InfrastructureError: workers are lost again and again. What was done is kept.
    """
    if cores == 1:
        yield from map(work, units)
        return
    left = list(units)
    for _ in range(MOST_LOSSES):
        try:
            yield from _once(work, left, cores)
        except BrokenProcessPool:
            left = [unit for unit in left if not is_done(unit)]
        else:
            return
    raise InfrastructureError(
        f"workers were ended from outside {MOST_LOSSES} times, perhaps for want of memory. "
        f"{len(left)} units are left.\n  Run the same command again with fewer --jobs: what is "
        "done stays done."
    )


def _once(work: Callable[[J], D], units: Sequence[J], cores: int) -> Iterator[D]:
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    size = cores * UNITS_PER_WORKER
    for start in range(0, len(units), size):
        yield from _portion(work, units[start : start + size], cores)


def _portion(work: Callable[[J], D], units: Sequence[J], cores: int) -> Iterator[D]:
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(cores, mp_context=fresh) as pool:
        running = [pool.submit(work, unit) for unit in units]
        try:
            for one in as_completed(running):
                yield one.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def over_ray(work: Callable[[J], D], units: Sequence[J], address: str) -> Iterator[D]:
    """The same over a Ray cluster, whose machines share the folder that is written to.

    Args:
        work: does one unit, a core each.
        units: what is to be done.
        address: of the cluster, as `ray.init` takes it; `local` starts one here.

    Raises:
        BadInput: Ray is not installed, or there is no cluster at the address.
        InfrastructureError: workers are lost again and again. What was done is kept.
    """
    ray = _ray()
    one_thread = {"env_vars": dict.fromkeys(ONE_THREAD, "1")}
    try:
        ray.init(address=address, log_to_driver=False, runtime_env=one_thread)
    except (ConnectionError, ValueError) as error:
        raise BadInput(f"there is no Ray cluster at {address}: {error}") from None
    try:
        remote = ray.remote(num_cpus=1, max_retries=MOST_LOSSES, max_calls=UNITS_PER_WORKER)(work)
        waiting = [remote.remote(unit) for unit in units]
        while waiting:
            (done, *_), waiting = ray.wait(waiting, num_returns=1)
            yield ray.get(done)
    except ray.exceptions.WorkerCrashedError as lost:
        raise InfrastructureError(
            f"one unit lost its worker {MOST_LOSSES + 1} times: {lost}\n"
            "  Run the same command again: what is done stays done."
        ) from None
    finally:
        ray.shutdown()


def _ray() -> Any:
    try:
        return import_module("ray")
    except ImportError:
        raise BadInput(
            "--ray needs Ray, which is not installed here.\n"
            '  Install it: pip install "surefetch-evaluation[ray]"'
        ) from None
