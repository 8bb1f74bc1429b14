"""A component that is missing, dies, or answers nonsense: clear words, the right exit status, nothing left behind."""

import json

import pytest
from trial_project import grip, make_trial_project, processes_in, result_of

pytestmark = [pytest.mark.ros, pytest.mark.slow]


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    return make_trial_project(tmp_path_factory.mktemp("trial"))


@pytest.fixture
def run(project, domain):
    def run_task(name):
        return grip("run", str(project / "tasks" / f"{name}.yaml"), "--json", domain=domain)

    yield run_task
    assert processes_in(project) == []


def test_a_good_component_answers(run):
    done = run("good")
    assert done.returncode == 0, done.stderr
    assert result_of(done)["outcome"] == "answered"


def test_workers_of_a_campaign_do_not_meet_in_the_domain_of_the_shell(project, domain):
    campaign = project / "domains.yaml"
    campaign.write_text("""campaign: 1
task: tasks/says_its_domain.yaml
robot: fake
seeds: [1, 2, 3, 4]
measure: {domain: answer}
variants: {one: {}}
""")
    done = grip("bench", str(campaign), "--workers", "2", domain=domain)
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in (project / ".grip" / "campaigns" / "domains.jsonl").read_text().splitlines()]
    domains = [row["measures"]["domain"] for row in rows if "measures" in row]
    assert len(domains) == 4
    assert not {None, domain} & set(domains)


def test_a_server_that_never_comes_is_named_with_its_last_words(run):
    done = run("never_comes")
    assert done.returncode == 1
    assert "never_comes" in done.stderr
    assert "the camera licence has expired" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_server_that_dies_in_a_call_fails_the_call_at_once(run):
    done = run("dies_in_a_call")
    assert done.returncode == 3, done.stderr
    result = result_of(done)
    assert result["outcome"] == "unanswered"
    assert result["code"] == "server_lost"
    assert result["duration"] < 100, "much less than the call's time-out"


def test_an_outcome_out_of_range_is_a_bad_reply(run):
    done = run("out_of_range")
    assert done.returncode == 3, done.stderr
    result = result_of(done)
    assert result["code"] == "bad_reply"
    assert "5" in result["message"]
    assert "fine" in result["message"]
