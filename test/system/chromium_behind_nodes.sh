#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Chromium draws without a graphics card here, on the cores that nodes in real time need: it comes after them.
exec nice -n 10 "$CHROMIUM" "$@"
