"""BehaviorTree.CPP's own nodes where no kind of ours is equal, and Nav2's; for tasks that were imported from there."""
