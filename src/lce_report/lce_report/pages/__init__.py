# SPDX-License-Identifier: Apache-2.0
"""Reports, one file each: functions from a result to the text of a self-contained HTML file."""
