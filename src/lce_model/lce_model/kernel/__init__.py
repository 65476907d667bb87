# SPDX-License-Identifier: Apache-2.0
"""From terms to machine code: ``generate`` writes the loop as Python, ``compose`` compiles and caches it with numba."""
