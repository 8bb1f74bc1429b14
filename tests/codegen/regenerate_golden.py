"""Write the golden packages again: `python tests/codegen/regenerate_golden.py`; then read the difference."""

import test_component_kinds
from test_component_render import COMPONENT, GOLDEN, SPEC

from grip_bt.codegen import render, write_package

if __name__ == "__main__":
    write_package(GOLDEN, render(COMPONENT, SPEC))
    for name, (component, interface) in test_component_kinds.CASES.items():
        write_package(test_component_kinds.GOLDEN / name, render(component, interface))
