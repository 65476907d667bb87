# SPDX-License-Identifier: Apache-2.0
"""Signatures: what the residual of a model shows at once, from a catalogue, in words and as pictures."""

from lce_analysis.signatures.catalogue import signatures
from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries, residual_series
from lce_analysis.signatures.signature import Picture, Signature

__all__ = ["Picture", "ResidualSeries", "Signature", "SignatureOptions", "residual_series", "signatures"]
