"""A campaign in a program or a notebook: `print(grip.campaign("campaigns/two_forms.yaml"))`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grip_bt.app.campaign.file import head_of, read_campaign
from grip_bt.app.campaign.report import as_text, records, write_report
from grip_bt.app.campaign.results import Results, alone, begin
from grip_bt.app.campaign.statistics import summary
from grip_bt.app.campaign.trials import Trials, check
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import MissingPartError


@dataclass(frozen=True)
class CampaignResults:
    """What came of a campaign; as a text, its report."""

    results: Results

    @property
    def records(self) -> list[dict[str, object]]:
        """A flat record a trial, all with the same keys."""
        return records(self.results)

    @property
    def summary(self) -> dict[str, object]:
        """Rates with their intervals by variant and level, measures, comparisons; as `grip bench --json` has it."""
        return summary(self.results)

    def frame(self) -> Any:
        """Return the trials as a `pandas.DataFrame`; MissingPartError where pandas isn't installed."""
        try:
            import pandas
        except ImportError:
            raise MissingPartError("a data frame", "pip install pandas, or use `records`") from None
        return pandas.DataFrame(self.records)

    def save(self, file: str | Path) -> None:
        """Write the report: `.html`, `.tex`, `.parquet`, `.csv`, `.json` or `.md`."""
        write_report(self.results, Path(file))

    def __str__(self) -> str:
        return as_text(self.results)


def campaign(
    file: str | Path, *, workers: int = 1, resume: bool = False, output: str | Path | None = None
) -> CampaignResults:
    """Run a campaign's trials and return what came of them; see docs/campaigns.md.

    Args:
        workers: trials at a time.
        resume: whether results that are there are kept, and only missing trials are run.
        output: where results are written as they come; `.grip/campaigns/NAME.jsonl` of the project by default.

    Raises:
        CampaignError: the file is wrong, or there are results already.
        GripError: a task or the project is wrong.
    """
    found = read_campaign(Path(file))
    check(found)
    own = find_project(found.task(next(iter(found.file.variants)))).state_folder / "campaigns" / f"{found.name}.jsonl"
    place = own if output is None else Path(output)
    with alone(place):
        results = begin(place, head_of(found), resume)
        done = results.done
        trials = Trials(found, place.with_suffix(".sqlite"), results.add, before=results.rows)
        trials.run([trial for trial in found.trials() if trial not in done], workers)
    return CampaignResults(results)
