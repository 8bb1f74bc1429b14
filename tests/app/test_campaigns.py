"""Campaigns: every variant on every seed, results that survive, and statistics that are right."""

import itertools
import json
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from campaign_rows import by_hand, row
from hypothesis import given
from hypothesis import strategies as st

import grip_bt as grip
from grip_bt.app.campaign.file import head_of, read_campaign
from grip_bt.app.campaign.report import FORMS, as_csv, records, write_report
from grip_bt.app.campaign.results import Results, alone, begin, read
from grip_bt.app.campaign.statistics import summary
from grip_bt.app.campaign.trials import Trials, check, judged
from grip_bt.base.errors import CampaignError, DocumentError, InvalidTaskError
from grip_bt.cli.__main__ import main

TASK = """grip: 1
name: count
inputs: {limit: {type: int, value: 3}}
data: {reached: {type: int, value: 0}}
root:
  kind: sequence
  children:
    count:
      kind: loop
      times: 10
      while: reached < limit
      child:
        add: {node: flow/compute, with: {expression: a + 1}, in: {a: reached}, out: {value: reached}}
    say: {node: flow/log, with: {message: counted to}, in: {value: reached}}
"""
CAMPAIGN = """campaign: 1
doc: Who counts best.
task: tasks/count.yaml
robot: fake
seeds: {first: 5, count: 2}
success: status == 'success' and reached >= 3
count: {steps: count/add}
measure: {left: limit - reached, far: reached > 3}
variants:
  tree: {}
  machine: {as: sm, set: {limit: 4}}
  short: {set: {limit: 2}}
  broken: {mocks: {count: failure.no_ik}}
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for name, text in {"grip.yaml": "grip: 1\n", "tasks/count.yaml": TASK, "campaigns/who.yaml": CAMPAIGN}.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def bench(project: Path, *more: str, campaign: str = "who") -> int:
    return main(["bench", str(project / f"campaigns/{campaign}.yaml"), *more])


@pytest.mark.slow
def test_each_variant_meets_each_seed_and_the_summary_says_what_came_of_it(project, capsys):
    assert bench(project, "--workers", "2", "--json") == 0
    said = json.loads(capsys.readouterr().out)
    rows = read(project / ".grip/campaigns/who.jsonl").rows
    assert Counter((row["variant"], row["seed"]) for row in rows) == Counter(
        itertools.product(("tree", "machine", "short", "broken"), (5, 6))
    )
    good = {name: one["successes"] for name, one in said["variants"].items()}
    assert good == {"tree": 2, "machine": 2, "short": 0, "broken": 0}
    assert said["variants"]["machine"]["measures"]["steps"] == {"of": 2, "median": 4, "least": 4, "most": 4}
    assert said["variants"]["machine"]["measures"]["far"] == {"of": 2, "true": 2}
    assert said["variants"]["broken"]["failures"] == {"failure.no_ik": 2}
    assert said["variants"]["short"]["failures"] == {"ended as success, but the campaign's condition is false": 2}
    pairs = {(pair["first"], pair["second"]): pair for pair in said["compared"]["variant"]}
    assert len(pairs) == 6
    found = pairs["tree", "broken"]
    assert (found["test"], found["pairs"], found["only_first"], found["only_second"]) == ("McNemar", 2, 2, 0)
    assert (found["p"], found["holm"]) == (0.5, 1.0)
    assert rows[0]["trial"] == f"{rows[0]['variant']}@{rows[0]['seed']}"
    assert {"python", "machine", "campaign sha256", "project sha256"} <= rows[0]["provenance"].keys()
    # each run can be looked at: it is in the journal beside the results
    assert main(["runs", rows[0]["run"], "--journal", str(project / ".grip/campaigns/who.sqlite"), "--data"]) == 0
    assert "count/add" in capsys.readouterr().out

    assert main(["bench", "report", str(project / ".grip/campaigns/who.jsonl")]) == 0
    text = capsys.readouterr().out
    assert "| tree    | 2 of 2 (100%) |" in text
    assert "2x failure.no_ik" in text
    assert main(["bench", "report", str(project / ".grip/campaigns/who.jsonl"), "--csv"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("trial,variant,seed,success,contradicted,status,outcome,code")
    assert len(lines) == 9


@pytest.mark.slow
def test_a_campaign_is_gone_on_with_and_never_mixed_or_overwritten(project, capsys):
    file = project / "campaigns/who.yaml"
    file.write_text(CAMPAIGN[: CAMPAIGN.index("  machine")].replace("count: 2", "count: 1"))
    assert bench(project) == 0
    results = project / ".grip/campaigns/who.jsonl"
    before = results.read_text()
    assert bench(project) == 1
    assert "there are results already: continue them with --resume" in capsys.readouterr().err
    assert results.read_text() == before

    results.write_text(before + '{"variant": "tree", "se')  # the machine was switched off in the middle of a line
    file.write_text(CAMPAIGN[: CAMPAIGN.index("  short")])
    assert bench(project, "--resume") == 0
    said = capsys.readouterr().err
    assert "1 are there; 3 trials to run" in said
    assert results.read_text().partition("\n")[2].startswith(before.partition("\n")[2])  # its head has the new variant
    assert len(read(results).rows) == 4

    file.write_text(file.read_text().replace("tree: {}", "tree: {set: {limit: 9}}"))
    assert bench(project, "--resume") == 1
    assert "'tree' isn't what it was when these trials ran (changed: set)" in capsys.readouterr().err


@pytest.mark.slow
def test_a_stopped_campaign_keeps_what_has_ended(project):
    (project / "campaigns/who.yaml").write_text(
        "campaign: 1\nrobot: fake\ntask: tasks/count.yaml\nseeds: {count: 40}\n"
    )
    command = [sys.executable, "-m", "grip_bt.cli", "bench", "campaigns/who.yaml"]
    process = subprocess.Popen(command, cwd=project, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    results, deadline = project / ".grip/campaigns/who.jsonl", time.monotonic() + 600
    while not (results.exists() and len(results.read_text().splitlines()) > 2) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=600)
    assert process.returncode == 130, err
    assert "--resume runs them" in err
    rows = read(results).rows
    assert 2 <= len(rows) < 40
    assert all(row["status"] == "success" for row in rows)
    assert f"{len(rows)} of {len(rows)} (100%)" in out


@pytest.mark.slow
def test_a_trial_that_takes_too_long_is_a_row_and_the_others_go_on(project):
    own = "{node: flow/wait, with: {seconds: 5000.0}}"
    (project / "tasks/wait.yaml").write_text(
        f"grip: 1\nname: wait\nroot:\n  kind: sequence\n  children:\n    it: {own}\n"
    )
    (project / "campaigns/late.yaml").write_text(
        "campaign: 1\nrobot: fake\nseeds: [0, 1]\ntimeout: 3\nvariants:\n  wait: {task: tasks/wait.yaml}\n"
    )
    assert bench(project, "--workers", "1", campaign="late") == 0
    rows = read(project / ".grip/campaigns/late.jsonl").rows
    assert [row["status"] for row in rows] == ["timed_out", "timed_out"]


@pytest.mark.slow
def test_a_trial_that_crashes_is_a_row_and_the_others_go_on(project):
    (project / "nodes").mkdir()
    (project / "nodes/own.py").write_text(
        "import os\nimport grip_bt\n\n\n"
        '@grip_bt.leaf("own/die")\ndef die() -> None:\n    """End the process."""\n    os._exit(9)\n'
    )
    (project / "tasks/die.yaml").write_text(
        "grip: 1\nname: die\nroot:\n  kind: sequence\n  children:\n    it: {node: own/die}\n"
    )
    (project / "campaigns/who.yaml").write_text(
        "campaign: 1\nrobot: fake\nseeds: [0]\nvariants:\n"
        "  die: {task: tasks/die.yaml}\n  count: {task: tasks/count.yaml}\n"
    )
    assert bench(project, "--workers", "2") == 0
    rows = {row["variant"]: row for row in read(project / ".grip/campaigns/who.jsonl").rows}
    assert {name: row["status"] for name, row in rows.items()} == {"die": "error", "count": "success"}
    assert "it: the run's process ended with exit status 9" in rows["die"]["message"]


@pytest.mark.slow
def test_trials_share_a_process_and_nothing_that_a_project_keeps_in_it(project):
    (project / "nodes").mkdir()
    (project / "nodes/own.py").write_text(
        "import os\nimport grip_bt\n\nSEEN = []\n\n\n"
        '@grip_bt.leaf("own/see", outputs={"seen": str})\ndef see() -> str:\n    """Note it."""\n    SEEN.append(1)\n'
        '    return f"{os.getpid()} {len(SEEN)}"\n'
    )
    (project / "tasks/see.yaml").write_text(
        "grip: 1\nname: see\ndata: {seen: {type: str, value: ''}}\nroot:\n  kind: sequence\n"
        "  children:\n    it: {node: own/see, out: {seen: seen}}\n"
    )
    (project / "campaigns/who.yaml").write_text(
        "campaign: 1\nrobot: fake\nseeds: {count: 3}\ntask: tasks/see.yaml\nmeasure: {seen: seen}\n"
    )
    assert bench(project) == 0
    seen = [row["measures"]["seen"].split() for row in read(project / ".grip/campaigns/who.jsonl").rows]
    assert len({pid for pid, _ in seen}) == 1
    assert [count for _, count in seen] == ["1", "1", "1"]
    (project / ".grip/campaigns/who.jsonl").unlink()
    assert bench(project, "--fresh") == 0
    rows = read(project / ".grip/campaigns/who.jsonl").rows
    assert len({row["measures"]["seen"].split()[0] for row in rows}) == 3


@pytest.mark.sim
def test_the_referee_counts_and_not_what_the_task_says(project, capsys):
    """A task that only looks ends as a success; nothing lies in the crate."""
    world = "grip: 1\nrobot: panda_allegro\nworld: table\nsensors: {overhead: {camera: overhead}}\n"
    (project / "grip.yaml").write_text(world)
    (project / "tasks/count.yaml").write_text(
        "grip: 1\nname: look\nroot:\n  kind: sequence\n  children:\n    look: {node: sensor/overhead}\n"
    )
    (project / "campaigns/who.yaml").write_text(
        "campaign: 1\ntask: tasks/count.yaml\nseeds: [4, 3]\nrepeat: 2\n"
        "success: status == 'success' and placed == objects\n"
        "measure: {placed: placed, standing: standing, cleared: cleared}\n"
    )
    assert bench(project, "--pictures") == 0
    write_report(read(project / ".grip/campaigns/who.jsonl"), project / "r.html")
    page = (project / "r.html").read_text()
    assert page.count("data:image/jpeg;base64,/9j/") == 1  # of the one way in which both ended
    assert "2x ended as success, but the campaign" in page
    before, row = read(project / ".grip/campaigns/who.jsonl").rows
    assert row["seed"] == 3
    assert not before.get("repeated")
    assert row["repeated"] == "the same"  # in a world that came after another one, and in one of a new process
    assert row["status"] == "success"
    assert not row["success"]
    assert set(row["truth"].values()) == {"standing"}
    assert row["judged"] == {"cleared": False}
    assert row["measures"] == {"placed": 0, "standing": len(row["truth"]), "cleared": False}


@pytest.mark.parametrize("world", ["table", "bottle_bench"])
def test_conditions_of_the_simulated_world_are_known_by_name(project, world):
    (project / "grip.yaml").write_text(f"grip: 1\nrobot: panda_allegro\nworld: {world}\n")
    file = project / "campaigns/who.yaml"
    file.write_text(CAMPAIGN.replace("robot: fake", "robot: sim").replace("reached >= 3", "cleared"))
    if world == "table":
        check(read_campaign(file))
    else:
        with pytest.raises(CampaignError, match="unknown name 'cleared'"):
            check(read_campaign(file))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("task: tasks/count.yaml\n", "task: tasks/cuont.yaml\n"), "there is no task 'tasks/cuont.yaml' (looked in"),
        (("reached >= 3", "raeched >= 3"), "success: unknown name 'raeched'; did you mean 'reached'?"),
        (("reached >= 3", "__import__('os')"), "success: "),
        (("{steps: count/add}", "{steps: count/ad}"), "count/steps: 'tree' has no node 'count/ad'; did you mean"),
        (("{steps: count/add}", "{wall: count/add}"), "'wall' is known of every trial already"),
        (("{limit: 2}", "{limti: 2}"), "short/set: the task has no variable 'limti'; did you mean 'limit'?"),
        (("{first: 5, count: 2}", "[1, 2, 1]"), "duplicate seeds: 1"),
        (("{first: 5, count: 2}", "[]"), "`seeds` is empty"),
        (("task: tasks/count.yaml\n", ""), "no task for tree, machine, short, broken"),
        ((CAMPAIGN[CAMPAIGN.index("task:") :], ""), "nothing to run: give `task`, or `variants` with a `task` each"),
        (("campaign: 1", "campaign: 2"), "campaign"),
        (("robot: fake", "robto: fake"), "unknown key 'robto' in the file; did you mean 'robot'?"),
    ],
)
def test_what_is_wrong_is_said_before_anything_runs(project, capsys, change, words):
    file = project / "campaigns/who.yaml"
    assert change[0] in CAMPAIGN
    file.write_text(CAMPAIGN.replace(*change))
    assert bench(project) == 1
    assert words in capsys.readouterr().err
    assert not (project / ".grip/campaigns").exists()


def test_a_wrong_task_or_mock_is_said_too(project):
    (project / "tasks/count.yaml").write_text(TASK.replace("flow/log", "flow/lgo"))
    with pytest.raises(InvalidTaskError, match="flow/lgo"):
        check(read_campaign(project / "campaigns/who.yaml"))
    (project / "tasks/count.yaml").write_text(TASK.replace("{type: int, value: 3}", "int"))
    with pytest.raises(InvalidTaskError, match="--set limit"):
        check(read_campaign(project / "campaigns/who.yaml"))
    with pytest.raises(DocumentError):
        read_campaign(project / "campaigns/nothing.yaml")


def test_results_that_are_none_are_refused(project, capsys, tmp_path):
    for text in ("", "hello\n", '{"campaign": 7}\n', "[]\n"):
        (tmp_path / "r.jsonl").write_text(text)
        assert main(["bench", "report", str(tmp_path / "r.jsonl")]) == 1
        assert "campaign" in capsys.readouterr().err
    assert main(["bench", "report", str(tmp_path / "gone.jsonl")]) == 1
    with pytest.raises(SystemExit):
        main(["bench", "report"])
    assert "report needs the file of results" in capsys.readouterr().err


def test_a_place_that_cannot_be_written_is_named(project, capsys):
    assert bench(project, "-o", "/proc/results.jsonl") == 1
    assert "-o" in capsys.readouterr().err


@pytest.mark.parametrize("status", ["error", "timed_out"])
def test_what_could_not_be_confirmed_to_have_stopped_is_in_the_row_and_in_the_report(project, status):
    campaign = read_campaign(project / "campaigns/who.yaml")
    end = {"status": status, "outcome": None, "message": "late", "unconfirmed": {"right": "the server says nothing"}}
    found = {"variant": "tree", "seed": 5, **judged(campaign, end, 1.0, None)}
    results = Results(Path("x"), head_of(campaign), [found])
    why = "could not confirm that 'right' stopped: the server says nothing"
    assert list(summary(results)["variants"]["tree"]["failures"]) == [f"{status}: late; {why}"]
    assert why in as_csv(results)
    assert judged(campaign, {**end, "unconfirmed": {}}, 1.0, None)["unconfirmed"] == ""


FACTORS = """campaign: 1
task: tasks/count.yaml
robot: fake
seeds: {count: 3}
factors:
  limit: [1, 2, 3]
  form: {tree: {}, machine: {as: sm}, mocked: {mocks: {count: success}}}
"""


def test_factors_are_crossed_and_told_apart_in_each_row(project):
    (project / "campaigns/who.yaml").write_text(FACTORS)
    campaign = read_campaign(project / "campaigns/who.yaml")
    check(campaign)
    assert len(campaign.file.variants) == 9
    assert campaign.levels["2/machine"] == {"limit": "2", "form": "machine"}
    assert campaign.file.variants["2/machine"].set == {"limit": 2}
    assert campaign.file.variants["2/machine"].form == "sm"
    assert head_of(campaign)["variants"]["2/machine"]["levels"] == campaign.levels["2/machine"]
    assert len(campaign.trials()) == 27


@given(levels=st.sampled_from([2, 3, 5]), factors=st.integers(2, 4), seed=st.integers(0, 9))
def test_a_latin_design_meets_each_level_once_a_seed_and_each_pair_of_levels_once(
    tmp_path_factory, levels, factors, seed
):
    file = tmp_path_factory.mktemp("latin") / "c.yaml"
    said = {f"f{k}": list(range(levels)) for k in range(factors)}
    text = {"campaign": 1, "task": "t.yaml", "robot": "fake", "design": "latin", "factors": said, "shuffle": seed}
    file.write_text(json.dumps({**text, "seeds": {"count": levels}}))
    if any(levels % k == 0 for k in range(2, factors)):
        with pytest.raises(CampaignError, match="no number below that of factors divides"):
            read_campaign(file)
        return
    campaign = read_campaign(file)
    trials = campaign.trials()
    assert trials == read_campaign(file).trials()
    cells = [(number, *campaign.levels[variant].values()) for variant, number in trials]
    for one, two in itertools.combinations(range(factors + 1), 2):  # the seed is one of them
        assert Counter((cell[one], cell[two]) for cell in cells) == dict.fromkeys(
            itertools.product({cell[one] for cell in cells}, {cell[two] for cell in cells}), 1
        )


@pytest.mark.parametrize("order", ["blocked", "random", "listed"])
def test_the_order_is_random_and_the_same_each_time(project, order):
    text = FACTORS.replace("count: 3", "count: 20")
    (project / "campaigns/who.yaml").write_text(f"{text}order: {order}\n")
    campaign = read_campaign(project / "campaigns/who.yaml")
    trials = campaign.trials()
    listed = [(variant, seed) for seed in campaign.seeds for variant in campaign.file.variants]
    assert trials == campaign.trials()
    assert sorted(trials) == sorted(listed)
    assert (trials == listed) == (order == "listed")
    assert ([seed for _, seed in trials] == [seed for _, seed in listed]) == (order != "random")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("[1, 2, 3]", "[1, 1, 2]"), "factors/limit: it needs levels that differ"),
        (("mocked: {mocks: {count: success}}", "mocked: {set: {limit: 9}}"), "two factors say what set/limit is"),
        (("[1, 2, 3]", "[1, 2]"), "factors or more with equally many levels: limit has 2, form has 3"),
    ],
)
def test_factors_that_do_not_fit_are_refused(project, change, words):
    (project / "campaigns/who.yaml").write_text(FACTORS.replace(*change) + "design: latin\n")
    with pytest.raises(CampaignError, match=words):
        read_campaign(project / "campaigns/who.yaml")


def test_a_variant_is_not_tried_any_more_when_its_interval_is_narrow(project, tmp_path, monkeypatch):
    file = project / "campaigns/who.yaml"
    file.write_text(CAMPAIGN.replace("count: 2}", "count: 100}") + "stop: {width: 0.5, least: 6}\n")
    campaign, ended = read_campaign(file), []
    trials = Trials(campaign, tmp_path / "j.sqlite", ended.append)
    monkeypatch.setattr(trials, "once", lambda variant, seed, process: row(variant, seed, variant == "tree"))
    trials.fresh = True
    trials.run(campaign.trials())
    tried = Counter(each["variant"] for each in ended)
    least = next(n for n in itertools.count(6) if by_hand(n, n)[1] - by_hand(n, n)[0] <= 0.5)
    assert dict(tried) == dict.fromkeys(campaign.file.variants, least)
    again = Trials(campaign, tmp_path / "j.sqlite", ended.append, before=ended)
    assert all(again.enough(variant) for variant in campaign.file.variants)


def test_reports_are_written_in_the_form_that_their_file_says(project, tmp_path):
    (project / "campaigns/who.yaml").write_text(FACTORS)
    campaign = read_campaign(project / "campaigns/who.yaml")
    rows = [
        row(
            variant,
            seed,
            seed > 0,
            levels=campaign.levels[variant],
            trial=f"{variant}@{seed}",
            provenance={"numpy": "2"},
        )
        for variant, seed in campaign.trials()
    ]
    results = Results(tmp_path / "r.jsonl", head_of(campaign), rows)
    for ending in FORMS:
        write_report(results, tmp_path / f"r{ending}")
    page = (tmp_path / "r.html").read_text()
    assert page.count("<rect") == 6
    assert "limit against form" in page
    assert "src=" not in page
    table = (tmp_path / "r.tex").read_text()
    assert r"limit & 1 & 9 & 66.7\,\% &" in table
    assert table.count(r"\\") == 7
    (first, *_) = records(results)
    assert {"trial", "limit", "form", "numpy", "success"} <= first.keys()
    with pytest.raises(CampaignError, match=r"reports end in \.txt"):
        write_report(results, tmp_path / "r.doc")


def test_a_program_runs_a_campaign_and_goes_on_with_it(project, tmp_path, monkeypatch):
    file, place = project / "campaigns/who.yaml", tmp_path / "r.jsonl"
    done = grip.campaign(file, output=place)
    trials = [record["trial"] for record in done.records]
    assert len(trials) == len(set(trials)) == len(read_campaign(file).trials())
    assert set(done.summary["variants"]) == {trial.partition("@")[0] for trial in trials}
    assert str(done).strip()
    with pytest.raises(CampaignError, match="there are results already"):
        grip.campaign(file, output=place)
    assert [record["trial"] for record in grip.campaign(file, output=place, resume=True).records] == trials
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(grip.GripError, match="pip install pandas"):
        done.frame()


def test_parquet_holds_a_record_a_trial(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    results = Results(tmp_path / "r.jsonl", {"name": "x", "doc": "", "variants": {"a": {}}}, [row("a", 1, True)])
    write_report(results, tmp_path / "r.parquet")
    assert parquet.read_table(tmp_path / "r.parquet").to_pylist() == records(results)


def test_two_at_once_do_not_write_the_same_results(tmp_path):
    with alone(tmp_path / "r.jsonl"):
        with pytest.raises(CampaignError, match="another `grip bench` is at work"), alone(tmp_path / "r.jsonl"):
            pass
    with alone(tmp_path / "r.jsonl"):
        pass


def test_the_settings_of_a_variant_are_in_the_results(project, tmp_path):
    campaign = read_campaign(project / "campaigns/who.yaml")
    begin(tmp_path / "r.jsonl", head_of(campaign), resume=False)
    began = begin(tmp_path / "r.jsonl", head_of(campaign), resume=False)  # there was nothing yet to go on with
    kept = read(tmp_path / "r.jsonl").head["variants"]
    assert kept["machine"]["as"] == "sm"
    assert kept["tree"]["task"] == TASK
    began.add(row("tree", 5, True))
    with pytest.raises(CampaignError, match="results already"):
        begin(tmp_path / "r.jsonl", head_of(campaign), resume=False)


def test_variants_that_come_later_are_in_the_results_and_in_their_report(project, tmp_path):
    head = head_of(read_campaign(project / "campaigns/who.yaml"))
    first = {**head, "variants": {"tree": head["variants"]["tree"]}}
    began = begin(tmp_path / "r.jsonl", first, resume=False)
    began.add({"trial": "tree@0", "variant": "tree", "seed": 0, "status": "success", "success": True, "wall": 1.0})
    with (tmp_path / "r.jsonl").open("a") as file:
        file.write('{"trial": "tree@1", "cut o')
    again = begin(tmp_path / "r.jsonl", head, resume=True)
    kept = read(tmp_path / "r.jsonl")
    assert again.head["variants"] == kept.head["variants"] == {**first["variants"], **head["variants"]}
    assert [row["trial"] for row in kept.rows] == ["tree@0"]


def test_the_examples_campaign_fits_its_task():
    check(read_campaign(Path(__file__).parents[2] / "examples/campaigns/two_forms.yaml"))
