# SPDX-License-Identifier: Apache-2.0
"""Thermal camera: radiometry, the FLIR adapter, the node. Another camera: an adapter here, a row of its ``DEVICES``."""
