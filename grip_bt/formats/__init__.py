"""What comes from elsewhere and goes there: other tools' trees and machines, SMACH, the first GRIP, drawings.

`btcpp/`: BehaviorTree.CPP's XML. `pytrees/`: py_trees' objects and XML. `smach/` and `smach_export/`: SMACH in and
out. `first_grip/`: the first GRIP's projects. `standalone/`: a
task as one Python file. `draw/`: svg, dot, mermaid. All importers give an `imported.Imported`, whose issues are
`base.issue.Issue`s.
"""
