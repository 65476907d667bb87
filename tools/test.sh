#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tests of every tier: first those that can run side by side, then those in real time, one by one and with the machine
# to themselves. Of those, one that fails is run once more, since a shared machine may stand still for seconds; what it
# said is shown. Whatever failed is named in the end; so is what was skipped, and the command that would change it.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
failed=0
logs=$PWD/log/tests
colour=()
[[ -t 1 ]] && colour=(--color=yes)
rm -rf "$logs"
mkdir -p "$logs"

shown() { # NAME PYTEST OPTIONS...
    local name=$1
    shift
    pytest -rfEs "${colour[@]}" "$@" | tee "$logs/$name"
}

shown "side by side" -m "not alone" --numprocesses auto --dist worksteal --timeout 600 || failed=$?
shown "in real time" -m alone --reruns 1 -rfEsR --rerun-show-tracebacks || failed=$?

skipped=$(cat "$logs"/* | sed 's/\x1b\[[0-9;]*m//g' | grep '^SKIPPED' | sort -u)
printf '\nSkipped on this machine:\n%s\n\nAll in all:\n' "${skipped:-none}"
for log in "$logs"/*; do
    sed 's/\x1b\[[0-9;]*m//g' "$log" | grep -E '^(FAILED|ERROR|RERUN) '
    printf '%-14s %s\n' "$(basename "$log")" "$(tail -n 1 "$log")"
done
exit "$failed"
