/** The named messages of a running server, live: look, add, change, delete, and keep where the robot is. */
import { type JSX, lazy, Suspense, useEffect, useMemo, useState } from "react";
import { posesOf, standsOf } from "../../model/parts";
import { server } from "../../protocol/client";
import type { LiveMessage, SetupView, StoredMessage } from "../../protocol/generated";
import { askChoice } from "../../store/ask";
import { loadGeometry, lookAtMessages, messageOf, useLive, useRobot, wished } from "../../store/live";
import { openSetup, refreshed, useSetup } from "../../store/setup";
import { ValueShown } from "../SidePanel";
import { MeasureForm } from "./TryForm";

const PERIOD = 1500;
const BLANK: Record<string, string> = {
  joint_states: "joint_1: 0.0\n",
  poses: "reference_frame: world\nposition: {x: 0.4, y: 0.0, z: 0.2}\norientation: {r: 0.0, p: 0.0, y: 0.0}\n",
};

/** What is shown beside the list. */
interface Shown {
  readonly store: string;
  /** Empty for a new one. */
  readonly name: string;
}

export function MessagesPage(): JSX.Element {
  const found = useLive((s) => s.messages);
  const error = useLive((s) => s.error);
  const said = useLive((s) => s.said);
  const [shown, setShown] = useState<Shown | null>(null);
  useEffect(() => {
    let left = false;
    let timer: ReturnType<typeof setTimeout> | undefined;
    async function look(): Promise<void> {
      if (document.visibilityState === "visible") await lookAtMessages();
      if (!left) timer = setTimeout(() => void look(), PERIOD);
    }
    void look();
    return () => {
      left = true;
      clearTimeout(timer);
    };
  }, []);
  const entry = shown?.name ? found?.messages.find((each) => each.store === shown.store && each.name === shown.name) : undefined;
  return (
    <section className="live" aria-labelledby="messages-title">
      <div className="live-list">
        <h3 id="messages-title">Messages of the running server</h3>
        <p role="status" className={found?.served ? "phase-success" : "hint"}>
          {found === null
            ? "Looking for a server ..."
            : found.served
              ? `✓ ${found.messages.length} by name under /grip/messages, ROS domain ${found.domain}${found.ours ? "; served by this editor" : ""}`
              : `No server: ${found.error}`}
        </p>
        <p className="live-bar">
          {found !== null && !found.served && <button onClick={() => void wished(() => server.messageDeed({ do: "serve", store: "", name: "" }))}>Serve the project's messages</button>}
          {found?.served && (
            <>
              <button onClick={() => setShown({ store: "poses", name: "" })}>Add</button>
              <button title="Kept across restarts of the server" onClick={() => void wished(() => server.messageDeed({ do: "save", store: "", name: "" }))}>
                Keep all
              </button>
              <button title="Empty all stores and read the project's files again" onClick={() => void reset()}>
                Reset
              </button>
              {found.ours && <button onClick={() => void wished(() => server.messageDeed({ do: "end", store: "", name: "" }))}>Stop serving</button>}
            </>
          )}
        </p>
        {error && (
          <p className="fault" role="alert">
            {error}
          </p>
        )}
        {said && <output aria-label="Result">{said}</output>}
        {found?.served &&
          found.stores
            .filter((store) => store.queued > 0 || found.messages.some((each) => each.store === store.name))
            .map((store) => (
              <div key={store.name}>
                <h4>
                  {store.name} {store.queued > 0 && <span className="hint">{store.queued} in its queue</span>}
                </h4>
                <ul className="plain" aria-label={`Messages in ${store.name}`}>
                  {found.messages
                    .filter((each) => each.store === store.name)
                    .map((each) => (
                      <li key={each.name} className="live-entry">
                        <button className="setup-file" aria-pressed={shown?.store === each.store && shown.name === each.name} onClick={() => setShown({ store: each.store, name: each.name })}>
                          {each.name}
                          <code>
                            {new Date(each.time * 1000).toLocaleTimeString()} {each.provenance}
                          </code>
                        </button>
                        <button aria-label={`Delete ${each.name} from ${each.store}`} onClick={() => void remove(each)}>
                          Delete
                        </button>
                      </li>
                    ))}
                </ul>
              </div>
            ))}
        <MeasureForm />
      </div>
      {shown && found?.served && (shown.name === "" || entry) ? (
        <Message key={`${shown.store}/${shown.name}/${entry?.revision ?? 0}`} shown={shown} type={entry?.type ?? ""} open={setShown} />
      ) : (
        <p className="hint live-detail">{found?.served ? "Choose a message, or add one." : "Tasks that say message_server: true in grip.yaml ask this server; others read the project's files."}</p>
      )}
    </section>
  );
}

const RobotPreview = lazy(() => import("../robot/RobotPreview"));

/** What a file of named poses or joint states means, with the robot: where they are, and where the robot is now put among them. */
export function NamedInSpace({ view }: { view: SetupView }): JSX.Element {
  const robot = useRobot((s) => s.view);
  const dirty = useSetup((s) => s.saved !== s.view?.text);
  const error = useLive((s) => s.error);
  const said = useLive((s) => s.said);
  const doc = useSetup((s) => s.files.find((file) => file.path === view.path)?.doc);
  const places = useMemo(() => (view.kind === "poses" ? posesOf(view.data) : []), [view]);
  const stands = useMemo(() => (view.kind === "joint_states" ? standsOf(view.data) : undefined), [view]);
  const many = stands === undefined ? places.length : Object.keys(stands).length;
  useEffect(() => void loadGeometry(), []);
  return (
    <>
      <p className="hint">
        {doc} Tasks speak of them by name. {view.kind === "trajectories" ? "Joint states are named first." : "A name and its numbers are added below, or measured where the robot is."}
      </p>
      {many > 0 && !robot?.error && (
        <div className="named-space">
          <Suspense fallback={<p className="hint loading">Loading the 3D view ...</p>}>
            <RobotPreview view={robot} places={places} {...(stands ? { stands } : {})} />
          </Suspense>
        </div>
      )}
      {view.kind !== "trajectories" && (
        <details>
          <summary>Save where the robot is now</summary>
          {dirty ? <p className="hint">What is typed here has to be saved first.</p> : <MeasureForm what={view.kind === "poses" ? "pose" : "joints"} done={() => void refreshed().then(() => openSetup(view.path))} />}
          {error && <p className="fault" role="alert">{error}</p>}
          {said && <output aria-label="Result">{said}</output>}
        </details>
      )}
    </>
  );
}

async function reset(): Promise<void> {
  const options = [{ value: "yes", label: "Reset", detail: "Messages that only the server has are lost" }];
  if ((await askChoice({ title: "Reset the server", label: "Empty all stores and read the project's files again", options })) === "yes")
    await wished(() => server.messageDeed({ do: "reset", store: "", name: "" }));
}

async function remove(entry: StoredMessage): Promise<void> {
  const options = [{ value: "yes", label: `Delete ${entry.name}` }];
  if ((await askChoice({ title: `Delete ${entry.name}`, label: `It is taken out of ${entry.store} of the running server`, options })) === "yes")
    await wished(() => server.messageDeed({ do: "delete", store: entry.store, name: entry.name }));
}

function Message({ shown, type, open }: { shown: Shown; type: string; open: (shown: Shown) => void }): JSX.Element {
  const fresh = shown.name === "";
  const stores = useLive((s) => s.messages?.stores ?? []);
  const [message, setMessage] = useState<LiveMessage | null>(null);
  const [store, setStore] = useState(shown.store);
  const [name, setName] = useState(shown.name);
  const [ros, setRos] = useState(type);
  const [text, setText] = useState(fresh ? (BLANK[shown.store] ?? "") : "");
  useEffect(() => {
    if (fresh) return;
    let left = false;
    server.liveMessage(shown.store, shown.name).then(
      (found) => {
        if (left) return;
        setMessage(found);
        setText(found.text);
      },
      (error: unknown) => left || setMessage({ value: null, text: "", error: messageOf(error) }),
    );
    return () => {
      left = true;
    };
  }, [fresh, shown.store, shown.name]);
  const known = stores.find((each) => each.name === store)?.type ?? "";
  async function put(): Promise<void> {
    if (await wished(() => server.putMessage({ store, name: name.trim(), type: known || ros, text }))) open({ store, name: name.trim() });
  }
  return (
    <div className="live-detail" role="group" aria-label={fresh ? "New message" : `Message ${shown.name}`}>
      <h4>{fresh ? "A new message" : shown.name}</h4>
      {message?.error && <p className="fault">{message.error}</p>}
      {message?.value && <ValueShown view={message.value} name={shown.name} />}
      {fresh && (
        <>
          <div className="form-field">
            <label htmlFor="message-store">Store</label>
            <input
              id="message-store"
              type="text"
              list="message-stores"
              value={store}
              onChange={(event) => {
                setStore(event.target.value);
                if (event.target.value in BLANK) setText(BLANK[event.target.value] ?? "");
              }}
            />
            <datalist id="message-stores">
              {stores.map((each) => (
                <option key={each.name} value={each.name} />
              ))}
            </datalist>
          </div>
          <div className="form-field">
            <label htmlFor="message-name">Name</label>
            <input id="message-name" type="text" value={name} onChange={(event) => setName(event.target.value)} />
          </div>
          <div className="form-field">
            <label htmlFor="message-type">ROS type</label>
            <input id="message-type" type="text" value={known || ros} readOnly={known !== ""} placeholder="std_msgs/msg/String" onChange={(event) => setRos(event.target.value)} />
          </div>
        </>
      )}
      {fresh || message?.text ? (
        <>
          <label htmlFor="message-text">Value (YAML)</label>
          <textarea id="message-text" rows={10} spellCheck={false} value={text} onChange={(event) => setText(event.target.value)} />
          <p>
            <button className="main" disabled={name.trim() === "" || text.trim() === "" || (!fresh && text === message?.text)} onClick={() => void put()}>
              {fresh ? "Add it" : "Change it"}
            </button>
          </p>
        </>
      ) : (
        message?.value && <p className="hint">Read-only: a value of this size or type cannot be edited as text.</p>
      )}
    </div>
  );
}
