# SPDX-License-Identifier: Apache-2.0
"""The nodes of the controllers: parameters, topics and services around one algorithm of :mod:`lce_control` each.

A new controller's node derives from :class:`lce_control.nodes.controller_node.ControllerNode`; ``setup.py`` names its
executable, ``lce_experiment.registry`` the mode of control that it belongs to.
"""
