# SPDX-License-Identifier: Apache-2.0
"""From blocks to HTML: templates are in ``templates/``, the script and style of the page in ``static/``."""
