from types import SimpleNamespace

import numpy as np
import pytest

from grip_bt.base.failures import BadReplyError, ServerLostError, ServerTimeOutError
from grip_bt.base.operation import Operation
from grip_bt.task.catalog.manifest import Manifest

MANIFEST = Manifest.model_validate(
    {
        "id": "component/proposer",
        "doc": "Propose.",
        "implementation": "grip_bt.nodes.component:ComponentLeaf",
        "inputs": {"input": {"type": "str"}, "limit": {"type": "int", "required": False}},
        "outputs": {
            "returned_object": {"type": "list[str]"},
            "why": {"type": "str", "on": ["none"]},
        },
        "outcomes": {"some": "success", "none": "failure", "failure": "failure"},
        "codes": ["server_lost", "timed_out", "bad_reply"],
        "settings": {"component": "proposer", "labels": ["some", "none"]},
    }
)


@pytest.fixture
def serve(world):
    """Answer calls with a reply or an error; returns the requests."""
    requests = []

    def install(reply):
        def call(request):
            requests.append(dict(request))
            return Operation.failed(reply) if isinstance(reply, Exception) else Operation.finished(reply)

        world.context.components["proposer"] = SimpleNamespace(call=call)
        return requests

    return install


def test_the_reply_names_the_outcome_and_fills_the_outputs(world, tick, serve):
    requests = serve({"outcome": np.int32(0), "returned_object": ["a"], "why": ""})
    assert tick(world.leaf(MANIFEST, input="cloud")) == ("SUCCESS", "some", None)
    assert requests == [{"input": "cloud"}]
    assert world.data == {"returned_object": ["a"]}


def test_an_outcome_that_means_failure_writes_only_what_belongs_to_it(world, tick, serve):
    serve({"outcome": 1, "returned_object": [], "why": "empty"})
    assert tick(world.leaf(MANIFEST, input="cloud")) == ("FAILURE", "none", None)
    assert world.data == {"why": "empty"}


def test_an_optional_field_is_sent_when_it_is_bound(world, serve):
    requests = serve({"outcome": 0, "returned_object": []})
    world.leaf(MANIFEST, input="cloud", limit=3).tick_once()
    assert requests == [{"input": "cloud", "limit": 3}]


@pytest.mark.parametrize("outcome", [2, -1, None, "0", True, 0.5])
def test_an_outcome_outside_the_contract_is_the_failure_bad_reply(world, tick, serve, outcome):
    serve({"outcome": outcome, "returned_object": [], "why": "nothing else is wrong"})
    assert tick(world.leaf(MANIFEST, input="cloud")) == ("FAILURE", "failure", "bad_reply")
    assert world.data == {}


@pytest.mark.parametrize("reply", [{"returned_object": []}, {"outcome": 0}])
def test_a_missing_field_is_the_failure_bad_reply(world, tick, serve, reply):
    serve(reply)
    assert tick(world.leaf(MANIFEST, input="cloud")) == ("FAILURE", "failure", "bad_reply")


@pytest.mark.parametrize("error", [ServerLostError, ServerTimeOutError, BadReplyError])
def test_trouble_with_the_server_is_a_failure_with_its_code(world, tick, serve, error):
    serve(error("gone"))
    assert tick(world.leaf(MANIFEST, input="cloud")) == ("FAILURE", "failure", error.code)
    assert error.code in MANIFEST.codes


def test_labels_that_the_manifest_lacks_are_found_before_the_run(world, serve):
    serve({})
    wrong = MANIFEST.model_copy(update={"settings": {"component": "proposer", "labels": ["some", "many"]}})
    with pytest.raises(TypeError, match="many"):
        world.leaf(wrong, input="cloud")
    unnamed = MANIFEST.model_copy(update={"settings": {"component": "proposer"}})
    with pytest.raises(TypeError, match="names no outcomes"):
        world.leaf(unnamed, input="cloud")
