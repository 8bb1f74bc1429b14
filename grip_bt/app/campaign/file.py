"""A campaign's file: tasks, factors, seeds, what counts as success, what is measured; and what is run of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from random import Random
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, field_validator

from grip_bt.app.project.folder import Key
from grip_bt.app.runs.execute import MOST_SEED
from grip_bt.app.runs.mocks import Script
from grip_bt.base.errors import CampaignError
from grip_bt.base.yaml.models import Settings, read_model
from grip_sim.faults import Fault

MOST_SEEDS = 100_000
Plain = bool | int | float | str | None
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
    world: str = ""
    """The simulated world; without it, the project's."""
    object: str = ""
    """An object of the library, or its file: every object of the world becomes this one."""
    set: dict[Key, Any] = {}
    """Initial values of the task's variables."""
    mocks: dict[str, Script] = {}
    """Scripts in place of nodes."""
    faults: dict[Key, Fault] = {}
    """What goes wrong in the simulated world, besides the faults of its file."""


class StopRule(Settings):
    """When a variant isn't tried any more, though there are seeds left."""

    width: float = Field(gt=0, lt=1)
    """When Wilson's 95 % interval of its success rate is no wider than this,"""
    least: int = Field(default=20, ge=2)
    """and it was tried at least this often."""


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
    factors: dict[Key, dict[str, Variant] | list[Plain]] = {}
    """Name -> its levels: what each changes, or values of the task's variable of that name. A variant is a combination
    of levels, and of `variants` if there are any."""
    design: Literal["full", "latin"] = "full"
    """`full`: every combination on every seed. `latin`: each level once on a seed, and each pair of levels once in as
    many seeds as a factor has levels."""
    order: Literal["blocked", "random", "listed"] = "blocked"
    """Seed by seed, the variants of each in random order; all at random; or seed by seed as they are listed."""
    shuffle: Seed = 0
    """Seed of the random order."""
    stop: StopRule | None = None
    """When a variant isn't tried any more; without it, all are on every seed."""
    repeat: int = Field(default=50, ge=0)
    """After this many trials one is run again, in new processes, and compared event by event; 0 for never."""

    @field_validator("seeds", mode="wrap")
    @classmethod
    def _told_as_one(cls, value: object, check: Callable[[object], object]) -> object:
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
    levels: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """Variant -> factor -> level."""

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

    def trials(self) -> list[tuple[str, int]]:
        """Return each (variant, seed) in the order in which they are run, which is the same each time."""
        blocks = [[(variant, seed) for variant in self._met(row)] for row, seed in enumerate(self.seeds)]
        for block, seed in zip(blocks, self.seeds, strict=True) if self.file.order == "blocked" else ():
            Random(f"{self.file.shuffle} {seed}").shuffle(block)
        trials = [trial for block in blocks for trial in block]
        if self.file.order == "random":
            Random(self.file.shuffle).shuffle(trials)
        return trials

    def _met(self, row: int) -> list[str]:
        """Return the variants that meet the seed of a row: of a Latin design, those of a cyclic square."""
        if self.file.design == "full":
            return list(self.file.variants)
        axes = [list(dict.fromkeys(levels)) for levels in zip(*(v.values() for v in self.levels.values()), strict=True)]
        count = len(axes[0])
        cells = [[axis[(first + k * row) % count] for k, axis in enumerate(axes)] for first in range(count)]
        return [name for name, levels in self.levels.items() if list(levels.values()) in cells]


def read_campaign(path: Path) -> Campaign:
    """Read a campaign's file.

    Raises:
        DocumentError: it can't be read, or doesn't fit; with line and column.
        CampaignError: it has no variant and no task, a variant without one, a seed twice, or factors that don't fit.
    """
    file, levels = read_model(path, CampaignFile), dict[str, Mapping[str, str]]()
    if file.factors:
        made = dict(_crossed(Campaign(path, file)))
        levels = {name: dict(chosen) for name, (chosen, _) in made.items()}
        file = file.model_copy(update={"variants": {name: variant for name, (_, variant) in made.items()}})
    elif not file.variants and file.task is not None:
        file = file.model_copy(update={"variants": {Path(file.task).stem: Variant()}})
    campaign = Campaign(path, file, levels)
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


def _crossed(campaign: Campaign) -> Iterator[tuple[str, tuple[Mapping[str, str], Variant]]]:
    """Yield each combination of levels: its name, its levels, and what it changes."""
    file = campaign.file
    axes = {"variant": dict(file.variants)} if file.variants else {}
    for factor, said in file.factors.items():
        named = said if isinstance(said, dict) else {str(value): Variant(set={factor: value}) for value in said}
        if len(named) < max(1, len(said)):
            raise campaign.error(f"factors/{factor}: it needs levels that differ, not {said}")
        axes[factor] = named
    counts = {len(levels) for levels in axes.values()}
    count = max(counts)
    if file.design == "latin" and (len(axes) < 2 or len(counts) > 1):
        shown = ", ".join(f"{name} has {len(levels)}" for name, levels in axes.items())
        raise campaign.error(f"a Latin design needs two factors or more with equally many levels: {shown}")
    if file.design == "latin" and len(axes) > 2 and any(count % k == 0 for k in range(2, len(axes))):
        reason = "has each pair of levels once only if no number below that of factors divides the number of levels"
        raise campaign.error(f"a Latin design of {len(axes)} factors {reason}, which is {count}")
    for cell in product(*(levels.items() for levels in axes.values())):
        levels = dict(zip(axes, (level for level, _ in cell), strict=True))
        name, merged = "/".join(levels.values()), dict[str, Any]()
        for _, variant in cell:
            for key in variant.model_fields_set:
                value = getattr(variant, key)
                both = key in merged and (merged[key].keys() & value.keys() if isinstance(value, dict) else {key})
                if both:
                    raise campaign.error(f"{name}: two factors say what {key}/{', '.join(sorted(both))} is")
                merged[key] = {**merged.get(key, {}), **value} if isinstance(value, dict) else value
        yield name, (levels, Variant(**merged))


def head_of(campaign: Campaign) -> dict[str, object]:
    """Return what results begin with: all that makes each variant what it is, as JSON data."""
    said = campaign.file
    common = said.model_dump(mode="json", include={"robot", "success", "count", "measure", "timeout"})
    variants = {
        name: {
            "task": campaign.task(name).read_text(),
            **common,
            **variant.model_dump(
                mode="json", by_alias=True, exclude={"task", *({"world", "object"} - variant.model_fields_set)}
            ),
            **({"levels": dict(campaign.levels[name])} if name in campaign.levels else {}),
        }
        for name, variant in said.variants.items()
    }
    return {"name": campaign.name, "doc": said.doc, "variants": variants}
