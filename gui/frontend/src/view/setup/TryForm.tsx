/** Try a component with a sample: a recorded value, or one that is typed; its answer is shown field by field. */
import { type JSX, useEffect, useState } from "react";

import { server } from "../../protocol/client";
import type { ComponentForm, RequestPort, TryView } from "../../protocol/generated";
import { messageOf } from "../../store/live";
import { ValueShown } from "../ValuePreview";

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
      (error: unknown) => left || setForm({ name: "", inputs: [], trouble: messageOf(error) }),
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
      setView({ outcome: "", fields: [], milliseconds: 0, started: "", trouble: messageOf(error) });
    } finally {
      setBusy(false);
    }
  }
  if (form === null) return <p className="hint">Looking for recorded samples ...</p>;
  return (
    <fieldset aria-label="Try it with a sample">
      <legend>Try it with a sample</legend>
      {form.trouble && <p className="fault">{form.trouble}</p>}
      {form.inputs.map((port) => (
        <Input key={port.name} port={port} choice={given[port.name] ?? NOTHING} set={(choice) => setGiven({ ...given, [port.name]: choice })} />
      ))}
      {form.trouble === "" && (
        <p>
          <button className="main" disabled={busy} onClick={() => void call()}>
            {busy ? "Calling it ..." : "Call it once"}
          </button>{" "}
          <span className="hint">It is started, called and stopped; what isn't given stays empty.</span>
        </p>
      )}
      <div role="status" aria-label="Its answer">
        {view?.trouble && <pre className="fault">{view.trouble}</pre>}
        {view && view.trouble === "" && (
          <>
            <p>
              Outcome <strong>{view.outcome}</strong> after {view.milliseconds.toFixed(1)} ms <span className="hint">{view.started}</span>
            </p>
            <dl className="try-fields">
              {view.fields.map((field) => (
                <div key={field.name}>
                  <dt>
                    {field.name} <code>{field.value.type}</code>
                  </dt>
                  <dd>
                    <ValueShown view={field.value} name={field.name} />
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
