# SPDX-License-Identifier: Apache-2.0
"""Experiments on the node graph, from a plan to a recorded bag.

``protocols``, ``plan``   what is played. A new shape goes to :mod:`lce_data.waveforms`.
``registry``              the nodes of a bench. A new node is a line there.
``nodes``                 players and recorder.
``runners``               the graph in real time, or in lockstep on simulated time.
``positioning``           steps to a target displacement.
"""
