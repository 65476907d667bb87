# SPDX-License-Identifier: Apache-2.0
"""The commands of `lce`: one module each, with `add_arguments(parser)` and `main(args) -> int`."""
