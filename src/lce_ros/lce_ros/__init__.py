# SPDX-License-Identifier: Apache-2.0
"""What every node shares: QoS, declared parameters, diagnostics, tick times, one way in and out of a process.

Import from the modules: ``domain``, ``parameters``, ``signals`` and ``timed_value`` need no ROS, the others do.
"""
