# SPDX-License-Identifier: Apache-2.0
"""Launch, experiment player, recorder and the `lce` command: the package that knows all the others."""

__version__ = "0.1.0"
