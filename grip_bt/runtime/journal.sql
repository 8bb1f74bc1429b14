-- Tables of a journal; their version is `VERSION` in journal_rows.py.
CREATE TABLE IF NOT EXISTS runs(
  id TEXT PRIMARY KEY, task_name TEXT, task_path TEXT, task_text TEXT, target TEXT, seed INTEGER,
  started REAL, ended REAL, status TEXT, outcome TEXT);
CREATE TABLE IF NOT EXISTS names(
  run TEXT, id INTEGER, path TEXT, event TEXT, outcome TEXT, code TEXT,
  PRIMARY KEY(run, id)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS blocks(
  run TEXT, first INTEGER, last INTEGER, content BLOB, data TEXT, sum INTEGER,
  PRIMARY KEY(run, first));
CREATE TABLE IF NOT EXISTS processes(
  run TEXT PRIMARY KEY, pid INTEGER, since INTEGER, host TEXT);
CREATE TABLE IF NOT EXISTS big_values(
  hash TEXT PRIMARY KEY, type TEXT, size INTEGER, content BLOB);
CREATE TABLE IF NOT EXISTS uses(
  run TEXT, hash TEXT,
  PRIMARY KEY(run, hash)) WITHOUT ROWID;
