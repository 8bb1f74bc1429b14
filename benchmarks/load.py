"""How long it takes from a task's file to its first tick, step by step, for tasks of some sizes; and one edit.

    .venv/bin/python benchmarks/load.py

CPU time [ms] in a warm process, the best of several rounds. `all` is the sum of read, validate and compile; `pyyaml` is
`yaml.load(text, yaml.CSafeLoader)` of the same text and in the same rounds, to compare with where the machine is busy.
`yaml` is the part of reading that makes the syntax tree, the rest is making the models.
"""

import time

import yaml

from grip_bt.base.yaml.tree import parse
from grip_bt.compilers import to_tree
from grip_bt.nodes import Leaf
from grip_bt.runtime import RunContext
from grip_bt.task import read_text
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.catalog.manifest import InputPort, OutputPort, Parameter
from grip_bt.task.edit import Rename, Set, apply, apply_to_document
from grip_bt.task.validation import validate

ROUNDS = 9
CATALOG = Catalog(
    [
        Manifest(
            id="bench/move",
            doc="Ends at once.",
            implementation="bench:Quick",
            parameters={"arm": Parameter(type="str"), "state": Parameter(type="str")},
            inputs={"cloud": InputPort(type="PointCloud")},
        ),
        Manifest(
            id="bench/look",
            doc="Sees.",
            implementation="bench:Quick",
            outputs={"cloud": OutputPort(type="PointCloud")},
        ),
    ]
)


class Quick(Leaf):
    def update(self):
        return self.end()


def text_of(nodes):
    """Return a task of about that many nodes, as a person writes it: groups of ten, a doc and a comment each."""
    lines = ["grip: 1", "name: bench", "data: {cloud: PointCloud}", "root:", "  kind: sequence", "  children:"]
    lines += ["    look: {node: bench/look, out: {cloud: cloud}}"]
    for group in range((nodes - 2) // 10):
        lines += [f"    group_{group}:", "      kind: fallback", "      children:"]
        for step in range(9):
            lines += [
                f"        step_{group}_{step}:  # why we do this",
                "          node: bench/move",
                f"          doc: Move to the named state number {step} of the arm and wait there for a while.",
                "          with: {arm: right, state: home}",
                "          in: {cloud: cloud}",
            ]
    return "\n".join(lines) + "\n"


def best(function, *arguments):
    """Return the best CPU time [ms] of a call, and its result."""
    time_, result = float("inf"), None
    for _ in range(ROUNDS):
        begin = time.process_time()
        result = function(*arguments)
        time_ = min(time_, time.process_time() - begin)
    return 1e3 * time_, result


def first_tick(task):
    tree = to_tree(task, CATALOG, leaf_factory=lambda path, node, face: Quick(path, path, face, {}, {}))
    tree.prepare(RunContext())
    return tree


def main():
    print(
        f"{'nodes':>6} {'kB':>5} {'read':>6} {'= yaml':>7} {'+ models':>9} {'validate':>9} {'compile':>8} {'all':>6}"
        f" {'pyyaml':>7} {'ratio':>6}"
    )
    for nodes in (100, 1000, 4000):
        text = text_of(nodes)
        yaml_, _ = best(parse, text)
        read, document = best(read_text, text)
        checking, report = best(validate, document.task, CATALOG)
        assert not report.issues, report.issues[:3]
        compiling, _ = best(first_tick, document.task)
        plain, _ = best(lambda text: yaml.load(text, yaml.CSafeLoader), text)
        whole = read + checking + compiling
        print(
            f"{nodes:6} {len(text) / 1e3:5.0f} {read:6.1f} {yaml_:7.1f} {read - yaml_:9.1f} {checking:9.1f} "
            f"{compiling:8.1f} {whole:6.1f} {plain:7.1f} {whole / plain:6.2f}"
        )
    text = text_of(1000)
    document = read_text(text)
    print()
    for command in (
        Set(path="group_50/step_50_4", key=("doc",), value="Other."),
        Rename(path="group_50", name="other"),
    ):
        on_task = best(apply, document.task, command)[0]
        on_text = best(apply_to_document, read_text(text), command)[0]
        print(f"1000 nodes: {command.do:7} on the task {on_task:5.1f}, on its text {on_text:6.1f}")


if __name__ == "__main__":
    main()
