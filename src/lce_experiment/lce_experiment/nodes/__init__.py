# SPDX-License-Identifier: Apache-2.0
"""Nodes of an experiment: players of waveforms and targets, the recorder. A new one also needs a line in setup.py."""
