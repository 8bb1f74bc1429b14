import re
from pathlib import Path

import pytest

from grip_bt.task import loads, read_text
from grip_bt.task.catalog import Catalog, TaskTexts, read_manifests
from grip_bt.task.catalog.project_parts import PartNames, Problem, ProjectParts
from grip_bt.task.validation import SEVERITY, validate

DOCS = Path(__file__).parents[3] / "docs"
DOC = (DOCS / "rules_by_example.md").read_text()
EXAMPLES = {
    code: (bad, good)
    for code, bad, good in re.findall(
        r'^## ([a-z-]+)\n.*?^```yaml title="bad"\n(.*?)^```.*?^```yaml title="good"\n(.*?)^```',
        DOC,
        re.DOTALL | re.MULTILINE,
    )
}
EQUIPMENT = ProjectParts(
    arms={
        "left": PartNames({"state": ["home"], "taught": []}),
        "right": PartNames(problems=(Problem("unfit-project", "grip.yaml: arms/right: unknown planner 'RRTConect'"),)),
        "spare": PartNames(problems=(Problem("no-controller", "grip.yaml: ros/controllers: none for 'spare'"),)),
    },
    hands={"claw": PartNames({"posture": ["open", "closed"], "finger": ["thumb"], "link": ["palm"]})},
    packages=["geometry_msgs", "std_msgs"],
)


@pytest.fixture(scope="module")
def catalog(tmp_path_factory):
    file = tmp_path_factory.mktemp("catalogue") / "nodes.yaml"
    file.write_text(re.search(r'```yaml title="catalogue"\n(.*?)```', DOC, re.DOTALL)[1])
    files = re.findall(r'^```yaml title="(tasks/\S+)"\n(.*?)^```', DOC, re.DOTALL | re.MULTILINE)
    tasks = TaskTexts({name: loads(text) for name, text in files})
    known = Catalog(read_manifests(file), tasks).with_(named=lambda: {"poses": {"above_bin"}})
    return known.with_(parts=lambda: EQUIPMENT)


def test_every_code_is_in_the_table_with_its_severity_and_has_examples():
    page = (DOCS / "validation_rules.md").read_text()
    table = dict(re.findall(r"^\| \[([a-z-]+)\]\(rules_by_example.md#\1\) \| (error|warning) \|", page, re.MULTILINE))
    assert table == SEVERITY
    assert set(EXAMPLES) == set(SEVERITY)


@pytest.mark.parametrize("code", SEVERITY)
def test_the_bad_example_has_this_issue_and_no_other(code, catalog):
    document = read_text(EXAMPLES[code][0], "bad.yaml")
    report = validate(document.task, catalog, document)
    assert {issue.code for issue in report.issues} == {code}
    for issue in report.issues:
        assert issue.severity == SEVERITY[code]
        assert issue.line is not None
        assert str(issue).startswith(f"bad.yaml:{issue.line}:{issue.column}: {issue.severity}[{code}] ")


@pytest.mark.parametrize("code", SEVERITY)
def test_the_good_example_has_no_issue(code, catalog):
    task = read_text(EXAMPLES[code][1], "good.yaml").task
    assert [str(issue) for issue in validate(task, catalog).issues] == []


@pytest.mark.parametrize(
    ("node", "advice"),
    [
        (
            "{node: eye/find, with: {cloud: 3}}",
            "'cloud' is an input: declare a variable, `data: {cloud: PointCloud}`, and bind it: `in: {cloud: cloud}`; "
            "write it first",
        ),
        (
            "{node: arm/take, with: {arm: left, grasps: 3}}",
            "'grasps' is an input: declare a variable, `data: {grasps: {type: list[Grasp], value: ...}}`, and bind it: "
            "`in: {grasps: grasps}`",
        ),
        ("{node: eye/look, in: {times: t}}", "'times' is a parameter: give it as a literal, `with: {times: ...}`"),
    ],
)
def test_a_name_of_the_other_side_is_told_to_be_one(node, advice, catalog):
    document = read_text(f"grip: 1\nname: demo\ndata: {{t: {{type: int, value: 1}}}}\nroot: {node}\n", "task.yaml")
    report = validate(document.task, catalog, document)
    assert [i.fix for i in report.issues if i.code in ("unknown-parameter", "unknown-input")] == [advice]


@pytest.mark.parametrize(
    ("type_", "advice"),
    [
        ("int", "give a literal of type int, or leave `value` out and write the variable first"),
        ("Pose", "give a literal of type Pose, or leave `value` out and write the variable first"),
        ("Trajectory | None", "no literal is a Trajectory: leave `value` out and write the variable first"),
    ],
)
def test_a_value_that_cannot_be_written_is_told_to_be_made(type_, advice):
    text = f"grip: 1\nname: demo\ndata: {{v: {{type: {type_}, value: [1, 2]}}}}\nroot: {{node: flow/wait}}\n"
    report = validate(read_text(text, "task.yaml").task, Catalog.builtin())
    assert [i.fix for i in report.issues if i.code == "wrong-initial-value"] == [advice]
