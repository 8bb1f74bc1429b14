"""A journal of the first version, in which each event was a row of its own, without events."""

OLD = """
CREATE TABLE runs(
  id TEXT PRIMARY KEY, task_name TEXT, task_path TEXT, task_text TEXT, target TEXT, seed INTEGER,
  started REAL, ended REAL, status TEXT, outcome TEXT);
CREATE TABLE events(
  run TEXT, seq INTEGER, t REAL, wall REAL, path TEXT, event TEXT, outcome TEXT, code TEXT, data TEXT,
  PRIMARY KEY(run, seq)) WITHOUT ROWID;
INSERT INTO runs VALUES('old', 'pick', '', '', 'bt', 3, 1.0, 2.0, 'success', 'success');
"""
