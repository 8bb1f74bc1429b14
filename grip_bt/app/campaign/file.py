"""A campaign's file: tasks, seeds, what counts as success, what is measured; and the file of its results."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, TypedDict

from pydantic import Field, ValidationError, field_validator

from grip_bt.app.project.folder import Key
from grip_bt.app.runs.execute import MOST_SEED
from grip_bt.app.runs.mocks import Script
from grip_bt.base.errors import CampaignError, NotWritableError
from grip_bt.base.yaml.models import Settings, read_model
from grip_sim.faults import Fault

MOST_SEEDS = 100_000
Seed = Annotated[int, Field(ge=0, le=MOST_SEED)]


class SeedRange(Settings):
    """Seeds one after the other."""

    first: Seed = 0
    """The first seed."""
    count: int = Field(ge=1, le=MOST_SEEDS)
    """How many there are."""


class Variant(Settings, populate_by_name=True):
    """One of the ways that are compared."""

    task: str | None = None
    """The task's file, beside the campaign's own or from its folder upward; without it, the campaign's."""
    form: Literal["bt", "sm"] = Field(default="bt", alias="as")
    """Behaviour tree or state machine."""
    set: dict[Key, Any] = {}
    """Initial values of the task's variables."""
    mocks: dict[str, Script] = {}
    """Scripts in place of nodes."""
    faults: dict[Key, Fault] = {}
    """What goes wrong in the simulated world, besides the faults of its file."""


class CampaignFile(Settings):
    """What `campaigns/NAME.yaml` holds."""

    campaign: Literal[1]
    doc: str = ""
    task: str | None = None
    """The task's file, for variants that name none."""
    robot: Literal["sim", "fake"] = "sim"
    """The simulated robot, or one without physics."""
    seeds: SeedRange | list[Seed] = SeedRange(count=10)
    """Of the worlds: every variant meets each of them once."""
    timeout: float = Field(default=600.0, gt=0)
    """How long one trial may take, start-up included [s of wall time]."""
    success: str = "status == 'success' and not contradicted"
    """Condition over what is known of a trial."""
    count: dict[Key, str] = {}
    """Name -> path of a node whose activations are counted."""
    measure: dict[Key, str] = {}
    """Name -> expression over what is known of a trial."""
    variants: dict[Key, Variant] = {}
    """What is compared; without it, the task alone."""

    @field_validator("seeds", mode="wrap")
    @classmethod
    def _told_as_one(cls, value: object, check: Callable[[Any], Any]) -> Any:
        try:
            return check(value)
        except ValidationError:  # it would say of each form why it isn't that
            forms = f"whole numbers from 0 to {MOST_SEED}, such as [1, 2, 3], or {{first: 0, count: 10}}"
            most = f"; a count is 1 to {MOST_SEEDS}"
            raise ValueError(f"{forms}{most}, not {value!r:.60}") from None


@dataclass(frozen=True)
class Campaign:
    """A campaign's file, and where it is; there is at least one variant."""

    path: Path
    file: CampaignFile

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return self.path.stem

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds, in order."""
        said = self.file.seeds
        return tuple(range(said.first, said.first + said.count) if isinstance(said, SeedRange) else said)

    def task(self, variant: str) -> Path:
        """Return the file of a variant's task. Raises CampaignError where it isn't there."""
        name = self.file.variants[variant].task or self.file.task
        assert name is not None, "a campaign's variants have tasks"
        folders = [self.path.absolute().parent, *self.path.absolute().parent.parents[:2]]
        for folder in folders:
            if (folder / name).is_file():
                return folder / name
        raise self.error(f"variant {variant!r}: there is no task {name!r} (looked in {', '.join(map(str, folders))})")

    def error(self, text: str) -> CampaignError:
        """Return what is wrong with it, as an error."""
        return CampaignError(str(self.path), text)

    def trials(self) -> Iterator[tuple[str, int]]:
        """Yield each (variant, seed), seed by seed, so that an early end leaves pairs that can be compared."""
        for seed in self.seeds:
            for variant in self.file.variants:
                yield variant, seed


def read_campaign(path: Path) -> Campaign:
    """Read a campaign's file.

    Raises:
        DocumentError: it can't be read, or doesn't fit; with line and column.
        CampaignError: it has no variant and no task, a variant without one, or a seed twice.
    """
    file = read_model(path, CampaignFile)
    if not file.variants and file.task is not None:
        file = file.model_copy(update={"variants": {Path(file.task).stem: Variant()}})
    campaign = Campaign(path, file)
    without = [name for name, variant in file.variants.items() if variant.task is None and file.task is None]
    twice = sorted(seed for seed, times in Counter(campaign.seeds).items() if times > 1)
    if not file.variants:
        raise campaign.error("nothing to run: give `task`, or `variants` with a `task` each")
    if without:
        raise campaign.error(f"no task for {', '.join(without)}: give `task` there, or one for all")
    if not campaign.seeds:
        raise campaign.error("`seeds` is empty: give a list of numbers, or first and count")
    if twice:
        raise campaign.error(f"duplicate seeds: {', '.join(map(str, twice))}")
    return campaign


def head_of(campaign: Campaign) -> dict[str, Any]:
    """Return what results begin with: all that makes each variant what it is, as JSON data."""
    said = campaign.file
    common = said.model_dump(mode="json", include={"robot", "success", "count", "measure", "timeout"})
    variants = {
        name: {
            "task": campaign.task(name).read_text(),
            **common,
            **variant.model_dump(mode="json", by_alias=True, exclude={"task"}),
        }
        for name, variant in said.variants.items()
    }
    return {"name": campaign.name, "doc": said.doc, "variants": variants}


_FORMAT = 1
Plain = bool | int | float | str | None


class TrialRow(TypedDict, total=False):
    """A trial, and what came of it; `_trial` and `judged` say what each is."""

    variant: str
    seed: int
    status: str
    outcome: str | None
    code: str | None
    message: str
    duration: float | None
    wall: float
    run: str | None
    truth: Mapping[str, str] | None
    contradicted: bool
    judged: dict[str, bool]
    unconfirmed: str
    counts: dict[str, int]
    measures: dict[str, Plain]
    success: bool
    unclear: dict[str, str]


@dataclass
class Results:
    """A file of results: its head (`name`, `doc`, `variants`: name -> settings), and trials in order of their ends."""

    path: Path
    head: Mapping[str, Any]
    rows: list[TrialRow] = field(default_factory=list)

    @property
    def done(self) -> set[tuple[str, int]]:
        """The trials that are there."""
        return {(row["variant"], row["seed"]) for row in self.rows}

    def add(self, row: TrialRow) -> None:
        """Write a trial; it is on disk when this returns. Raises NotWritableError where it can't be written."""
        _append(self.path, row)
        self.rows.append(row)


def begin(path: Path, head: Mapping[str, Any], resume: bool) -> Results:
    """Open a file of results, written under this head, for more trials; with `resume`, those that are there stay.

    Raises:
        CampaignError: it is there, and `resume` isn't asked; or it was made with other settings, which are named.
        NotWritableError: it can't be written.
    """
    if not path.exists():
        _append(path, {"campaign": _FORMAT, **head})
        return Results(path, head)
    if not resume:
        advice = "continue them with --resume, remove the file, or choose another one with -o"
        raise CampaignError(str(path), f"there are results already: {advice}")
    results = read(path)
    for variant, now in head["variants"].items():
        before = results.head["variants"].get(variant)
        changed = [] if before in (None, now) else [key for key in now if now[key] != before.get(key)]
        if changed:
            text = f"{variant!r} isn't what it was when these trials ran (changed: {', '.join(changed)})"
            advice = "results of different settings aren't mixed: start a new file with -o FILE"
            raise CampaignError(str(path), f"{text}; {advice}")
    written = path.read_bytes()
    if not written.endswith(b"\n"):  # what a crash has left of a line
        path.write_bytes(written[: written.rfind(b"\n") + 1])
    return results


def read(path: Path) -> Results:
    """Read results, without a last line that was cut off. Raises CampaignError where it isn't such a file."""
    try:
        lines = path.read_text().split("\n")
        rows = [json.loads(line) for line in lines[:-1] if line]
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        text = f"can't be read as results of a campaign: {why}; `grip bench CAMPAIGN` writes them"
        raise CampaignError(str(path), text) from error
    if not rows or not isinstance(rows[0], dict) or rows[0].get("campaign") != _FORMAT:
        raise CampaignError(str(path), "these aren't results of a campaign: `grip bench CAMPAIGN` writes them")
    return Results(path, rows[0], rows[1:])


def _append(path: Path, row: Mapping[str, object] | TrialRow) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a") as file:
            file.write(json.dumps(row, default=str) + "\n")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise NotWritableError(path, error, "give another file with -o") from error
