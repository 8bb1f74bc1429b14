"""The contract is checked field by field, everything at once."""

from __future__ import annotations

import pytest

from grip_bt.base.errors import ContractError
from grip_bt.codegen import check_contract
from grip_bt.codegen.render import component_manifest
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.ros_config import FieldSpec, InterfaceSpec

CLOUD = FieldSpec("input", "sensor_msgs/msg/PointCloud2")
OUTCOME = FieldSpec("outcome", "int32")
RETURNED = FieldSpec("returned_object", "my_pkg/msg/Grasp", array=True)


def component(**more):
    given = {"name": "c", "interface": "my_pkg/srv/Do", "server": "/do", "outcomes": ("one", "none")}
    return ComponentFile.model_validate(given | more)


def interface(request=(CLOUD,), response=(OUTCOME, RETURNED)):
    return InterfaceSpec("my_pkg", "srv", "Do", tuple(request), tuple(response))


def problems(component, interface):
    with pytest.raises(ContractError) as caught:
        check_contract(component, interface)
    return caught.value.problems


@pytest.mark.parametrize("width", ["int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"])
def test_an_outcome_may_be_any_integer(width):
    check_contract(component(), interface(response=(FieldSpec("outcome", width), RETURNED)))


@pytest.mark.parametrize("wrong", [FieldSpec("outcome", "float32"), FieldSpec("outcome", "int32", array=True)])
def test_an_outcome_of_another_type_is_named_with_what_was_found(wrong):
    (problem,) = problems(component(), interface(response=(wrong, RETURNED)))
    assert problem == f"response: the field 'outcome' is {wrong.spelling}; it must be one integer, such as int32"


def test_missing_fields_are_all_named_with_what_is_there():
    told = problems(component(), interface((FieldSpec("inptu", "int32"),), ()))
    assert told == (
        "request: the field 'input' is missing; did you mean 'inptu'? (found: int32 inptu)",
        "response: the field 'outcome' is missing (found: no field at all)",
        "response: the field 'returned_object' is missing (found: no field at all)",
    )


def test_ports_must_be_fields_and_types_must_exist():
    told = problems(component(ports={"imput": "PointCloud", "input": "PointClud"}), interface())
    assert "'imput' isn't a field of the interface; did you mean 'input'?" in told[0]
    assert "'PointClud'" in told[1]


def test_another_interface_than_the_named_one_is_refused():
    (problem,) = problems(component(interface="my_pkg/srv/Other"), interface())
    assert problem == "interface: the component file says my_pkg/srv/Other, this is my_pkg/srv/Do"


def test_an_outcome_called_failure_can_not_mean_success():
    (problem,) = problems(component(outcomes=("one", "failure")), interface())
    assert "'failure' can't mean success" in problem
    check_contract(component(outcomes=("one", "failure"), meaning={"failure": "failure"}), interface())


def test_every_other_field_becomes_a_port():
    request = (CLOUD, FieldSpec("limit", "uint8", doc="at most"), FieldSpec("names", "string", array=True))
    response = (OUTCOME, RETURNED, FieldSpec("took", "float64"))
    made = component_manifest(
        component(ports={"returned_object": "list[Grasp]"}, meaning={"none": "failure"}), interface(request, response)
    )
    assert {name: (p.type, p.required) for name, p in made.inputs.items()} == {
        "input": ("sensor_msgs/msg/PointCloud2", True),
        "limit": ("int", False),
        "names": ("list[str]", False),
    }
    assert {name: p.type for name, p in made.outputs.items()} == {"returned_object": "list[Grasp]", "took": "float"}
    assert made.outcomes == {"one": "success", "none": "failure", "failure": "failure"}
    assert made.inputs["limit"].doc == "at most"
