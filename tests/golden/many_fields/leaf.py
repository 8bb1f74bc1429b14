# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component plan_reach: /planner/plan_reach of type my_pkg/srv/PlanReach."""

from grip_bt.nodes.component import ComponentLeaf


class PlanReach(ComponentLeaf):
    """Sends the inputs as the request and ends with the outcome that the response numbers.

    Inputs and outputs are declared in manifest.yaml; `labels` names the outcome numbers, from 0.
    """

    component = "plan_reach"
    labels = (
        "planned",
        "no_path",
        "failure",
    )
