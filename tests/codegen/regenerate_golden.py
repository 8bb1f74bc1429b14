"""Write the golden package again: `python tests/codegen/regenerate_golden.py`; then read the difference."""

from test_component_render import COMPONENT, GOLDEN, SPEC

from grip_bt.codegen import render, write_package

if __name__ == "__main__":
    write_package(GOLDEN, render(COMPONENT, SPEC))
