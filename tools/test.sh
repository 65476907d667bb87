#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# All tests: first those that can run side by side, then those that need the machine to themselves.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
failed=0
pytest -m "not alone" --numprocesses auto --dist worksteal || failed=$?
pytest -m alone || failed=$?
exit "$failed"
