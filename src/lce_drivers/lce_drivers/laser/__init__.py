# SPDX-License-Identifier: Apache-2.0
"""Laser: power limits, interlock, clock watch, the LabJack adapter, the node. Another device: a row of ``DEVICES``."""
