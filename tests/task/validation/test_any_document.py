"""Whatever can be read as a task can be checked, formatted, converted, run and shown; or is refused in words."""

from __future__ import annotations

import os
from itertools import islice
from pathlib import Path

import pytest
import schema_documents
import survival
from hypothesis import HealthCheck, given, settings

from grip_bt.task.document import keys_of
from grip_bt.task.model import KINDS

FUZZ = int(os.environ.get("GRIP_FUZZ_DOCUMENTS", "0"))
SOME = FUZZ or 40


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A task file of a project with a robot."""
    return survival.project(tmp_path_factory.mktemp("any"))


def test_each_key_of_each_kind_has_values() -> None:
    kinds = [KINDS[kind] for kind in schema_documents.model.KINDS]
    keys = {key for shape in (*kinds, schema_documents.model.Leaf) for key in keys_of(shape)}
    assert keys <= schema_documents.VALUES.keys()


def test_every_key_with_every_value_is_survived(file: Path) -> None:
    documents = list(schema_documents.systematic())
    step = max(1, len(documents) // SOME)
    catalog = survival.project_catalog(file)
    right = 0
    for data in islice(documents, 0, None, step):
        document = survival.read(data, file)
        if document is not None:
            right += survival.looked_at(document, file, catalog).ok
    assert right > SOME // 8


@settings(max_examples=SOME // 2, suppress_health_check=list(HealthCheck))
@given(data=schema_documents.documents)
def test_any_nesting_is_survived(file: Path, data: dict[str, object]) -> None:
    document = survival.read(data, file)
    if document is not None:
        survival.looked_at(document, file, survival.project_catalog(file))


def test_what_is_right_runs_with_fakes(file: Path) -> None:
    documents = list(schema_documents.systematic())
    step = max(1, len(documents) // (SOME // 4))
    catalog, ends = survival.project_catalog(file), list[str]()
    for number, data in enumerate(islice(documents, 3, None, step)):
        document = survival.read(data, file)
        if document is not None and survival.validate(document.task, catalog, document).ok:
            ends.append(survival.run(file, "sm" if number % 2 else "bt"))
    assert ends


def test_the_page_shows_any_of_them(file: Path) -> None:
    pytest.importorskip("starlette")
    import warnings

    from grip_gui.server import create_app

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from starlette.testclient import TestClient
    base = "http://127.0.0.1:8765"
    documents = list(schema_documents.systematic())
    step = max(1, len(documents) // (SOME // 2))
    with TestClient(create_app(file.parents[1], token="t"), base_url=base, headers={"origin": base}) as page:
        page.get("/?token=t")
        for number, data in enumerate(islice(documents, 5, None, step)):
            place = file.with_name(f"page_{number}.yaml")
            if survival.read(data, place) is not None:
                said = {q: (status, text) for q, status, text in survival.asked(page, f"tasks/{place.name}")}
                assert [each for each in said.items() if each[1][0] >= 500] == [], data
