# SPDX-License-Identifier: Apache-2.0
"""Position control of the strip (chapter 6): filters, PID, loops without ROS, and their nodes."""
