# SPDX-License-Identifier: Apache-2.0
"""Figures and tables of reports, one file a subject: functions from results of the analysis to blocks."""
