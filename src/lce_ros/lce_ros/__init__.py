# SPDX-License-Identifier: Apache-2.0
"""What every node of the bench shares: QoS, declared parameters, diagnostics, tick times, and one way in and
out.

Import from the modules: ``held`` and ``parameters`` need no ROS, the others do.
"""
