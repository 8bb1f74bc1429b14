import re
from pathlib import Path

import pytest

from grip_bt.catalog import Catalog, TaskTexts, read_manifests
from grip_bt.graph import loads, read_text
from grip_bt.validation import SEVERITY, validate

DOC = (Path(__file__).parents[2] / "docs" / "validation_rules.md").read_text()
EXAMPLES = {
    code: (bad, good)
    for code, bad, good in re.findall(
        r"^## ([a-z-]+)\n.*?^```yaml bad\n(.*?)^```.*?^```yaml good\n(.*?)^```", DOC, re.DOTALL | re.MULTILINE
    )
}


@pytest.fixture(scope="module")
def catalog(tmp_path_factory):
    file = tmp_path_factory.mktemp("catalogue") / "nodes.yaml"
    file.write_text(re.search(r"```yaml catalogue\n(.*?)```", DOC, re.DOTALL)[1])
    files = re.findall(r"^```yaml file (\S+)\n(.*?)^```", DOC, re.DOTALL | re.MULTILINE)
    return Catalog(read_manifests(file), TaskTexts({name: loads(text) for name, text in files}))


def test_every_code_is_in_the_table_with_its_severity_and_has_examples():
    table = dict(re.findall(r"^\| \[([a-z-]+)\]\(#\1\) \| (error|warning) \|", DOC, re.MULTILINE))
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
