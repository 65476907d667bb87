# SPDX-License-Identifier: Apache-2.0
"""From recorded runs to models and what is wrong with them: experiment → fit → residuals → report. No ROS nodes."""
