"""What a user study measures: how long each part of the page has the focus, where `grip edit --study` asks for it."""

from __future__ import annotations

import csv
import time
from pathlib import Path

from fastapi import APIRouter

from grip_gui.wire.runs import StudySpan


def make_study_router(file: Path | None) -> APIRouter:
    """Return the route by which pages tell spans of time, rows of `file`: when [s], page, window, how long [s].

    Without a file nothing is kept, and the pages are told so.
    """
    api = APIRouter(prefix="/api/study")

    @api.post("")
    def spent(span: StudySpan) -> bool:
        if file is not None and span.seconds > 0:
            with file.open("a", newline="", encoding="utf-8") as out:
                csv.writer(out).writerow([f"{time.time():.1f}", span.page, span.window, f"{span.seconds:.1f}"])
        return file is not None

    return api
