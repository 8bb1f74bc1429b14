/** Software of others as a node: paste or name its interface, see which field is wrong, name its outcomes, generate. */
import { type JSX, useEffect, useState } from "react";

import { server } from "../../protocol/client";
import type { InterfaceView, InterfaceWish } from "../../protocol/generated";
import { openSetup, refreshed, trouble } from "../../store/setup";

const CONTRACT = "sensor_msgs/PointCloud2 input\n---\nint32 outcome\ngeometry_msgs/PoseStamped[] returned_object\n";
const EMPTY: InterfaceWish = { text: "", type: "", outcomes: "", failures: [], name: "", server: "", create: false };
const PAUSE = 400;

export function InterfaceForm({ done }: { done: () => void }): JSX.Element {
  const [wish, setWish] = useState<InterfaceWish>(EMPTY);
  const [view, setView] = useState<InterfaceView | null>(null);
  const [refusal, setRefusal] = useState("");
  const [busy, setBusy] = useState(false);
  useEffect(() => {
    if (!wish.type.trim()) {
      setView(null);
      setRefusal(wish.text.trim() ? "Say above what it is called, such as my_interfaces/srv/PlanGrasp, or my_interfaces/action/PlanGrasp." : "");
      return;
    }
    let left = false;
    const timer = setTimeout(() => {
      server.setupInterface(wish).then(
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
  }, [wish]);
  const change = (part: Partial<InterfaceWish>): void => setWish({ ...wish, ...part });
  async function create(): Promise<void> {
    setBusy(true);
    try {
      const made = await server.setupInterface({ ...wish, create: true });
      await refreshed();
      await openSetup(made.path);
      done();
    } catch (error) {
      trouble(error);
    } finally {
      setBusy(false);
    }
  }
  return (
    <section className="setup-interface" aria-labelledby="interface-title">
      <h3 id="interface-title">A new component</h3>
      <Text label="Interface" value={wish.type} hint="such as my_interfaces/srv/PlanGrasp, or an installed type" set={(type) => change({ type })} />
      <div className="form-field">
        <label htmlFor="interface-text">Its .srv or .action</label>
        <textarea id="interface-text" rows={5} value={wish.text} placeholder="empty for an installed type" onChange={(event) => change({ text: event.target.value })} />
        <button onClick={() => change({ text: CONTRACT, type: wish.type || "my_interfaces/srv/PlanGrasp" })}>Template</button>
      </div>
      <Text label="Outcomes" value={wish.outcomes} hint={view?.suggestion ? `such as ${view.suggestion}` : "names of 0, 1 ...: one,none"} set={(outcomes) => change({ outcomes })} />
      <Text label="Failures" value={wish.failures.join(",")} hint="those that mean failure: none" set={(text) => change({ failures: text.split(",").map((each) => each.trim()).filter(Boolean) })} />
      <Text label="Component" value={wish.name} hint="its name; from the server's by default" set={(name) => change({ name })} />
      <Text label="Server" value={wish.server} hint="such as /plan_grasp" set={(text) => change({ server: text })} />
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
            <ul className="plain fault" aria-label="What is wrong">
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
