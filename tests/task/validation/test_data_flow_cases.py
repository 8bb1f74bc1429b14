from test_data_flow import found_in

from grip_bt.task import loads

WRITE, READ = "{node: demo/leaf, out: {x: u}}", "{node: demo/leaf, in: {a: u}}"


def found(root, data="{u: int}"):
    return found_in(loads(f"grip: 1\nname: t\ndata: {data}\nroot: {root}\n"))


def seq(*children):
    return "{kind: sequence, children: {" + ", ".join(f"c{i}: {c}" for i, c in enumerate(children)) + "}}"


def parallel(policy, cancel, *children):
    return seq(*children).replace("kind: sequence", f"kind: parallel, policy: {policy}, cancel: {cancel}")


def test_a_write_before_a_read_is_enough_in_a_sequence_and_not_in_a_fallback():
    assert found(seq(WRITE, READ)) == set()
    assert found(seq(READ, WRITE)) == {"c0"}
    assert found(seq(WRITE, READ).replace("sequence", "fallback")) == {"c1"}


def test_an_initial_value_counts_as_a_write():
    assert found(READ, "{u: {type: int, value: 1}}") == set()


def test_a_scope_begins_anew_with_each_attempt():
    inner = (
        "{kind: state_machine, initial: a, outcomes: {success: success, failure: failure}, data: {u: int}, children: {"
        f"a: {WRITE[:-1]}, on: {{success: b, other: b, failure: failure}}}}, "
        f"b: {READ[:-1]}, on: {{success: success, other: success, failure: a}}}}}}}}"
    )
    assert found(f"{{kind: retry, times: 2, child: {{m: {inner}}}}}", "{}") == set()
    swapped = inner.replace("initial: a", "initial: b")
    assert found(f"{{kind: retry, times: 2, child: {{m: {swapped}}}}}", "{}") == {"m/b"}


def test_after_all_of_a_parallel_each_childs_writes_are_there_but_siblings_cannot_rely_on_them():
    assert found(seq(parallel("all", "halt", WRITE, "{node: demo/leaf}"), READ)) == set()
    assert found(seq(parallel("all", "halt", "{node: demo/leaf}", "{node: demo/leaf}"), READ)) == {"c1"}
    assert found(parallel("all", "halt", WRITE, READ)) == {"c1"}


def test_after_any_of_a_parallel_a_sibling_has_surely_written_only_when_it_is_joined():
    always, other = "{node: demo/leaf, out: {x: u, y: u}}", "{node: demo/leaf}"
    assert found(seq(parallel("any", "join", always, other), READ)) == set()
    assert found(seq(parallel("any", "halt", always, other), READ)) == {"c1"}
    assert found(seq(parallel("any", "join", WRITE, other), READ)) == {"c1"}
    assert found(seq(parallel("any", "halt", always), READ)) == set()


def test_a_timeout_may_come_before_any_write():
    always = "{node: demo/leaf, out: {x: u, y: u}}"
    timed = f"{{kind: timeout, seconds: 1, child: {{w: {always}}}}}"
    assert found(seq(timed, READ)) == set()
    assert found(seq(f"{{kind: invert, child: {{w: {always}}}}}", READ)) == set()
    assert found(seq(f"{{kind: invert, child: {{t: {timed}}}}}", READ)) == {"c1"}


def test_an_exit_leads_its_own_state_to_the_outcome():
    inner = f"{{kind: sequence, exits: {{a.other: success}}, children: {{a: {{node: demo/leaf}}, b: {WRITE}}}}}"
    assert found(seq(inner, READ)) == {"c1"}
    assert found(seq(inner.replace("success}", "failure}"), READ)) == set()
