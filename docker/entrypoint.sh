#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs a command in the workspace; `node PACKAGE EXECUTABLE ...` runs a node.
set -e
# shellcheck disable=SC1091
source /bench/install/setup.bash
if [[ ${1:-} == node ]]; then
    # Not `ros2 run`: a stop signal would end that and leave the node, and its laser, to be killed.
    set -- "/bench/install/$2/lib/$2/$3" "${@:4}"
fi
exec "$@"
