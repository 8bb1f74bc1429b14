/** Tasks from elsewhere: a file is kept in the project, read without executing it, and becomes task files. */
import { type ChangeEvent, type JSX, useEffect, useState } from "react";

import { server } from "../../protocol/client";
import type { ImportView, ImportRequest, InterfaceView, InterfaceRequest } from "../../protocol/generated";
import { chooseTask } from "../../store/desk";
import { usePage } from "../../store/page";
import FileBrowser from "../start/FileBrowser";
import { openSetup, refreshed, report } from "../../store/setup";

/** Source, what it is called, how its files end, and whether its code can be run to see what it builds. */
const SOURCES: readonly [ImportRequest["source"], string, string, boolean][] = [
  ["smach", "SMACH state machine (.py)", ".py", true],
  ["btcpp", "BehaviorTree.CPP 4 (.xml)", ".xml", false],
  ["pytrees", "py_trees (.xml, or .py that builds a tree)", ".xml", true],
  ["grip", "the first GRIP (a folder or .yaml)", "", false],
];
const ENDS: Record<ImportRequest["source"], RegExp> = { smach: /\.py$/, btcpp: /\.xml$/, pytrees: /\.(xml|py)$/, grip: /\.yaml$/ };

export function ImportForm(): JSX.Element {
  const [source, setSource] = useState<ImportRequest["source"]>("smach");
  const [view, setView] = useState<ImportView | null>(null);
  const [said, setSaid] = useState("");
  const [execute, setExecute] = useState(false);
  const [path, setPath] = useState("");
  const runs = SOURCES.find(([name]) => name === source)?.[3] ?? false;
  const suffix = SOURCES.find(([name]) => name === source)?.[2] ?? "";
  async function take(event: ChangeEvent<HTMLInputElement>): Promise<void> {
    const file = event.target.files?.[0];
    event.target.value = "";
    if (file) await bring({ name: file.name, text: await file.text(), path: "" });
  }
  async function bring(what: Pick<ImportRequest, "name" | "text" | "path">): Promise<void> {
    setView(null);
    setSaid(execute && runs ? "Running it, to see what it builds ..." : "Reading it ...");
    try {
      setView(await server.setupImport({ ...what, source, execute: execute && runs }));
      setSaid("");
      await refreshed();
    } catch (error) {
      setSaid(error instanceof Error ? error.message : String(error));
    }
  }
  return (
    <section className="setup-interface" aria-labelledby="import-title">
      <h3 id="import-title">Import a task</h3>
      <p className="hint">A file that is sent is copied to legacy/. It is read; code in it runs only if you say so below.</p>
      <div className="form-field">
        <label htmlFor="import-source">What it is</label>
        <select id="import-source" value={source} onChange={(event) => (setSource(event.target.value as ImportRequest["source"]), setPath(""))}>
          {SOURCES.map(([name, label]) => (
            <option key={name} value={name}>
              {label}
            </option>
          ))}
        </select>
      </div>
      {runs && (
        <fieldset className="import-trust">
          <legend>May its code be run?</legend>
          <label>
            <input type="radio" name="import-trust" checked={!execute} onChange={() => setExecute(false)} /> No: read it only. What only running it would tell is left out, and said.
          </label>
          <label>
            <input type="radio" name="import-trust" checked={execute} onChange={() => setExecute(true)} /> Yes, I trust it: run it in a process of its own, to see what it builds.
          </label>
        </fieldset>
      )}
      {suffix && (
        <div className="form-field">
          <label htmlFor="import-file">File</label>
          <input id="import-file" type="file" accept={suffix} onChange={(event) => void take(event)} />
        </div>
      )}
      <details open={suffix === "" || undefined}>
        <summary>Or where it lies, with the files beside it</summary>
        <FileBrowser key={source} fits={(entry) => (entry.kind === "file" ? ENDS[source].test(entry.name) : source !== "pytrees")} chosen={path} choose={setPath} />
        <button className="main" disabled={path === ""} onClick={() => void bring({ name: "", text: "", path })}>
          Import {path.split("/").at(-1)}
        </button>
      </details>
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

const CONTRACT = "sensor_msgs/PointCloud2 input\n---\nint32 outcome\ngeometry_msgs/PoseStamped[] returned_object\n";
const EMPTY: InterfaceRequest = { text: "", type: "", file: "", outcomes: "", failures: [], name: "", server: "", create: false };
const PAUSE = 400;

export function InterfaceForm({ done }: { done: () => void }): JSX.Element {
  const [request, setWish] = useState<InterfaceRequest>(EMPTY);
  const [view, setView] = useState<InterfaceView | null>(null);
  const [refusal, setRefusal] = useState("");
  const [busy, setBusy] = useState(false);
  const [lies, setLies] = useState(false);
  useEffect(() => {
    if (!request.type.trim() && request.file === "") {
      setView(null);
      setRefusal(request.text.trim() ? "Enter its name above, such as my_interfaces/srv/PlanGrasp, or my_interfaces/action/PlanGrasp." : "");
      return;
    }
    let left = false;
    const timer = setTimeout(() => {
      server.setupInterface(request).then(
        (found) => {
          if (left) return;
          setView(found);
          setRefusal("");
        },
        (error: unknown) => {
          if (left) return;
          setView(null);
          setRefusal(error instanceof Error ? error.message : String(error));
        },
      );
    }, PAUSE);
    return () => {
      left = true;
      clearTimeout(timer);
    };
  }, [request]);
  const change = (part: Partial<InterfaceRequest>): void => setWish({ ...request, ...part });
  async function create(): Promise<void> {
    setBusy(true);
    try {
      const made = await server.setupInterface({ ...request, create: true });
      await refreshed();
      await openSetup(made.path);
      done();
    } catch (error) {
      report(error);
    } finally {
      setBusy(false);
    }
  }
  return (
    <section className="setup-interface" aria-labelledby="interface-title">
      <h3 id="interface-title">A new component</h3>
      <div className="segments" role="group" aria-label="Where its interface is">
        <button aria-pressed={!lies} onClick={() => (setLies(false), setWish(EMPTY))}>Pasted, or installed</button>
        <button aria-pressed={lies} onClick={() => (setLies(true), setWish(EMPTY))}>In its repository ...</button>
      </div>
      {lies ? (
        <>
          <p className="hint">Choose its .srv or .action. GRIP looks in the repository for what serves it; nothing of it is run before you try it.</p>
          <FileBrowser fits={(entry) => entry.kind === "file" && /\.(srv|action)$/.test(entry.name)} chosen={request.file} choose={(file) => setWish({ ...EMPTY, file })} />
          {view && (
            <p role="status">
              <code>{view.type}</code>
              {view.script ? <>, served as <code>{view.server}</code> by <code>{view.script}</code>, which is started with the component</> : <>; nothing in its repository serves it: say below how it is called, and how it starts once it is there</>}
            </p>
          )}
        </>
      ) : (
        <>
      <Text label="Interface" value={request.type} hint="such as my_interfaces/srv/PlanGrasp, or an installed type" set={(type) => change({ type })} />
      <div className="form-field">
        <label htmlFor="interface-text">Its .srv or .action</label>
        <textarea id="interface-text" rows={5} value={request.text} placeholder="empty for an installed type" onChange={(event) => change({ text: event.target.value })} />
        <button onClick={() => change({ text: CONTRACT, type: request.type || "my_interfaces/srv/PlanGrasp" })}>Template</button>
      </div>
        </>
      )}
      <Text label="Outcomes" value={request.outcomes} hint={view?.suggestion ? `such as ${view.suggestion}` : "names of 0, 1 ...: one,none"} set={(outcomes) => change({ outcomes })} />
      <Text label="Failures" value={request.failures.join(",")} hint="those that mean failure: none" set={(text) => change({ failures: text.split(",").map((each) => each.trim()).filter(Boolean) })} />
      <Text label="Component" value={request.name} hint="its name; from the server's by default" set={(name) => change({ name })} />
      <Text label="Server" value={request.server} hint={view?.server || "such as /plan_grasp"} set={(text) => change({ server: text })} />
      {refusal && (
        <p className="fault" role="alert">
          {refusal}
        </p>
      )}
      {view && (
        <>
          <table aria-label="Fields of the interface">
            <tbody>
              {view.fields.map((field) => (
                <tr key={`${field.side}/${field.name}`}>
                  <td>{field.side}</td>
                  <th scope="row">{field.name}</th>
                  <td>
                    <code>{field.type}</code>
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
          {view.problems.length > 0 ? (
            <ul className="plain fault" aria-label="Problems">
              {view.problems.map((problem) => (
                <li key={problem}>{problem}</li>
              ))}
            </ul>
          ) : (
            <p className="phase-success">✓ It keeps the contract.</p>
          )}
        </>
      )}
      <p>
        <button className="main" disabled={busy || view === null || view.problems.length > 0} onClick={() => void create()}>
          {busy ? "Generating ..." : "Generate"}
        </button>{" "}
        <button onClick={done}>Cancel</button>
      </p>
    </section>
  );
}

function Text({ label, value, hint, set }: { label: string; value: string; hint: string; set: (text: string) => void }): JSX.Element {
  const id = `interface-${label.toLowerCase()}`;
  return (
    <div className="form-field">
      <label htmlFor={id}>{label}</label>
      <input id={id} type="text" value={value} placeholder={hint} onChange={(event) => set(event.target.value)} />
    </div>
  );
}
