"""What changes in fake parts while a task runs, so that a run that is gone on with finds them as they were."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from grip_bt.commanders.fake import FakeArm, FakeComponent, FakeHand
from grip_bt.commanders.taught import Taught


@dataclass
class FakeState:
    """Where fake arms and hands are, what was taught to them, and which reply of a component is the next.

    Attributes:
        arms: by name.
        hands: by name.
        components: by name.
        taught: what was taught to arms and hands.
    """

    arms: Mapping[str, FakeArm] = field(default_factory=dict)
    hands: Mapping[str, FakeHand] = field(default_factory=dict)
    components: Mapping[str, FakeComponent] = field(default_factory=dict)
    taught: Taught = field(default_factory=Taught)

    def kept(self) -> dict[str, Any]:
        """Return all of it, as a value of the journal."""
        return {
            "arms": {name: arm.state().position for name, arm in self.arms.items()},
            "hands": {name: hand.kept() for name, hand in self.hands.items()},
            "components": {name: component.given for name, component in self.components.items()},
            "taught": {part: dict(self.taught.of(part)) for part in self.taught.parts()},
        }

    def put_back(self, kept: Mapping[str, Any]) -> None:
        """Have everything as it was; nothing may be under way.

        Raises:
            KeyError, ValueError: an arm, a hand or a component isn't here any more, or has other joints.
        """
        for parts, states in ((self.arms, kept["arms"]), (self.hands, kept["hands"])):
            for name, position in states.items():
                parts[name].put_back(position)
        for name, given in kept["components"].items():
            self.components[name].put_back(given)
        for part, entries in kept["taught"].items():
            for name, value in entries.items():
                self.taught.put(part, name, value, {})
