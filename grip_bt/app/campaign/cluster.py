"""Trials on the machines of a Ray cluster: each is a task of Ray's; its row and its run come back to whoever asked.

The project's files go along, so that a node needs this installation and nothing else. A worker of Ray keeps a process
for trials, as one machine's workers do. A trial whose worker or node dies is begun again elsewhere; as its row is
written here, when the trial has ended, none is counted twice.
"""

from __future__ import annotations

import hashlib
import io
import os
import tarfile
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from grip_bt.app.campaign.file import Campaign, read_campaign
from grip_bt.app.campaign.results import TrialRow, files_of, picture_of, pictures_of
from grip_bt.app.campaign.trials import WAKE, Seat, Trials
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_bt.runtime.journal_rows import take_over

RETRIES = 3
"""How often a trial is begun again whose worker or node has died."""


def run_on(
    address: str, campaign: Campaign, trials: Trials, left: Iterable[tuple[str, int]], workers: int | None = None
) -> None:
    """Run trials on a cluster until all have ended, or `trials` are stopped.

    Args:
        address: of the cluster's head, such as `10.0.0.1:6379`; `auto` for the one that this machine belongs to.
        workers: trials at a time; by default as many as the cluster has processors, those of nodes that join included.

    Raises:
        GripError: there is no such cluster, or a node can't run trials at all.
        ModuleNotFoundError: Ray isn't installed.
    """
    import ray  # of the extra `cluster`
    from ray.exceptions import RayError, RayTaskError

    trials.line_up(left)
    with _connected(ray, address), tempfile.TemporaryDirectory() as folder:
        task = ray.remote(num_cpus=1, max_retries=RETRIES)(_run)
        content, name = _packed(campaign)
        digest, threads = hashlib.sha256(content).hexdigest()[:16], os.environ.get("OMP_NUM_THREADS")
        given = ray.put(content), digest, name, threads, trials.view
        under_way: dict[object, tuple[str, int]] = {}
        while True:
            room = workers or max(1, int(ray.cluster_resources().get("CPU", 0)))
            while len(under_way) < room and (trial := trials.next()) is not None:
                under_way[task.remote(*given, *trial)] = trial
            if not under_way or trials.stopped:
                return  # what is under way ends with our connection
            for ended in ray.wait(list(under_way), timeout=WAKE)[0]:
                trial = under_way.pop(ended)
                try:
                    row, run, picture = ray.get(ended)
                except RayTaskError as error:
                    raise GripError(f"a node of the cluster can't run trials: {error.cause}") from error
                except RayError as error:
                    why = f"its worker died {RETRIES + 1} times: {str(error).splitlines()[0]}"
                    trials.enter(trials.row(*trial, {"event": "ended", "status": "error", "message": why}, 0.0, None))
                    continue
                journal = Path(folder, "run.sqlite")
                journal.write_bytes(run)
                take_over(trials.journal, journal)
                if picture:
                    (trials.pictures / picture_of(row["trial"])).write_bytes(picture)
                trials.enter(row)


@contextmanager
def _connected(ray: Any, address: str) -> Iterator[None]:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        ray.init(address=address, log_to_driver=False, logging_level="ERROR")
    except (ConnectionError, RuntimeError, ValueError) as error:
        start = "`ray start --head` starts one, `ray start --address=HEAD:6379` has a machine join it"
        raise GripError(f"no Ray cluster at {address!r} ({str(error).splitlines()[0]}); {start}") from error
    try:
        yield
    finally:
        ray.shutdown()


def _packed(campaign: Campaign) -> tuple[bytes, str]:
    """Return an archive of the files of a campaign and its projects, and the campaign's name in it."""
    projects = {home.folder.resolve(): home for home in map(find_project, map(campaign.task, campaign.file.variants))}
    file, places = campaign.path.resolve(), {*projects}
    for project in projects.values():  # what it names may lie elsewhere
        said = project.file
        named = (said.components, said.nodes, *said.code, said.robot, said.world, said.scene)
        places |= {(project.folder / name).resolve() for name in named if isinstance(name, str)}
    found = {file, *(each for place in places for each in (files_of(place) if place.is_dir() else [place]))}
    root, content = Path(os.path.commonpath([file.parent, *places])), io.BytesIO()
    with tarfile.open(fileobj=content, mode="w:gz", dereference=True, compresslevel=1) as archive:
        for each in sorted(each for each in found if each.is_file()):
            archive.add(each, str(each.relative_to(root)))
    return content.getvalue(), str(file.relative_to(root))


# --- on a node ---

_seats: dict[str, tuple[Seat, Path]] = {}
"""Digest of a campaign's files -> where this process runs its trials, and their journal."""


def _run(
    content: bytes, digest: str, name: str, threads: str | None, view: str | None, variant: str, seed: int
) -> tuple[TrialRow, bytes, bytes]:
    """Run a trial; return its row, the journal that holds its run, and its picture if one was taken."""
    if digest not in _seats:
        os.environ.pop("OMP_NUM_THREADS", None)  # Ray's; how numbers are added up shall not depend on where
        os.environ |= {} if threads is None else {"OMP_NUM_THREADS": threads}
        journal = Path(tempfile.mkdtemp(prefix="grip-trials-"), "run.sqlite")
        campaign = read_campaign(_unpacked(content, digest) / name)
        _seats[digest] = Seat(Trials(campaign, journal, lambda row: None, view=view)), journal
    seat, journal = _seats[digest]
    row = seat.run(variant, seed)
    assert row is not None, "nobody stops trials on a node; their processes are ended"
    run, picture = journal.read_bytes(), pictures_of(journal) / picture_of(row["trial"])
    journal.unlink()
    return row, run, picture.read_bytes() if picture.exists() else b""


def _unpacked(content: bytes, digest: str) -> Path:
    """Return the folder of this machine in which an archive is unpacked; it stays for later campaigns."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "grip" / "campaigns"
    folder = cache / digest
    if not folder.is_dir():
        cache.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(dir=cache))
        with tarfile.open(fileobj=io.BytesIO(content)) as archive:
            archive.extractall(fresh, filter="data")
        with suppress(OSError):  # another worker of this machine was faster
            fresh.rename(folder)
    return folder
