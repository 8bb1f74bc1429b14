"""What is closed at the end of its `with`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Self


class Closing(ABC):
    """Something that holds a process, a connection or a file until it is closed."""

    @abstractmethod
    def close(self) -> None:
        """Let go of it; harmless when repeated."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
