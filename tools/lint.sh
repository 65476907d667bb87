#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Every check of the sources, one after the other; all of them speak before the first failure counts.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
failed=()

check() { # NAME COMMAND...
    local name=$1 report
    shift
    if report=$("$@" 2>&1); then
        printf 'ok       %s\n' "$name"
    else
        printf '%s\nFAILED   %s\n' "$report" "$name"
        failed+=("$name")
    fi
}

check "ruff check" ruff check --output-format concise .
check "ruff format" ruff format --check --output-format concise .
check "mypy" mypy
check "import contract" lint-imports --no-logo
check "citation schema" check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff
check "plain English" python tools/plain_english.py
check "hadolint" hadolint docker/Dockerfile
check "compose schema" check-jsonschema --builtin-schema vendor.compose-spec docker/compose*.yaml
[[ ${#failed[@]} -eq 0 ]]
