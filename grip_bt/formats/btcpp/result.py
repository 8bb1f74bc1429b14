"""What comes out of reading a file of BT.CPP."""

from __future__ import annotations

from dataclasses import dataclass

from grip_bt.task import model
from grip_bt.task.catalog import Manifest

from ..pytrees.result import Remark


@dataclass(frozen=True)
class ImportedFile:
    """A task made of a file.

    Attributes:
        task: the document.
        remarks: what to know about it.
        manifests: of the node types that the catalogue doesn't have; their code is still to be written.
    """

    task: model.Task
    remarks: tuple[Remark, ...]
    manifests: tuple[Manifest, ...]
