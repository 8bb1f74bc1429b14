# Generated from component.yaml by `grip component add`; edits here are lost when it runs again.
"""The leaf of the component plan_grasp: /plan_grasp of type my_pkg/action/PlanGrasp."""

from grip_bt.nodes.component import ComponentLeaf


class PlanGrasp(ComponentLeaf):
    """Sends the inputs as the goal and ends with the outcome that the result numbers.

    Inputs and outputs are declared in manifest.yaml; `labels` names the outcome numbers, from 0.
    """

    component = "plan_grasp"
    labels = (
        "found",
        "none",
    )
