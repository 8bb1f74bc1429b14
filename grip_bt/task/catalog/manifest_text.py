"""A manifest as the YAML text that a person would write: without what is default, in a fixed order."""

from __future__ import annotations

import io
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from grip_bt.task.catalog.manifest import Manifest


def manifest_text(manifest: Manifest, header: str) -> str:
    """Return the file `manifest.yaml`.

    Args:
        manifest: what to write.
        header: a comment for its first lines, each with `#`.
    """
    data: dict[str, Any] = {"id": manifest.id, "doc": manifest.doc, "implementation": manifest.implementation}
    dumped = manifest.model_dump(mode="python", exclude_defaults=True)
    for key in ("parameters", "inputs", "outputs"):
        if dumped.get(key):
            data[key] = {name: _flow(port) for name, port in dumped[key].items()}
    data["outcomes"] = _flow(dict(manifest.outcomes))
    if manifest.codes:
        data["codes"] = _flow(list(manifest.codes))
    if manifest.moves is not None:
        data["moves"] = manifest.moves
    if manifest.settings:
        data["settings"] = dict(manifest.settings)
    yaml = YAML()
    yaml.width = 110
    yaml.indent(mapping=2, sequence=4, offset=2)
    text = io.StringIO()
    yaml.dump(data, text)
    return header + text.getvalue()


def _flow(value: Any) -> Any:
    """Return a mapping or a sequence that is written on one line."""
    made: CommentedMap | CommentedSeq
    if isinstance(value, dict):
        made = CommentedMap({k: _flow(v) for k, v in value.items()})
    elif isinstance(value, (list, tuple)):
        made = CommentedSeq(map(_flow, value))
    else:
        return value
    made.fa.set_flow_style()
    return made
