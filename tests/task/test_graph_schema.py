import json
import subprocess
import sys
from pathlib import Path

from grip_bt.task import schema
from grip_bt.task.model import KINDS

PUBLISHED = Path(__file__).parents[2] / "docs" / "task.schema.json"


def test_the_published_schema_is_fresh():
    assert json.loads(PUBLISHED.read_text()) == schema(), "run: grip check --schema > docs/task.schema.json"


def test_the_schema_has_every_kind_and_the_file_keys_of_a_leaf():
    shapes = schema()["$defs"]
    kinds = {s["properties"]["kind"]["const"] for s in shapes.values() if "kind" in s.get("properties", {})}
    assert kinds == set(KINDS)
    leaf = shapes["Leaf"]
    assert {"node", "with", "in", "out", "meaning", "on", "doc", "precondition"} == set(leaf["properties"])
    assert leaf["patternProperties"] == {"^x-": {}}
    assert leaf["additionalProperties"] is False


def test_importing_the_graph_loads_neither_yaml_nor_numerics():
    code = (
        "import sys, grip_bt.task, grip_bt.task.catalog, grip_bt.task.validation; "
        "print([m for m in ('ruamel.yaml', 'numpy', 'networkx', 'py_trees') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
