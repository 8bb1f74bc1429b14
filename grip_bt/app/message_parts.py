"""The named messages of a run: those of the project's files in this process, or those of a server that runs."""

from __future__ import annotations

import os
from contextlib import ExitStack

from grip_bt.base.message_store import LocalMessages, MessageLibrary, load, save
from grip_bt.runtime.value_codec import decode, encode

from .project import ARCHIVE, MESSAGES, Project
from .resources import Progress, Resources


def open_messages(
    project: Project, resources: Resources, stack: ExitStack, progress: Progress, server: bool = True
) -> None:
    """Put the project's named messages into `resources`.

    Args:
        project: whose.
        resources: filled in.
        stack: closes what was opened.
        progress: told where they are.
        server: whether a server may be asked, where the project has one.

    Raises:
        DocumentError: a file of the project's folder `messages/` is wrong.
        ArchiveError: what an earlier run kept can't be read.
    """
    if project.file.message_server and server:
        _open_server(resources, stack, progress)
        return
    folder = project.folder / MESSAGES
    library = MessageLibrary(folder if folder.is_dir() else None)
    file = project.state_folder / ARCHIVE
    kept = load(lambda name: library.store(name, make=True), file, decode) if file.is_file() else 0
    resources.messages = LocalMessages(library, lambda: save(library.stores(), file, encode))
    named = sum(len(store) for store in library.stores().values())
    progress("messages", f"{named} by name, {kept} of them kept by an earlier run")


def _open_server(resources: Resources, stack: ExitStack, progress: Progress) -> None:
    """Ask a server that runs: it is in the user's own domain."""
    from grip_bt.ros.bus import Bus
    from grip_bt.ros.managers import RosMessages

    chosen = os.environ.get("ROS_DOMAIN_ID")
    bus = stack.enter_context(Bus("grip_task_messages", domain_id=int(chosen) if chosen else None))
    resources.messages = RosMessages(bus)
    progress("messages", "of the server under /grip/messages")
