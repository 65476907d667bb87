# SPDX-License-Identifier: Apache-2.0
import scipy.constants

from lce_model import constants


def test_constants_are_those_of_the_si() -> None:
    assert scipy.constants.Boltzmann == constants.BOLTZMANN
    assert scipy.constants.Stefan_Boltzmann == constants.STEFAN_BOLTZMANN
