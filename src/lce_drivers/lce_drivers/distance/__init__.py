# SPDX-License-Identifier: Apache-2.0
"""Distance sensor: the Keyence adapter and the node. Another one: an adapter here, a row of the node's ``DEVICES``."""
