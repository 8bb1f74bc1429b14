"""What a page shows of tasks and values: documents as nodes, values as text, rows and pictures."""
