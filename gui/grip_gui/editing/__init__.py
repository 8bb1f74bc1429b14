"""Task files while they are edited: the server owns them, and every page, form and text pane changes them here."""
