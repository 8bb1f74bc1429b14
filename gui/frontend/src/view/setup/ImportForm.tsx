/** Tasks from elsewhere: a file is kept in the project, read without executing it, and becomes task files. */
import { type ChangeEvent, type JSX, useState } from "react";

import { server } from "../../protocol/client";
import type { ImportView, ImportWish } from "../../protocol/generated";
import { chooseTask } from "../../store/desk";
import { usePage } from "../../store/page";
import { refreshed } from "../../store/setup";

const SOURCES: readonly [ImportWish["source"], string, string][] = [
  ["smach", "SMACH state machine (.py)", ".py"],
  ["btcpp", "BehaviorTree.CPP 4 (.xml)", ".xml"],
  ["pytrees", "py_trees (.xml)", ".xml"],
];

export function ImportForm(): JSX.Element {
  const [source, setSource] = useState<ImportWish["source"]>("smach");
  const [view, setView] = useState<ImportView | null>(null);
  const [said, setSaid] = useState("");
  const suffix = SOURCES.find(([name]) => name === source)?.[2] ?? "";
  async function take(event: ChangeEvent<HTMLInputElement>): Promise<void> {
    const file = event.target.files?.[0];
    event.target.value = "";
    if (!file) return;
    setView(null);
    setSaid("Reading it ...");
    try {
      setView(await server.setupImport({ source, name: file.name, text: await file.text() }));
      setSaid("");
      await refreshed();
    } catch (error) {
      setSaid(error instanceof Error ? error.message : String(error));
    }
  }
  return (
    <section className="setup-interface" aria-labelledby="import-title">
      <h3 id="import-title">A task from elsewhere</h3>
      <p className="hint">The file is kept in legacy/ and read. Nothing of it is executed.</p>
      <div className="form-field">
        <label htmlFor="import-source">What it is</label>
        <select id="import-source" value={source} onChange={(event) => setSource(event.target.value as ImportWish["source"])}>
          {SOURCES.map(([name, label]) => (
            <option key={name} value={name}>
              {label}
            </option>
          ))}
        </select>
      </div>
      <div className="form-field">
        <label htmlFor="import-file">File</label>
        <input id="import-file" type="file" accept={suffix} onChange={(event) => void take(event)} />
      </div>
      <p role="status">{said}</p>
      {view && (
        <>
          <ul className="plain" aria-label="Imported tasks">
            {view.tasks.map((task) => (
              <li key={task}>
                <button
                  onClick={() => {
                    usePage.getState().setRoom("task");
                    void chooseTask(task);
                  }}
                >
                  Open {task}
                </button>
              </li>
            ))}
          </ul>
          <pre className="reason" tabIndex={0} aria-label="What the import said">
            {view.probe.output}
          </pre>
        </>
      )}
    </section>
  );
}
