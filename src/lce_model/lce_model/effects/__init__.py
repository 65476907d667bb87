# SPDX-License-Identifier: Apache-2.0
"""The library of candidate physical effects: each one a term in a file of its own, found here by its name."""
