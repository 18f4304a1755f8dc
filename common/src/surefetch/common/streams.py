"""Every random number has an address: family, seed, purpose, and where in that purpose.

Streams of different addresses are independent, so nobody's draws move anybody else's.
"""

import hashlib

import msgspec
import numpy as np


def stream(family: str, seed: int, purpose: str, *index: int | str) -> np.random.Generator:
    """The generator at one address; the same address gives the same numbers everywhere.

    Philox is counter-based: its 128-bit key is the BLAKE2b digest of the address, so that near
    addresses share nothing.

    Source: Salmon et al., Parallel random numbers: as easy as 1, 2, 3 (2011).
    """
    address = msgspec.json.encode([family, seed, purpose, *index])
    digest = hashlib.blake2b(address, digest_size=16).digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(digest, "little")))
