"""The editor's server: shows a project's tasks in a browser, runs each in a process of its own, live and in replay."""
