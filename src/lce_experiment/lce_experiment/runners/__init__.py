# SPDX-License-Identifier: Apache-2.0
"""How a plan is played on the node graph: in real time as processes, or fast in one process on simulated time."""
