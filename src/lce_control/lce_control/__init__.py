# SPDX-License-Identifier: Apache-2.0
"""Position control of the strip. So far: the feed-forward service."""
