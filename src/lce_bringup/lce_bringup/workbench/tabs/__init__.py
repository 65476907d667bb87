# SPDX-License-Identifier: Apache-2.0
"""The tabs of the page, a function each: it fills the tab with what the workbench knows now."""
