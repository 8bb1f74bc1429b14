"""What a campaign's file says: which tasks, on which seeds, what counts as success, and what is measured."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError, field_validator

from grip_bt.app.runs.mocks import Script
from grip_bt.base.errors import CampaignError
from grip_bt.base.yaml.models import read_model

from ..runs.execute import MOST_SEED

MOST_SEEDS = 100_000
Seed = Annotated[int, Field(ge=0, le=MOST_SEED)]
Key = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]


class _Config(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True, populate_by_name=True)


class SeedRange(_Config):
    """Seeds one after the other."""

    first: Seed = 0
    count: int = Field(ge=1, le=MOST_SEEDS)


class Variant(_Config):
    """One of the ways that are compared."""

    task: str | None = None
    """The task's file, beside the campaign's own or from its folder upward; without it, the campaign's."""
    form: Literal["bt", "sm"] = Field(default="bt", alias="as")
    """Behaviour tree or state machine."""
    set: dict[Key, Any] = {}
    """Initial values of the task's variables."""
    mocks: dict[str, Script] = {}
    """Scripts in place of nodes."""


class CampaignFile(_Config):
    """What `campaigns/NAME.yaml` holds."""

    campaign: Literal[1]
    doc: str = ""
    task: str | None = None
    """The task's file, for variants that name none."""
    robot: Literal["sim", "fake"] = "sim"
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

    @field_validator("seeds", mode="wrap")
    @classmethod
    def _told_as_one(cls, value: Any, check: Callable[[Any], Any]) -> Any:
        try:
            return check(value)
        except ValidationError:  # it would say of each form why it isn't that
            forms = f"whole numbers from 0 to {MOST_SEED}, such as [1, 2, 3], or {{first: 0, count: 10}}"
            most = f"; a count is 1 to {MOST_SEEDS}"
            raise ValueError(f"{forms}{most}, not {value!r:.60}") from None


@dataclass(frozen=True)
class Campaign:
    """A campaign's file, and where it is.

    Attributes:
        path: the file.
        file: what it says; there is at least one variant.
    """

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
        if isinstance(said, SeedRange):
            return tuple(range(said.first, said.first + said.count))
        return tuple(said)

    def task(self, variant: str) -> Path:
        """Return the file of a variant's task.

        Raises:
            CampaignError: it isn't there.
        """
        name = self.file.variants[variant].task or self.file.task
        assert name is not None, "a campaign's variants have tasks"
        folders = [self.path.absolute().parent, *self.path.absolute().parent.parents[:2]]
        for folder in folders:
            if (folder / name).is_file():
                return folder / name
        looked = ", ".join(map(str, folders))
        raise CampaignError(str(self.path), f"variant {variant!r}: there is no task {name!r} (looked in {looked})")

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
    if not file.variants:
        if file.task is None:
            raise CampaignError(str(path), "nothing to run: give `task`, or `variants` with a `task` each")
        file = file.model_copy(update={"variants": {Path(file.task).stem: Variant()}})
    without = [name for name, variant in file.variants.items() if variant.task is None and file.task is None]
    if without:
        raise CampaignError(str(path), f"no task for {', '.join(without)}: give `task` there, or one for all")
    campaign = Campaign(path, file)
    if not campaign.seeds:
        raise CampaignError(str(path), "`seeds` is empty: give a list of numbers, or first and count")
    twice = sorted(seed for seed, times in Counter(campaign.seeds).items() if times > 1)
    if twice:
        raise CampaignError(str(path), f"duplicate seeds: {', '.join(map(str, twice))}")
    return campaign


def head_of(campaign: Campaign) -> dict[str, Any]:
    """Return what results begin with: all that makes each variant what it is, as JSON data."""
    variants = {name: dict(_settings(campaign, name)) for name in campaign.file.variants}
    return {"name": campaign.name, "doc": campaign.file.doc, "variants": variants}


def _settings(campaign: Campaign, variant: str) -> Mapping[str, Any]:
    said = campaign.file
    return {
        "task": campaign.task(variant).read_text(),
        "robot": said.robot,
        "success": said.success,
        "count": dict(said.count),
        "measure": dict(said.measure),
        "timeout": said.timeout,
        **said.variants[variant].model_dump(mode="json", by_alias=True, exclude={"task"}),
    }
