"""The kinds of containers, a file each. A new kind is a file here: whatever is said of all kinds is found in them."""

from importlib import import_module
from pkgutil import iter_modules

from .base import Kind, every_kind

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")

KINDS: dict[str, type[Kind]] = {made.kind_name(): made for made in every_kind()}
"""Every kind by its name in documents, in the order in which they are listed."""
