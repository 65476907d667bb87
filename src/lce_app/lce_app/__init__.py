# SPDX-License-Identifier: Apache-2.0
"""What a user runs: use cases, the command `lce` and the local page. A new ability begins in ``use_cases``.

``use_cases``   what the bench can do, one function a module.
``cli``         commands: they parse, call a use case and print.
``workbench``   the local web page over the same use cases.
"""
