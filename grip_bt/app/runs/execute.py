"""Running a task of a project: checked, compiled, with the parts of a robot that it needs, into the journal."""

from __future__ import annotations

import asyncio
import logging
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter

from grip_bt.app.building import catalogue_for, project_of
from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import Project, find_project
from grip_bt.app.project.foreign_code import of_task, refuse
from grip_bt.app.runs.mocks import apply_mocks, check_nodes, injected
from grip_bt.app.runs.resume import ResumeRequest, changes, kept_parts, start_resumed
from grip_bt.app.wiring.equipment import Equipment
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening, Progress, Resources, RobotKind, load_part, silent
from grip_bt.app.world import World, in_world
from grip_bt.base.errors import GripError, InvalidTaskError
from grip_bt.base.issue import Issue, Report
from grip_bt.compilers import CompiledMachine, CompiledTree, to_machine, to_tree
from grip_bt.formats.pytrees.adopted import AdoptedTree
from grip_bt.nodes import tree_code
from grip_bt.nodes.dry_run import dry_run, dry_run_of_tree
from grip_bt.nodes.mock import MockLeaf
from grip_bt.nodes.node import Observer
from grip_bt.runtime import Journal, JournalError, JournalReader, Runner, RunResult
from grip_bt.runtime.journal_room import Pruned, prune, size_of
from grip_bt.task import Document, Task, Variable, dumps, read, read_text
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Leaf, type_of, walk
from grip_bt.task.validation import validate
from grip_bt.task.validation.parts import DRAWN, STOOD_IN
from grip_sim.faults import Fault

_log = logging.getLogger(__name__)
Target = Literal["bt", "sm"]
Checked = tuple[Project, Document, Report, Catalog]
MOST_SEED = 2**32 - 1
WATCHDOG = 10.0
"""How long a tick, or the whole process, may hang before a run is ended, unless told otherwise [s]."""


@dataclass(frozen=True)
class RunOptions:
    """How a task is run.

    Attributes:
        target: behaviour tree or state machine.
        robot: simulated, fake parts that do as asked, or real controllers over ROS 2.
        seed: of the simulated world.
        world: name or file of the world that is simulated in place of the project's; empty for that.
        object: of the library or a file; every object of the world is one.
        pace: simulated seconds per second for watching; None for as fast as it goes.
        data: initial values for the task's variables.
        journal: where to write; None for the project's own.
        rate: ticks a second of the run's clock, instead of on wakes; None for on wakes.
        watchdog: how long one tick may take [s] before the run ends as an error; None for ever.
        mocks: node -> script, as `grip_bt.app.runs.mocks` reads them.
        faults: what goes wrong in the simulated world besides its file's faults, by name.
        ticks: how often somebody's own tree is ticked, whether it ends or not; None until it has ended.
        resume: the run that is resumed; None for a new one.
        video: where a film of the simulated world is written, 25 frames a second of its time; None for nowhere.
        picture: where a picture of its end is written, likewise.
        view: the world's camera that both are of, or six numbers `X,Y,Z,X,Y,Z` [m], from where to where.
        stand_ins: whether legacy code gets stand-ins for packages that are missing, and for what ROS offers.
        apart: whether a DDS domain of its own is a free one, whatever ROS_DOMAIN_ID says: other runs are beside it.
        motion: whether what moves is recorded beside the journal, for drawing it.
    """

    target: Target = "bt"
    robot: RobotKind = "sim"
    seed: int = 0
    world: str = ""
    object: str = ""
    pace: float | None = None
    data: Mapping[str, Any] = field(default_factory=dict)
    journal: Path | None = None
    rate: float | None = None
    watchdog: float | None = None
    mocks: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
    faults: Mapping[str, Fault] = field(default_factory=dict)
    ticks: int | None = None
    resume: ResumeRequest | None = None
    video: Path | None = None
    picture: Path | None = None
    view: str = ""
    stand_ins: bool = False
    apart: bool = False
    motion: bool = True


OPTIONS = TypeAdapter(RunOptions)
"""Writes and reads them as JSON, for other processes and for the journal."""
_RECORDED = {*"robot seed world object pace data rate watchdog mocks faults target ticks stand_ins apart".split()}


@dataclass
class Session:
    """A task that is ready to run: everything is started, nothing has moved."""

    project: Project
    document: Document
    report: Report
    resources: Resources
    runner: Runner
    journal: Path


def check_task(path: str | Path | Task, text: str | None = None, world: str = "") -> Checked:
    """Read a task file, or what its text was at another time, and check it against its project's nodes.

    Args:
        world: in place of the project's.

    Raises:
        DocumentError: it can't be read.
        InvalidTaskError: it is wrong; the error holds all issues.
    """
    project = in_world(project_of(path) if isinstance(path, Task) else find_project(path), world)
    if isinstance(path, Task):
        catalog, text, path = catalogue_for(path, project), dumps(path), path.file or path.name
    else:
        catalog = catalogue_of(project)
    document = read(Path(path)) if text is None else read_text(text, str(path))
    report = validate(document.task, catalog, document)
    report.raise_if_invalid(str(path))
    return project, document, report, catalog


def check_inputs(document: Document, given: Mapping[str, object]) -> None:
    """Refuse a run of a task that isn't given what it needs: InvalidTaskError names each input that is missing."""
    missing = []
    for name, said in document.task.inputs.items():
        if name not in given and not (isinstance(said, Variable) and said.has_value):
            message = f"the task needs the input {name!r} ({type_of(said)}) when it is run on its own"
            line, column = document.position("", ("inputs", name)) or (None, None)
            fix = f"give it: --set {name}=..., or an initial value in `inputs`"
            missing.append(Issue("", "missing-input", "error", message, fix, line, column, document.source))
    if missing:
        raise InvalidTaskError(missing, document.source)


def _compiled(
    path: str | Path | Task, options: RunOptions, progress: Progress, code: ExitStack
) -> tuple[Project, Document, Report, CompiledTree | CompiledMachine]:
    """Return a task file, checked and compiled; `code` is closed when its code isn't run any more."""
    text = None
    if options.resume is not None and not isinstance(path, Task):
        with JournalReader(options.journal or find_project(path).journal) as reader:
            text = reader.run(options.resume.run).task_text
    project, document, report, catalog = check_task(path, text, options.world)
    check_inputs(document, options.data)
    compile_task = to_machine if options.target == "sm" else to_tree
    task, factory = document.task, None
    if options.mocks:
        task, catalog, factory = apply_mocks(task, catalog, options.mocks)
    refuse(of_task(project, task, catalog, options.robot, options.mocks))
    legacy = any(isinstance(node, Leaf) and node.node.startswith("smach/") for _, node in walk(task.root))
    if options.stand_ins or (legacy and options.robot == "fake"):
        code.enter_context(dry_run(partial(progress, "stand-in")))
    return project, document, report, compile_task(task, catalog, data=options.data, leaf_factory=factory)


def _tree_of(path: str | Path) -> tuple[str, bool]:
    """Return the code of the tree that a path or its drawing means, if any, and whether that needs stand-ins."""
    if tree_code.is_tree_code(str(path)):
        return str(path), False
    text = Path(path).read_text(encoding="utf-8", errors="replace") if Path(path).is_file() else ""
    said = read(Path(path)).task.x if f"\n{DRAWN}:" in text else {}
    return str(said.get(DRAWN, "")), bool(said.get(STOOD_IN))


def _adopted(
    path: str | Path, where: str, options: RunOptions, progress: Progress, stack: ExitStack
) -> tuple[Project, Document, AdoptedTree]:
    """Run the code that makes a tree, and return the tree, with the task that draws it."""
    place = tree_code.place_of(where)
    refuse([f"imports and runs {where}"])
    project = find_project(place.file or Path.cwd() if tree_code.is_tree_code(str(path)) else path)
    named = f"{place.import_name}:{place.name}"
    if where != str(path) and named not in project.file.code:
        raise GripError(f"{path} runs {where}, which grip.yaml doesn't list: `code: [{named!r}]`")
    for word, said in (("--as sm", options.target == "sm"), ("--mock", options.mocks), ("--set", options.data)):
        if said:
            raise GripError(f"{word} is for tasks; {where} is run as it is: make one of it, grip import --from pytrees")
    nodes: list[Any] = []

    def node() -> object:
        if not nodes:
            nodes.append(load_part("ros", "a tree that takes a ROS node", "ros").TreeNode())
            stack.callback(nodes[0].close)
            progress("ros", "the tree gets the node /grip_tree")
        return nodes[0].node

    if options.stand_ins:
        stack.enter_context(dry_run_of_tree(partial(progress, "stand-in"), place.file))
    there = "rclpy" in sys.modules
    found = tree_code.find_tree(place, node)
    of_ros = tree_code.is_of_ros(found.tree.root) if there else "rclpy" in sys.modules
    setup = {"node": node()} if of_ros and not found.ready else {}
    tree = AdoptedTree(found, where, options.ticks, setup, nodes[0] if nodes else None)
    text = f"# What {where} builds; that is what runs.\n{dumps(tree.task)}"
    return project, read_text(text, str(path)), tree


@contextmanager
def open_session(
    path: str | Path | Task,
    options: RunOptions,
    progress: Progress = silent,
    hold: int | None = None,
    equipment: Equipment | None = None,
) -> Iterator[Session]:
    """Check a task, start what it needs, and compile it; everything is stopped and closed at the end.

    Args:
        hold: file descriptor of the channel over which somebody else may hold the robot; None for nobody.
        equipment: what earlier runs have left for this one, which leaves it for the next.

    Raises:
        DocumentError, InvalidTaskError: the task or the project is wrong; nothing was started.
        UnknownNameError: a mock names what isn't in the task; nothing was started.
        GripError: a part of the robot, or a component, can't be started.
    """
    with ExitStack() as code:
        compiled: CompiledTree | CompiledMachine
        where, stood_in = _tree_of(path) if not isinstance(path, Task) else ("", False)
        if where and not isinstance(path, Task):
            options = replace(options, stand_ins=options.stand_ins or stood_in)
            project, document, compiled = tree = _adopted(path, where, options, progress, code)
            options, report = replace(options, rate=options.rate or tree[2].rate), Report(())
        else:
            project, document, report, compiled = _compiled(path, options, progress, code)
        working = [leaf.manifest for leaf in compiled.leaves.values() if not isinstance(leaf, MockLeaf)]
        if options.faults and options.robot != "sim":
            raise GripError(f"faults happen in simulated worlds, not with --robot {options.robot}; mocks fail anywhere")
        check_nodes(options.faults, compiled.by_path)
        needs, own = {manifest.id for manifest in working}, {manifest.implementation for manifest in working}
        running: list[Runner] = []

        def told(part: str, words: str) -> None:
            progress(part, words)
            for runner in running:
                runner.tell(part, words)

        faults = options.faults if options.resume is None else None  # what has happened doesn't happen again
        kept = equipment or Equipment()
        opening = Opening(project, options.seed, options.pace, told, hold, faults, options.object, options.apart, kept)
        parts = open_resources(opening, needs, options.robot, own)
        with parts as resources, Journal(options.journal or project.journal) as journal:
            runner = _runner(compiled, document, options, resources, journal, progress)
            running.append(runner)
            try:
                with _filmed(resources, options), injected(resources, runner, told):
                    yield Session(project, document, report, resources, runner, journal.file)
            finally:
                runner.dismiss()
        if options.journal is None and size_of(project.journal) > project.file.journal_limit:
            try:
                pruned = make_room(project.journal, project.file.journal_limit)
            except JournalError as error:  # the run itself went well
                _log.warning("%s", error)
            else:
                _log.info("%s: %d old runs were removed (journal_limit)", project.journal, len(pruned.runs))


def _runner(
    compiled: CompiledTree | CompiledMachine,
    document: Document,
    options: RunOptions,
    resources: Resources,
    journal: Journal,
    progress: Progress,
) -> Runner:
    """Return the runner of a new run, or of one that goes on, as its options want it."""
    resume = options.resume
    log = re_execution = None
    kept = kept_parts(resources)
    restored: dict[str, int] = {}
    if resume is not None:
        log, re_execution, restored = start_resumed(journal, compiled, resume, resources.clock, options.seed, kept)
    for part, seq in restored.items():
        progress(part, f"restored to event {seq}")
    context = resources.context(None if re_execution is None else re_execution.clock)
    runner = Runner(
        compiled,
        context,
        journal=journal,
        task_path=document.source,
        task_text=document.text,
        seed=options.seed,
        rate=options.rate,
        watchdog=options.watchdog,
        log=log,
        re_execution=re_execution,
        facts={
            "options": OPTIONS.dump_python(options, mode="json", include=_RECORDED),
            "keeps": sorted(kept),
            **({"restored": restored} if restored else {}),
        },
    )
    changed = {p: tuple(x for x in changes(leaf.manifest) if x in kept) for p, leaf in compiled.leaves.items()}
    runner.keep(kept, {path: parts for path, parts in changed.items() if parts})
    return runner


def _filmed(resources: Resources, options: RunOptions) -> AbstractContextManager[None]:
    if options.video is None and options.picture is None:
        return nullcontext()
    if resources.world is None:
        raise GripError("only a simulated world can be filmed, and this run has none")
    return resources.world.filmed(options.view, options.video, options.picture)


def run(
    task: str | Path | Task, *, observer: Observer | None = None, world: str | World = "", **options: Any
) -> RunResult:
    """Run a task to its end and return the result.

    Args:
        task: a task, its file, or code that makes a tree of py_trees: `module:function`, `file.py:function`, `file.py`.
        observer: told of what the nodes do, after the journal.
        world: that is simulated in place of the project's: a name, a file, or one that was made in Python.
        **options: see `RunOptions`: target, robot, seed, pace, data, journal, ticks.

    Raises:
        DocumentError, InvalidTaskError: the task or the project is wrong; nothing was started.
        GripError: a part of the robot, or a component, can't be started.
    """
    return _run(task, observer, world, options, lambda runner: None)


def _run(
    task: str | Path | Task,
    observer: Observer | None,
    world: str | World,
    options: Mapping[str, Any],
    begins: Callable[[Runner], object],
) -> RunResult:
    if isinstance(world, World):  # kept, since the run may be resumed
        project = project_of(task) if isinstance(task, Task) else find_project(task)
        world = str(world.kept_in(project.state_folder / "worlds"))
    with open_session(task, RunOptions(world=world, **options)) as session:
        if observer is not None:
            session.runner.observe(observer)
        begins(session.runner)
        return session.runner.run()


async def run_async(
    task: str | Path | Task, *, observer: Observer | None = None, world: str | World = "", **options: Any
) -> RunResult:
    """Run a task like `run`, in a thread; who cancels this stops the run, and waits until the robot holds."""
    running: list[Runner] = []
    work = asyncio.get_running_loop().run_in_executor(None, _run, task, observer, world, options, running.append)
    try:
        return await asyncio.shield(work)
    except asyncio.CancelledError:
        for runner in running:
            runner.stop()
        await asyncio.wait([work])
        raise


def make_room(file: Path, limit: int, give_back: bool = False) -> Pruned:
    """Remove the oldest runs of a journal that are over, until it holds less than `limit` [bytes].

    A run that has no end stays while its process lives; with `give_back`, the disk gets free room back.

    Raises:
        JournalError: it is no journal, or can't be written.
    """
    with JournalReader(file) as reader:
        return prune(file, limit, reader.lives, give_back)
