"""One module per family of rules; each function takes the survey of a task and notes what it finds."""
