"""What the package offers has types: a strict checker takes the page's programs, and the stub has every name."""

import ast
import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest

import grip_bt
from grip_bt.app.runs.execute import RunOptions
from grip_bt.task.kinds import KINDS

ROOT = Path(__file__).parents[2]
STUB = ast.parse((ROOT / "grip_bt" / "__init__.pyi").read_text(encoding="utf-8"))
FENCES = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "python.md").read_text(encoding="utf-8"), re.DOTALL)
WRONG = """import grip_bt as grip

grip.loads("").show().safe("a.svg")
grip.run(grip.loads(""), robot="simulation")
grip.sequence("arm/lift")
"""


def test_the_options_of_a_run_are_those_that_there_are():
    (options,) = (node for node in STUB.body if getattr(node, "name", "") == "_Options")
    said = {each.target.id: ast.unparse(each.annotation) for each in options.body}
    there = {field.name: str(field.type) for field in fields(RunOptions)} | {"target": "Literal['bt', 'sm']"}
    assert said.items() <= there.items()


def test_the_stub_has_the_names_that_there_are():
    said = {node.name for node in STUB.body if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)}
    said |= {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign)}
    said |= {a.asname for node in STUB.body if isinstance(node, ast.ImportFrom) for a in node.names if a.asname}
    assert {name for name in said if name == "__version__" or name[0] != "_"} == {
        "__version__",
        *grip_bt.__all__,
        *KINDS,
    }


@pytest.mark.slow
def test_a_strict_checker_takes_the_programs_of_the_page_and_refuses_wrong_ones(tmp_path):
    for k, text in enumerate([*FENCES, WRONG]):
        (tmp_path / f"page_{k}.py").write_text(text)
    check = [
        sys.executable,
        "-m",
        "mypy",
        "--strict",
        "--cache-dir",
        str(tmp_path / "cache"),
        "--follow-imports=silent",
    ]
    done = subprocess.run([*check, str(tmp_path)], cwd=tmp_path, capture_output=True, text=True)
    found = [line for line in done.stdout.splitlines() if "error:" in line]
    assert len(found) == 3, done.stdout + done.stderr
    assert all(f"page_{len(FENCES)}.py" in line for line in found)
