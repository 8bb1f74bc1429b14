"""Write the golden files again: `python` this file; then read the difference."""

from test_standalone_files import GOLDEN, TASKS, exported

if __name__ == "__main__":
    for name in TASKS:
        (GOLDEN / f"{name}.py").write_text(exported(GOLDEN / f"{name}.yaml"))
