"""Manifests from YAML files: one manifest, or a list of them."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, ValidationError

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.types import parse_type
from grip_bt.base.yaml.models import Diagnostic, diagnostic_of, document_error
from grip_bt.base.yaml.tree import YamlList, YamlMapping, YamlValue, parse, read_file, to_data

from .manifest import InputPort, Manifest, OutputPort, Parameter

_PORTS: dict[str, type[BaseModel]] = {"parameters": Parameter, "inputs": InputPort, "outputs": OutputPort}


def read_manifests(path: Path | str) -> list[Manifest]:
    """Read the manifests of a file.

    An `implementation` in a Python file (`leaf.py:Class`) is relative to the manifest's folder; it is returned with the
    file's absolute path, so that a manifest alone says where its leaf is.

    Raises:
        DocumentError: a manifest is wrong, with the place of the first fault and a list of the others.
    """
    source = str(path)
    tree = parse(read_file(path), source)
    if isinstance(tree, YamlList):
        trees = [entry.value for entry in tree.entries]
    else:
        trees = [tree]
    manifests = [_read(each, source) for each in trees]
    folder = Path(path).resolve().parent
    return [_with_absolute_file(manifest, folder) for manifest in manifests]


def find_manifests(folder: Path | str) -> list[Manifest]:
    """Read every `manifest.yaml` in a folder and below it, in the order of their paths.

    Raises:
        DocumentError: a manifest is wrong.
    """
    files = sorted(Path(folder).glob("**/manifest.yaml"))
    return [manifest for file in files for manifest in read_manifests(file)]


def _read(tree: YamlValue, source: str) -> Manifest:
    if not isinstance(tree, YamlMapping):
        raise DocumentError(
            "a manifest is a mapping with `id:`, `doc:` and `implementation:`",
            source,
            tree.line,
            tree.column,
        )
    faults = [*_unknown_keys(tree), *_wrong_types(tree)]
    if faults:
        raise document_error(faults, source)
    try:
        manifest = Manifest.model_validate(to_data(tree))
    except ValidationError as error:
        raise document_error([diagnostic_of(tree, e) for e in error.errors()], source) from None
    faults = list(_wrong_outcomes(tree, manifest))
    if faults:
        raise document_error(faults, source)
    return manifest


def _unknown_keys(tree: YamlMapping) -> list[Diagnostic]:
    checked = [(tree, tuple(Manifest.model_fields), "a manifest")]
    for key, shape in _PORTS.items():
        ports = tree.entries.get(key)
        if ports is not None and isinstance(ports.value, YamlMapping):
            checked.extend(
                (port.value, tuple(shape.model_fields), f"{key}/{name}")
                for name, port in ports.value.entries.items()
                if isinstance(port.value, YamlMapping)
            )
    return [
        (
            f"unknown key {key!r} in {name}{nearest(key, allowed)} (there are: {listing(allowed)})",
            entry.line,
            entry.column,
        )
        for mapping, allowed, name in checked
        for key, entry in mapping.entries.items()
        if key not in allowed
    ]


def _wrong_types(tree: YamlMapping) -> list[Diagnostic]:
    faults = []
    for key in _PORTS:
        ports = tree.entries.get(key)
        for name, port in (
            ports.value.entries.items() if ports is not None and isinstance(ports.value, YamlMapping) else ()
        ):
            entry = port.value.entries.get("type") if isinstance(port.value, YamlMapping) else None
            if entry is None or not isinstance(to_data(entry.value), str):
                continue  # the model says so
            try:
                parse_type(to_data(entry.value))
            except ValueError as error:
                faults.append((f"{key}/{name}: {error}", entry.value.line, entry.value.column))
    return faults


def _wrong_outcomes(tree: YamlMapping, manifest: Manifest) -> list[Diagnostic]:
    faults = []
    for name, port in manifest.outputs.items():
        for outcome in port.on:
            if outcome not in manifest.outcomes:
                hint = nearest(outcome, manifest.outcomes)
                allowed = listing(manifest.outcomes)
                message = f"outputs/{name}: unknown outcome {outcome!r}{hint} (there are: {allowed})"
                faults.append((message, tree.line, tree.column))
    return faults


def _with_absolute_file(manifest: Manifest, folder: Path) -> Manifest:
    where, _, name = manifest.implementation.rpartition(":")
    if not where.endswith(".py") or Path(where).is_absolute():
        return manifest
    return manifest.model_copy(update={"implementation": f"{folder / where}:{name}"})
