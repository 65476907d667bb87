# SPDX-License-Identifier: Apache-2.0
"""Foreign recordings made runs: how a table is written, what its columns mean, and in which units.

``units`` and ``headers``
    spellings of units, and words by which columns are recognised.
``layout``
    separator, decimal sign, encoding, header and first row of a text table.
``plausible``
    the unit that a column has by its values, where its header does not say.
``table`` and ``bag``
    a text table, or chosen topics of a bag, as channels in SI units.
``recording``
    what was understood of a file, and the run that is written.
"""
