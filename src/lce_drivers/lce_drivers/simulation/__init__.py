# SPDX-License-Identifier: Apache-2.0
"""The simulated strip, laser and sensors; the nodes of a real bench load none of it."""
