# SPDX-License-Identifier: Apache-2.0
"""The tabs of the page, a module each: its ``fill`` fills the tab with what the workbench knows now.

A tab that follows by itself returns what brings it up to date; the others are filled anew when something has changed.
"""
