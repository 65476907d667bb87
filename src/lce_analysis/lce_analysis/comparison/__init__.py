# SPDX-License-Identifier: Apache-2.0
"""A model beside recorded runs: where it fails, and by how much.

``compare``      the comparison as a whole; a new measure of misfit is a field of its ``Metrics``.
``metrics``      measures of misfit.
``residuals``    correlations, profiles and maps of residuals.
``conditions``   operating conditions, and each one's share of the error.
``predictive_check``   simulations with noise and uncertainty beside the data.
``simulated_series``, ``sensor_process``   those simulations, and the noise in them.
"""
