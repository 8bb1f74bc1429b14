"""Runs from the page: their processes, who controls and watches them, their events live and from the journal."""
