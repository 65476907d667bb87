# SPDX-License-Identifier: Apache-2.0
"""Runs prepared by recipes; the recordings stay as they are.

``steps``
    cut, detrend, resample and merge: plain values, each turning a run into another one.
``sampling``
    samples in intervals, and means over them.
``recipe``
    several steps, and their file.
``prepared_run``
    a recording and a recipe in, a run of its own out.
"""
