#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tests of every tier. Those in real time run one by one; they mostly wait, so computations (pure and slow tests) fill
# the idle time of the cores at idle priority. Then come the other tests of nodes and processes, side by side.
# In the end: what was skipped, and the command that would change it.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
failed=0
logs=$PWD/log/tests
colour=()
[[ -t 1 ]] && colour=(--color=yes)
idle=(nice -n 19)
chrt --idle 0 true 2> /dev/null && idle=(chrt --idle 0)
rm -rf "$logs"
mkdir -p "$logs"

shown() { # NAME PYTEST OPTIONS...
    local name=$1
    shift
    pytest -rs "${colour[@]}" "$@" | tee "$logs/$name"
}

quiet() { # NAME PYTEST OPTIONS...
    local name=$1
    shift
    "${idle[@]}" pytest -rs "${colour[@]}" "$@" > "$logs/$name" 2>&1
}

quiet computations -m "not (ros or system or alone)" --numprocesses auto --dist worksteal --timeout 600 &
computations=$!
trap 'kill "$computations" 2> /dev/null' EXIT
shown "real time" -m alone || failed=$?
shown "nodes and processes" -m "(ros or system) and not alone" --numprocesses auto --dist worksteal || failed=$?
wait "$computations" || failed=$?
cat "$logs/computations"

skipped=$(cat "$logs"/* | sed 's/\x1b\[[0-9;]*m//g' | grep '^SKIPPED' | sort -u)
printf '\nSkipped on this machine:\n%s\n\nAll in all:\n' "${skipped:-none}"
for log in "$logs"/*; do
    sed 's/\x1b\[[0-9;]*m//g' "$log" | grep -E '^(FAILED|ERROR) '
    printf '%-20s %s\n' "$(basename "$log")" "$(tail -n 1 "$log")"
done
exit "$failed"
