# SPDX-License-Identifier: Apache-2.0
"""Laser, thermal camera, distance sensor, simulator: pure parts, device adapters, a thin node each."""
