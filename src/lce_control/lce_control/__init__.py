# SPDX-License-Identifier: Apache-2.0
"""Position control of the strip, chapter 6 of Wu (2021).

The run-time algorithms lie here and know no ROS; a new controller is one more module beside :mod:`lce_control.cascade`.
Each controller has its node in :mod:`lce_control.nodes`; gains are found offline in :mod:`lce_control.tuning`.
"""
