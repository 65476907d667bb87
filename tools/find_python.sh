#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Prints the interpreter to build .venv with, or says what this machine lacks. LCE_PYTHON=... overrides the search.
set -euo pipefail

CHECK='
import os, platform, sys, sysconfig
lacks = []
if sys.version_info[:2] not in ((3, 11), (3, 12)):
    lacks.append("is Python %d.%d; the ROS wheels and numpy pinned here are for 3.11 and 3.12" % sys.version_info[:2])
elif (platform.system(), platform.machine()) != ("Linux", "x86_64") or platform.libc_ver()[0] != "glibc":
    lacks.append("is not for x86-64 Linux with glibc, which the ROS wheels are made for (docker/ serves other machines)")
else:
    try:
        import ensurepip, venv
    except ImportError:
        lacks.append("has no venv module (Debian, Ubuntu: apt install python3-venv)")
    if not os.path.isfile(os.path.join(sysconfig.get_path("include"), "Python.h")):
        lacks.append("has no Python.h (Debian, Ubuntu: apt install python3-dev)")
print("; it ".join(lacks) or "good")
'

any_of() { # is one of these commands here
    local name
    for name in "$@"; do
        type -P "$name" > /dev/null && return
    done
    return 1
}

candidates() {
    if [[ -n ${LCE_PYTHON:-} ]]; then
        echo "$LCE_PYTHON"
        return
    fi
    type -aP python3.12 python3.11 python3 python || true
    local IFS=:
    for folder in $PATH; do
        compgen -G "$folder/python3.1[12]*" || true
    done | grep -E '/python3\.1[12]$' || true
}

main() {
    local missing=() tried='' seen=' ' python verdict real
    any_of "${CXX:-c++}" g++ clang++ ||
        missing+=("a C++ compiler (Debian, Ubuntu: apt install g++; Fedora: dnf install gcc-c++)")
    any_of "${CC:-cc}" gcc clang ||
        missing+=("a C compiler (Debian, Ubuntu: apt install gcc)")
    while read -r python; do
        # A pyenv shim exists for versions that are not switched on too; it then fails.
        # _base_executable: never the .venv that is active and may be about to be made anew.
        real=$("$python" -c 'import os, sys; print(os.path.realpath(sys._base_executable))' 2> /dev/null) || continue
        [[ $seen == *" $real "* ]] && continue
        seen+="$real "
        verdict=$("$real" -c "$CHECK" 2> /dev/null) || continue
        if [[ $verdict == good && ${#missing[@]} -eq 0 ]]; then
            echo "$real"
            return
        fi
        [[ $verdict == good ]] && tried='' && break
        tried+="setup:   $real $verdict"$'\n'
    done < <(candidates)
    [[ ${verdict:-none} == good ]] || missing+=("Python 3.11 or 3.12 with venv and headers${LCE_PYTHON:+ at LCE_PYTHON=$LCE_PYTHON}")
    for thing in "${missing[@]}"; do
        printf 'setup: missing: %s\n' "$thing" >&2
    done
    printf '%s' "$tried" >&2
    exit 1
}

main
