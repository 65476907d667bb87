#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Healthy (exit 0) when the node NAME says on /diagnostics, within a time-out, that it is not in error.

entrypoint.sh python3 /healthcheck.py /lce/laser
"""

import sys

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

TIMEOUT_S = 5.0  # nodes speak once a second; discovery takes up to three


def main(name: str) -> int:
    """Listen, print what the node said, and return the exit status."""
    rclpy.init()
    node = Node("healthcheck")
    heard: list[DiagnosticStatus] = []
    node.create_subscription(
        DiagnosticArray,
        "/diagnostics",
        lambda message: heard.extend(s for s in message.status if s.name.partition(":")[0] == name),  # "NODE: output"
        10,
    )
    clock = node.get_clock()
    end = clock.now().nanoseconds + int(TIMEOUT_S * 1e9)
    while not heard and clock.now().nanoseconds < end:
        rclpy.spin_once(node, timeout_sec=0.1)
    print(heard[0].message if heard else f"nothing from {name} in {TIMEOUT_S} s")
    rclpy.shutdown()
    return 0 if heard and heard[0].level < DiagnosticStatus.ERROR else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
