/** Try a component with a sample: a recorded value, or one that is typed; its answer is shown field by field. */
import { type JSX, useEffect, useState } from "react";
import { server } from "../../protocol/client";
import type { ComponentForm, MeasureRequest, RequestPort, TryView } from "../../protocol/generated";
import { valueAt } from "../../model/shapes";
import { messageOf, useLive, wished } from "../../store/live";
import { useRun } from "../../store/run";
import { ValueShown } from "../SidePanel";

interface Choice {
  readonly sample: string;
  readonly text: string;
}

const NOTHING: Choice = { sample: "", text: "" };

export function TryForm({ path }: { path: string }): JSX.Element {
  const [form, setForm] = useState<ComponentForm | null>(null);
  const [given, setGiven] = useState<Readonly<Record<string, Choice>>>({});
  const [view, setView] = useState<TryView | null>(null);
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    let left = false;
    server.componentForm(path).then(
      (found) => left || setForm(found),
      (error: unknown) => left || setForm({ name: "", inputs: [], error: messageOf(error) }),
    );
    return () => {
      left = true;
    };
  }, [path]);
  async function call(): Promise<void> {
    setBusy(true);
    setView(null);
    try {
      setView(await server.callComponent({ path, given: Object.entries(given).map(([port, choice]) => ({ port, ...choice })) }));
    } catch (error) {
      setView({ outcome: "", fields: {}, milliseconds: 0, started: "", error: messageOf(error) });
    } finally {
      setBusy(false);
    }
  }
  if (form === null) return <p className="hint">Looking for recorded samples ...</p>;
  return (
    <fieldset aria-label="Try it with a sample">
      <legend>Try it with a sample</legend>
      {form.error && <p className="fault">{form.error}</p>}
      {form.inputs.map((port) => (
        <Input key={port.name} port={port} choice={given[port.name] ?? NOTHING} set={(choice) => setGiven({ ...given, [port.name]: choice })} />
      ))}
      {form.error === "" && (
        <p>
          <button className="main" disabled={busy} onClick={() => void call()}>
            {busy ? "Calling it ..." : "Call it once"}
          </button>{" "}
          <span className="hint">Starts the component, calls it once and stops it; inputs that are not given stay empty.</span>
        </p>
      )}
      <div role="status" aria-label="Its answer">
        {view?.error && <pre className="fault">{view.error}</pre>}
        {view && view.error === "" && (
          <>
            <p>
              Outcome <strong>{view.outcome || "none: no rule holds"}</strong> after {view.milliseconds.toFixed(1)} ms <span className="hint">{view.started}</span>
            </p>
            <dl className="try-fields">
              {Object.entries(view.fields).map(([name, value]) => (
                <div key={name}>
                  <dt>
                    {name} <code>{value.type}</code>
                  </dt>
                  <dd>
                    <ValueShown view={value} name={name} />
                  </dd>
                </div>
              ))}
            </dl>
          </>
        )}
      </div>
    </fieldset>
  );
}

function Input({ port, choice, set }: { port: RequestPort; choice: Choice; set: (choice: Choice) => void }): JSX.Element {
  const id = `try-${port.name}`;
  return (
    <>
      <div className="form-field">
        <label htmlFor={id}>
          {port.name} <code>{port.type}</code>
        </label>
        <select id={id} value={choice.sample} onChange={(event) => set({ ...choice, sample: event.target.value })}>
          <option value="">typed below{port.samples.length === 0 ? " (no recorded value of this type)" : ""}</option>
          {port.samples.map((sample) => (
            <option key={sample.source} value={sample.source}>
              {sample.title}
            </option>
          ))}
        </select>
        {port.doc && <p className="hint">{port.doc}</p>}
      </div>
      {choice.sample === "" && (
        <div className="form-field">
          <label htmlFor={`${id}-text`}>{port.name} as YAML</label>
          <textarea id={`${id}-text`} rows={2} spellCheck={false} value={choice.text} placeholder="a number, a list, or the message's fields" onChange={(event) => set({ ...choice, text: event.target.value })} />
        </div>
      )}
    </>
  );
}

const ROBOTS: readonly [MeasureRequest["robot"], string][] = [
  ["run", "the run under way"],
  ["ros", "the real robot (ROS)"],
  ["sim", "a fresh simulation"],
  ["fake", "the fake"],
];

/** @param what of an arm, chosen first. @param done told when something was written. */
export function MeasureForm({ what: first = "joints", done }: { what?: MeasureRequest["what"]; done?: () => void }): JSX.Element {
  const [file, setFile] = useState<unknown>(null);
  const [error, setError] = useState("");
  const under_way = useRun((s) => s.session !== null && s.session.run !== null && s.session.state !== "ended");
  const [robot, setRobot] = useState<MeasureRequest["robot"] | "">("");
  const [part, setPart] = useState("");
  const [what, setWhat] = useState<MeasureRequest["what"]>(first);
  const [name, setName] = useState("");
  const [serve, setServe] = useState(true);
  const [busy, setBusy] = useState(false);
  const served = useLive((s) => s.messages?.served === true);
  useEffect(() => {
    let left = false;
    server.setupFile("grip.yaml").then(
      (view) => left || setFile(view.data),
      (error: unknown) => left || setError(messageOf(error)),
    );
    return () => {
      left = true;
    };
  }, []);
  const [arms, hands] = ["arms", "hands"].map((what) => Object.keys((valueAt(file, [what]) as object | null | undefined) ?? {})) as [string[], string[]];
  const all = [...arms, ...hands];
  const whose = robot || (under_way ? "run" : "sim");
  const chosen = part || all[0] || "";
  const hand = hands.includes(chosen);
  async function measure(): Promise<void> {
    setBusy(true);
    await wished(() => server.measure({ robot: whose, part: chosen, what: hand ? "joints" : what, name: name.trim(), serve: served && serve }));
    setBusy(false);
    done?.();
  }
  return (
    <fieldset aria-label="Where the robot is">
      <legend>Save the robot's current position</legend>
      {(file !== null || error) && all.length === 0 ? (
        <p className="hint">{error || "grip.yaml names no arm and no hand yet."}</p>
      ) : (
        <>
          <div className="form-field">
            <label htmlFor="measure-robot">Measured at</label>
            <select id="measure-robot" value={whose} onChange={(event) => setRobot(event.target.value as MeasureRequest["robot"])}>
              {ROBOTS.filter(([each]) => each !== "run" || under_way).map(([each, label]) => (
                <option key={each} value={each}>
                  {label}
                </option>
              ))}
            </select>
          </div>
          <div className="form-field">
            <label htmlFor="measure-part">Arm or hand</label>
            <select id="measure-part" value={chosen} onChange={(event) => setPart(event.target.value)}>
              {all.map((each) => (
                <option key={each}>{each}</option>
              ))}
            </select>
          </div>
          <div className="form-field">
            <label htmlFor="measure-what">What</label>
            <select id="measure-what" value={hand ? "joints" : what} disabled={hand} onChange={(event) => setWhat(event.target.value as MeasureRequest["what"])}>
              <option value="joints">its joints</option>
              <option value="pose">the pose of its grasp frame</option>
            </select>
          </div>
          <div className="form-field">
            <label htmlFor="measure-name">Name</label>
            <input id="measure-name" type="text" value={name} placeholder="above_table" onChange={(event) => setName(event.target.value)} />
          </div>
          {served && (
            <div className="form-field">
              <label htmlFor="measure-serve">Also to the server</label>
              <input id="measure-serve" type="checkbox" checked={serve} onChange={(event) => setServe(event.target.checked)} />
            </div>
          )}
          <button disabled={busy || name.trim() === ""} onClick={() => void measure()}>
            {busy ? "Measuring ..." : "Measure and save"}
          </button>
        </>
      )}
    </fieldset>
  );
}
