# SPDX-License-Identifier: Apache-2.0
"""Series for the page: thinned to what the eye can see, and packed."""

import base64
import zlib

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BUCKETS = 900


class Arrays:
    """All numbers of a page as one deflated block of float32; the page gets (offset, length) for each array."""

    def __init__(self) -> None:
        self._parts: list[NDArray[np.float32]] = []
        self._length = 0

    def add(self, values: Floats) -> tuple[int, int]:
        """Keep an array (n,) and return where it is."""
        part = np.ascontiguousarray(values, dtype="<f4")
        self._parts.append(part)
        begin, self._length = self._length, self._length + part.size
        return begin, part.size

    def packed(self) -> str:
        """The block in base64."""
        raw = np.concatenate(self._parts).tobytes() if self._parts else b""
        return base64.b64encode(zlib.compress(raw, 9)).decode("ascii")


def visible(*series: Floats) -> NDArray[np.intp]:
    """Indices (m,) that draw all series (n,) as the full ones: the extremes of each in every bucket, and the ends."""
    n = series[0].size
    if n <= 4 * BUCKETS:
        return np.arange(n)
    edges = np.linspace(0, n, BUCKETS + 1).astype(np.intp)
    keep = [np.array([0, n - 1], dtype=np.intp)]
    for values in series:
        for begin, end in zip(edges[:-1], edges[1:], strict=True):
            part = values[begin:end]
            keep.append(np.array([begin + part.argmin(), begin + part.argmax()], dtype=np.intp))
    return np.unique(np.concatenate(keep))


def spread(n: int, most: int = 2500) -> NDArray[np.intp]:
    """Indices of at most ``most`` of n samples, evenly spread, for a cloud of points."""
    return np.unique(np.linspace(0, n - 1, min(n, most)).astype(np.intp))
