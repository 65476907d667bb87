# SPDX-License-Identifier: Apache-2.0
"""Steps to a target displacement: whether the strip can reach it, the plan, the outcome; and the tuning experiment."""
