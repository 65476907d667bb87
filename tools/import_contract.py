# SPDX-License-Identifier: Apache-2.0
"""The import contract that import-linter has no type for: ROS in node modules (`*_node`) and a few named ones only."""

from grimp import ImportGraph
from importlinter import Contract, ContractCheck, fields, output


class RosInNodes(Contract):
    """Modules that import ROS themselves are named `*_node`, or lie in `allowed_modules`.

    Attributes:
        ros_packages: top-level packages that count as ROS.
        allowed_modules: modules and packages that may import them besides.
    """

    ros_packages = fields.SetField(subfield=fields.StringField())
    allowed_modules = fields.SetField(subfield=fields.StringField())

    def check(self, graph: ImportGraph, verbose: bool) -> ContractCheck:
        breaches = sorted(
            (importer, imported)
            for imported in self.ros_packages & graph.modules
            for importer in graph.find_modules_that_directly_import(imported)
            if not self._may(importer)
        )
        return ContractCheck(kept=not breaches, metadata={"breaches": breaches})

    def _may(self, importer: str) -> bool:
        within = any(f"{importer}.".startswith(f"{allowed}.") for allowed in self.allowed_modules)
        return within or importer.endswith("_node")

    def render_broken_contract(self, check: ContractCheck) -> None:
        for importer, imported in check.metadata["breaches"]:
            output.print_error(f"{importer} imports {imported}, and is not a node module (named *_node)")
