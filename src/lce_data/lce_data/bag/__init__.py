# SPDX-License-Identifier: Apache-2.0
"""Bags of rosbag2 with MCAP storage: read, write, repair. Messages of another type: a row of ``reader.NUMBERS``."""
