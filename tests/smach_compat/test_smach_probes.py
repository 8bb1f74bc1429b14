"""No row of data/smach_probes.md is without a test: each test names the rows that it covers, as `# probe 28`."""

import re
from pathlib import Path

HERE = Path(__file__).parent


def test_every_probe_has_a_test():
    rows = re.findall(r"^\| (\d+) \|", (HERE / "data" / "smach_probes.md").read_text(), re.MULTILINE)
    named = re.findall(
        r"# probes? ([\d ]+)$",
        "\n".join(file.read_text() for file in HERE.glob("test_smach_*.py")),
        re.MULTILINE,
    )
    covered = {int(number) for numbers in named for number in numbers.split()}
    assert len(rows) == 95
    assert covered == {int(row) for row in rows}
