#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Gets what some tests need and no wheel brings: a Chromium (page and report) and Aravis' fake camera.
# As root it installs system packages; elsewhere playwright brings a browser into .venv. It never asks, and a failure
# only means skipped tests. `make setup` calls it once; LCE_TEST_EXTRAS=no keeps it from doing anything.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
venv=$PWD/.venv
log=$PWD/log/test_extras.log
SYSTEM_PYTHON=/usr/lib/python3/dist-packages

quietly() { timeout 600 "$@" < /dev/null >> "$log" 2>&1; }

say() { printf 'setup: %s\n' "$*"; }

has_chromium() {
    local name
    for name in chromium chromium-browser google-chrome; do
        type -P "$name" > /dev/null && return
    done
    compgen -G "$venv/browsers/chromium-*/chrome-linux*/chrome" > /dev/null
}

has_camera() {
    type -P arv-fake-gv-camera-0.8 > /dev/null &&
        "$venv/bin/python" -c 'import gi; gi.require_version("Aravis", "0.8")' 2> /dev/null
}

apt_install() {
    [[ $EUID -eq 0 ]] && type -P apt-get > /dev/null || return
    local options=(-o DPkg::Lock::Timeout=60 -o Acquire::Retries=0 -o Acquire::http::Timeout=20)
    local words=(env DEBIAN_FRONTEND=noninteractive apt-get "${options[@]}" install -y --no-install-recommends "$@")
    quietly "${words[@]}" || { quietly apt-get "${options[@]}" update && quietly "${words[@]}"; }
}

link_gi() { # .venv does not see system packages; PyGObject is one, compiled for the system's own Python
    local tag packages
    tag=$("$venv/bin/python" -c 'import sys; print("cpython-%d%d" % sys.version_info[:2])')
    packages=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
    compgen -G "$SYSTEM_PYTHON/gi/_gi.$tag-*.so" > /dev/null && [[ ! -e $packages/gi ]] &&
        ln -sfn "$SYSTEM_PYTHON/gi" "$packages/gi"
}

main() {
    [[ ${LCE_TEST_EXTRAS:-yes} != no ]] || return 0
    mkdir -p log
    : > "$log"
    if ! has_chromium; then
        say "Chromium for the tests of page and report"
        apt_install chromium
        has_chromium || PLAYWRIGHT_BROWSERS_PATH=$venv/browsers quietly "$venv/bin/python" -m playwright install chromium
        has_chromium || say "no Chromium to be had (log/test_extras.log); its tests will be skipped"
    fi
    if ! has_camera; then
        link_gi
        has_camera || { apt_install python3-gi gir1.2-aravis-0.8 aravis-tools && link_gi; }
        has_camera || say "no Aravis to be had (log/test_extras.log); the tests of the camera emulator will be skipped"
    fi
}

main
exit 0
