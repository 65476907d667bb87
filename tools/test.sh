#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tests of every tier: first those that can run side by side, then those in real time, one by one.
# In the end: what was skipped, and the command that would change it.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
failed=0
log=$PWD/log/tests.log
colour=()
[[ -t 1 ]] && colour=(--color=yes)
mkdir -p log

shown() { # PYTEST OPTIONS...
    pytest -rs "${colour[@]}" "$@" | tee -a "$log"
}

: > "$log"
shown -m "not alone" --numprocesses auto --dist worksteal || failed=$?
shown -m alone || failed=$?
skipped=$(sed 's/\x1b\[[0-9;]*m//g' "$log" | grep '^SKIPPED' | sort -u)
printf '\nSkipped on this machine:\n%s\nThe summary of the tests side by side, and of those in real time:\n' "${skipped:-none}"
sed 's/\x1b\[[0-9;]*m//g' "$log" | grep -E '^(=+ )?[0-9]+ (passed|failed)|^FAILED|^ERROR'
exit "$failed"
