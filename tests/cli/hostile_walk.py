"""`python hostile_walk.py FOLDER WHAT`: looks at a stranger's folder in every way, under an audit hook (PEP 578).

Prints one JSON object: `acts`, what was imported, executed, started or written that isn't ours; `done`, each way with
what came of it. A process of its own, since an audit hook can't be taken away again.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import traceback
import types
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

acts: list[str] = []
watching = False
folder = Path()
saved: list[Path] = []
"""Where the page writes what somebody saves there."""


def hook(event: str, args: tuple[Any, ...]) -> None:
    """Note what only somebody who runs a project may do."""
    if not watching:
        return
    if event == "import" and str(args[0]).partition(".")[0] in ("strangers", "own", "legacy", "conftest"):
        acts.append(f"import {args[0]}")
    elif event == "exec" and isinstance(args[0], types.CodeType) and _inside(args[0].co_filename):
        acts.append(f"exec {args[0].co_filename}")
    elif event == "compile" and args[1] is not None and _inside(os.fsdecode(args[1])):
        acts.append(f"compile {args[1]}")
    elif event in ("os.system", "os.exec", "os.posix_spawn", "os.fork", "os.forkpty", "pty.spawn"):
        acts.append(event)
    elif event == "subprocess.Popen" and not _ours([os.fsdecode(word) for word in args[1]]):
        acts.append(f"Popen {args[1]}")
    elif event == "open" and isinstance(args[1], str) and set(args[1]) & set("wax+") and not _may_be_written(args[0]):
        acts.append(f"write {args[0]}")


def _inside(name: str) -> bool:
    return Path(name).is_absolute() and Path(name).is_relative_to(folder)


def _ours(command: list[str]) -> bool:
    """Tell whether it is a module of ours, or a look at this machine."""
    modules = [word for word, before in zip(command[1:], command, strict=False) if before == "-m"]
    return command[0] == sys.executable and bool(modules) and modules[0].startswith(("grip_bt.", "grip_gui."))


def _may_be_written(name: object) -> bool:
    """Tell whether a file is the result that was asked for, the state of the project, or a cache of ours."""
    if isinstance(name, int):
        return True
    path = Path(os.fsdecode(name)).absolute()  # type: ignore[arg-type]
    wanted = (folder / ".grip", folder.parent / "out", folder.parent / "cache", Path("/dev"), *saved)
    return any(path.is_relative_to(each) for each in wanted)


@contextlib.contextmanager
def watched() -> Iterator[None]:
    """Have the hook note."""
    global watching
    watching = True
    try:
        yield
    finally:
        watching = False


def verb(words: list[str]) -> str:
    """Run `grip WORDS` in this process; return what came of it."""
    from grip_bt.cli.shell import run_verb

    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), watched():
            status: object = run_verb(words)
    except SystemExit as error:
        status = error.code
    except Exception:  # noqa: BLE001 - told to whoever asked
        status = traceback.format_exc()
    return f"{status}: {said.getvalue()[-4000:]}"


def verbs() -> Iterator[tuple[str, str]]:
    """Look at everything by the verbs that run nothing."""
    from grip_bt.cli.convert import FORMS

    tasks = sorted(str(file) for file in (folder / "tasks").glob("*.yaml"))
    ways = [["check", *tasks], ["check", "--json", "--strict", *tasks], ["fmt", "--check", *tasks]]
    out = str(folder.parent / "out" / "made")
    for task in tasks:
        ways += [["convert", task, "--to", to, "-o", out] for to in FORMS]
    ways += [["launch", "--project", str(folder), "--check"], ["component", "list", str(folder)]]
    for file in ("evil.launch.py", "evil.launch.xml"):
        ways.append(["launch", str(folder / file), "--project", str(folder), "--check"])
    ways.append(["launch", "--project", str(folder), "--write", f"{out}.xml"])
    ways.append(["component", "add", "--check", str(folder / "components" / "evil")])
    for source, file in (("smach", "legacy.py"), ("btcpp", "tree.xml"), ("pytrees", "tree.xml"), ("grip", "")):
        ways.append(["import", str(folder / file), "--from", source])
    ways += [["robot", "check", str(folder)], ["robot", "check", str(folder / "eval.xacro")]]
    journal = _journal_of(tasks)
    ways += [[*way, "--journal", journal] for way in (["runs"], ["replay", "last"])]
    edit = json.dumps({"do": "rename", "path": "function", "name": "renamed"})
    ways.append(["apply", str(folder / "tasks" / "nodes.yaml"), edit, "--dry-run"])
    for way in ways:
        yield " ".join(way), verb(way)


def _journal_of(tasks: list[str]) -> str:
    """Return a journal with a run of each of the folder's tasks, as one that came with the folder."""
    from grip_bt.runtime import Journal

    file = folder.parent / "out" / "runs.sqlite"
    with Journal(file) as journal:
        for task in tasks:
            log = journal.begin(Path(task).stem, task, Path(task).read_text(), "bt", None)
            log.append(0.0, "/", "enter")
            log.end("success", "success")
    return str(file)


def refused() -> Iterator[tuple[str, str]]:
    """Ask the verbs that run for no code but ours."""
    ways = [["run", str(folder / "tasks" / f"{task}.yaml"), "--robot", "fake"] for task in ("listed", "nodes")]
    ways += [[*way, "--in-process"] for way in ways]
    ways += [["bench", str(folder / "campaign.yaml")], ["launch", "--project", str(folder)]]
    ways += [["launch", str(folder / "plain.launch.xml"), "--project", str(folder)]]
    ways += [["component", "test", str(folder / "components" / "evil")]]
    ways += [["import", str(folder / "legacy.py"), "--from", "smach", "--execute"]]
    ways += [["import", "strangers:made", "--from", "pytrees", "--execute"]]
    for way in ways:
        yield " ".join(way), verb([*way, "--no-code"])


def routes() -> Iterator[tuple[str, str]]:
    """Ask everything of the page that isn't the request to run something."""
    from grip_gui.server import create_app

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from starlette.testclient import TestClient
    saved.append(folder)
    base = "http://127.0.0.1:8765"
    with TestClient(create_app(folder, token="t"), base_url=base, headers={"origin": base}) as page:
        page.get("/?token=t")
        for method, path, given in _questions(page):
            with watched():
                answer = page.request(method, path, **({"params": given} if method == "GET" else {"json": given}))
            yield f"{method} {path} {json.dumps(given)[:80]}", f"{answer.status_code}: {answer.text[:200]}"


RUNS = {"/api/session", "/api/setup/probe", "/api/live/component", "/api/live/messages", "/api/session/control"}
"""Routes by which somebody runs something, or controls what runs."""
ON_ROS = {"/api/live/topics", "/api/live/messages", "/api/live/message", "/api/live/receive", "/api/live/put"}
"""Those that ask the ROS graph, and not the folder."""


def _questions(page: Any) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield method, path and parameters or body; each route that isn't in `RUNS` at least once."""
    words = {"run": "r", "seq": "1", "form": "machine", "approximate": "true", "node": "/", "name": "n", "since": "0"}
    tasks = sorted(file.relative_to(folder).as_posix() for file in (folder / "tasks").glob("*.yaml"))
    files = ["grip.yaml", "components/evil/component.yaml"]
    for route in _every_route(page.app.routes):
        path = route.path.replace("{run}", "r").replace("{seq}", "1")
        names = [each.name for each in route.dependant.query_params]
        if route.path in ON_ROS:
            continue
        if "GET" in route.methods:
            for place in (tasks if "/document" in path else files) if "path" in names else [""]:
                given = {**words, "path": place}
                yield "GET", path, {name: given[name] for name in names if name in given}
        elif route.path not in RUNS:
            (model,) = (each.field_info.annotation for each in route.dependant.body_params)
            for place in tasks if "/document" in route.path else files:
                for given in _bodies(route.path, place):
                    yield "POST", path, {key: value for key, value in given.items() if key in model.model_fields}


def _bodies(route: str, place: str) -> Iterator[dict[str, Any]]:
    """Yield what a page may send to a route about a file; the routes take what is theirs."""
    legacy = (folder / "legacy.py").read_text()
    if "import" in route:
        yield {"name": "legacy.py", "text": legacy, "source": "smach"}
        return
    given: dict[str, Any] = {
        **{"path": place, "base": 0, "text": (folder / place).read_text(), "node": "/", "form": "machine"},
        **{"approximate": True, "step": "undo", "view": "tree", "positions": {}, "key": ["doc"], "do": "set"},
        **{"value": "x", "run": "r", "seq": 1, "name": "a", "type": "std_srvs/srv/Trigger", "task": "tasks/nodes.yaml"},
        **{"breakpoints": [], "page": "p", "topic": "/points", "store": "poses", "robot": "fake", "part": "arm"},
        **{"what": "joints", "over": True},
    }
    yield {**given, "command": {"do": "convert", "path": "/", "to": "bt"}}
    yield {
        **given,
        "form": "tree",
        "command": {"do": "insert", "parent": "/", "name": "n", "node": {"node": "own/function"}},
    }


def _every_route(routes: Any) -> Iterator[Any]:
    for route in routes:
        inner = getattr(route, "original_router", None)
        if inner is not None:
            yield from _every_route(inner.routes)
        elif hasattr(route, "dependant") and hasattr(route, "methods"):
            yield route


WAYS: dict[str, Callable[[], Iterator[tuple[str, str]]]] = {"verbs": verbs, "refused": refused, "routes": routes}

if __name__ == "__main__":
    folder = Path(sys.argv[1]).resolve()
    sys.dont_write_bytecode = True
    sys.addaudithook(hook)
    done = dict(WAYS[sys.argv[2]]())
    sys.stdout.write(json.dumps({"acts": acts, "done": done}) + "\n")
