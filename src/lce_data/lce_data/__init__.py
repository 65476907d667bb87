# SPDX-License-Identifier: Apache-2.0
"""Channels, runs and file formats as plain values: the package that all others stand on. No physics, no ROS nodes."""

__version__ = "0.1.0"
