"""The page on somebody's learned method: the files that it shows are what they say; nothing of it is run."""

import re
from pathlib import Path

import yaml

from grip_bt.task.catalog.component_file import load_component

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "learned_method.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r'^```\w+ title="([^"]+)"\n(.*?)^```$', PAGE, re.MULTILINE | re.DOTALL))


def test_its_component_is_one_and_says_what_its_messages_have(tmp_path):
    (tmp_path / "component.yaml").write_text(FILES["component.yaml"], encoding="utf-8")
    component = load_component(tmp_path)
    said = component.ports["grasps"].grasp
    message = FILES["interfaces/cgn_interfaces/msg/ContactGrasp.msg"]
    fields = {words[1] for line in message.splitlines() if len(words := line.split("#")[0].split()) == 2}
    assert {said.pose, said.width.field, said.quality.field} == fields
    request, response = FILES["interfaces/cgn_interfaces/srv/DetectGrasps.srv"].split("---\n")
    assert set(component.fixed) | {"cloud"} == set(re.findall(r"^\w\S* (\w+)", request, re.MULTILINE))
    assert "grasps" in response


def test_its_programs_compile_and_serve_what_the_component_names():
    programs = {name: text for name, text in FILES.items() if name.endswith(".py")}
    assert set(programs) == {"server.py", "torch_cluster.py"}
    for name, text in programs.items():
        compile(text, name, "exec")
    assert yaml.safe_load(FILES["component.yaml"])["server"] in programs["server.py"]
