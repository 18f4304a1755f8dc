"""Random streams: one address, one sequence."""

import numpy as np

from surefetch.common.streams import stream


def test_one_address_gives_one_sequence() -> None:
    first = stream("covered", 7, "layout", 3).random(8)
    assert np.array_equal(first, stream("covered", 7, "layout", 3).random(8))


def test_every_part_of_the_address_matters() -> None:
    addresses: list[tuple[str, int, str] | tuple[str, int, str, int | str]] = [
        ("covered", 7, "layout", 3),
        ("partial", 7, "layout", 3),
        ("covered", 8, "layout", 3),
        ("covered", 7, "camera", 3),
        ("covered", 7, "layout", 4),
        ("covered", 7, "layout", "3"),
        ("covered", 7, "layout"),
    ]
    assert len({float(stream(*address).random()) for address in addresses}) == len(addresses)


def test_seeds_beyond_64_bits_of_a_float_stay_apart() -> None:
    assert (
        stream("covered", 2**63 - 1, "layout").random()
        != stream("covered", 2**63 - 2, "layout").random()
    )


def test_the_numbers_are_pinned_so_that_a_seed_means_the_same_scene_tomorrow() -> None:
    drawn = stream("visible", 100, "layout", 0).integers(0, 2**32, size=3)
    assert drawn.tolist() == PINNED


PINNED = [947622070, 3773325166, 2313004300]
