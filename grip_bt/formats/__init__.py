"""What comes from elsewhere and goes there: other tools' trees and machines, SMACH, the first GRIP, drawings."""
