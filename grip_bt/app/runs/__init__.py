"""Running a task of a project, recording it, resuming it, and showing the record again."""
