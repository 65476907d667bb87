# SPDX-License-Identifier: Apache-2.0
"""The independent strip: data to judge fits by, from other equations than the models that are judged.

A distributed heat balance (length and thickness), domains with their own transition temperatures and
hysteresis, a nematic network's stretch; explicit midpoint steps of 1 ms. It imports nothing of src/ and must
not: it is the examiner. Nothing in it is tuned to make a particular model fit better (see strip.py for where
each number comes from).

    time_s, power_w = waves.pulse(amplitude_w=0.2, heating_s=40.0)
    response = simulate(CHAPTER_4, time_s, power_w)
    write_csv("run.csv", measure(response, seed=1))
"""

from . import waves
from .sensors import CAMERA, DISTANCE, Noise, Samples, measure, write_csv
from .simulation import LiveStrip, Response, absorbed_share, loop, loss_w, simulate
from .strip import CHAPTER_4, CHAPTER_5, Strip

__all__ = [
    "CAMERA",
    "CHAPTER_4",
    "CHAPTER_5",
    "DISTANCE",
    "LiveStrip",
    "Noise",
    "Response",
    "Samples",
    "Strip",
    "absorbed_share",
    "loop",
    "loss_w",
    "measure",
    "simulate",
    "waves",
    "write_csv",
]
