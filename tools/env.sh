#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs a command in the workspace's environment, whatever the calling shell has sourced: tools/env.sh lce --help
# LCE_UNDERLAY=/path/to/install puts another workspace under this one, such as one with the ros2 command (test/README.md).
set -eo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ ! -e $root/.venv/setup.bash || ! -e $root/install/setup.bash ]]; then
    echo "env.sh: nothing is set up here yet; run make setup" >&2
    exit 1
fi
unset PYTHONPATH PYTHONHOME AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH RMW_IMPLEMENTATION LCE_CACHE_DIR
# shellcheck disable=SC1091
source "$root/.venv/setup.bash"
# shellcheck disable=SC1091
[[ -z ${LCE_UNDERLAY:-} ]] || source "$LCE_UNDERLAY/local_setup.bash"
# shellcheck disable=SC1091
source "$root/install/setup.bash"
exec "$@"
