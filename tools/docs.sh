#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the site of the documents into site/. The first call installs requirements/docs.lock beside what setup installed;
# after that nothing is downloaded.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
stamp=.venv/.lce-docs
if ! cmp -s requirements/docs.lock "$stamp"; then
    printf 'docs: wheels of requirements/docs.lock ... '
    .venv/bin/python -m pip install -q --disable-pip-version-check --no-deps --no-compile -r requirements/docs.lock 2>&1 |
        { grep -v '^WARNING' || true; }
    cp requirements/docs.lock "$stamp"
    echo done
fi
export NO_MKDOCS_2_WARNING=true # mkdocs-material's banner about another project
export PYTHONWARNINGS="ignore:module 'sre_parse' is deprecated,ignore:module 'sre_constants' is deprecated" # lark 0.12
export PYTHONDONTWRITEBYTECODE=1
mkdocs build --strict "$@" 2>&1 | { grep -v '^INFO ' || true; }
echo "docs: site/index.html; search works from there, and from 'python3 -m http.server -d site'"
