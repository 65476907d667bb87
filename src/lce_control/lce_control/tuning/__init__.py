# SPDX-License-Identifier: Apache-2.0
"""Offline: controllers closed over a simulated strip, judged, and tuned. Nothing that runs in a node imports it."""
