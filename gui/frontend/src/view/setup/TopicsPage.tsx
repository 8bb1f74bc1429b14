/** The topics of the running ROS graph: receive one message and look at it, or make a sensor of it. */
import { type JSX, useEffect, useState } from "react";

import { type CameraTopics, cameraOf } from "../../model/topics";
import { server } from "../../protocol/client";
import type { ReceivedView, TopicView } from "../../protocol/generated";
import { lookAtTopics, messageOf, useAsCamera, useAsSensor, useLive } from "../../store/live";
import { ValueShown } from "../ValuePreview";

const PERIOD = 3000;
const NONE: readonly TopicView[] = [];

export function TopicsPage({ done }: { done: () => void }): JSX.Element {
  const found = useLive((s) => s.topics);
  const looking = useLive((s) => s.looking);
  const [name, setName] = useState("");
  const [filter, setFilter] = useState("");
  useEffect(() => {
    void lookAtTopics();
    const timer = setInterval(() => document.visibilityState === "visible" && void lookAtTopics(), PERIOD);
    return () => clearInterval(timer);
  }, []);
  const shown = (found?.topics ?? []).filter((topic) => `${topic.name} ${topic.type}`.toLowerCase().includes(filter.toLowerCase()));
  const chosen = found?.topics.find((topic) => topic.name === name);
  return (
    <section className="live" aria-labelledby="topics-title">
      <div className="live-list">
        <h3 id="topics-title">Published topics</h3>
        {found?.error ? (
          <p className="fault" role="alert">
            {found.error}
          </p>
        ) : (
          <p className="hint" role="status">
            {found === null ? "Looking at the ROS graph ..." : `${found.topics.length} in ROS domain ${found.domain}; looked at every 3 s`}
          </p>
        )}
        <p className="live-bar">
          <input type="text" aria-label="Filter topics" placeholder="Filter by name or type" value={filter} onChange={(event) => setFilter(event.target.value)} />
          <button disabled={looking} onClick={() => void lookAtTopics()}>
            Look again
          </button>
        </p>
        {found !== null && found.error === "" && found.topics.length === 0 && (
          <p className="hint">No topics are published. Start the sensor's driver in a shell with the same ROS_DOMAIN_ID, or with `grip launch`.</p>
        )}
        <ul className="plain" aria-label="Topics">
          {shown.map((topic) => (
            <li key={topic.name}>
              <button className="setup-file" aria-pressed={topic.name === name} onClick={() => setName(topic.name)}>
                {topic.name}
                <code>{topic.type}</code>
              </button>
            </li>
          ))}
        </ul>
      </div>
      {chosen ? <Topic key={chosen.name} topic={chosen} done={done} /> : <p className="hint live-detail">Choose a topic to receive a message of it.</p>}
    </section>
  );
}

function Topic({ topic, done }: { topic: TopicView; done: () => void }): JSX.Element {
  const [received, setReceived] = useState<ReceivedView | null>(null);
  const [busy, setBusy] = useState(false);
  const [sensor, setSensor] = useState("");
  const [output, setOutput] = useState("");
  const topics = useLive((s) => s.topics?.topics ?? NONE);
  const camera = cameraOf(topic, topics);
  async function receive(): Promise<void> {
    setBusy(true);
    try {
      setReceived(await server.receive({ topic: topic.name, type: topic.type, within: 5 }));
    } catch (error) {
      setReceived({ value: null, seconds: 0, error: messageOf(error) });
    } finally {
      setBusy(false);
    }
  }
  const word = topic.name.split("/").filter(Boolean).at(-1)?.toLowerCase() ?? "value";
  return (
    <div className="live-detail" role="group" aria-label={`Topic ${topic.name}`}>
      <h4>{topic.name}</h4>
      <p className="hint">
        {topic.type}, {topic.publishers} {topic.publishers === 1 ? "publisher" : "publishers"}; a task gets a <code>{topic.value}</code>
      </p>
      <p>
        <button className="main" disabled={busy} onClick={() => void receive()}>
          {busy ? "Waiting for it ..." : "Receive one message"}
        </button>
      </p>
      <div role="status" aria-label="Received message">
        {received?.error && <p className="fault">{received.error}</p>}
        {received?.value && (
          <>
            <p className="hint">came after {received.seconds.toFixed(2)} s</p>
            <ValueShown view={received.value} name={topic.name} />
          </>
        )}
      </div>
      {camera && <CameraForm camera={camera} suggested={topic.name.split("/")[1] ?? ""} done={done} />}
      <fieldset>
        <legend>Use as a sensor</legend>
        <div className="form-field">
          <label htmlFor="sensor-name">Sensor</label>
          <input id="sensor-name" type="text" value={sensor} placeholder="depth_camera" onChange={(event) => setSensor(event.target.value)} />
        </div>
        <div className="form-field">
          <label htmlFor="sensor-output">Output</label>
          <input id="sensor-output" type="text" value={output} placeholder={word} onChange={(event) => setOutput(event.target.value)} />
        </div>
        <button
          onClick={() => {
            done();
            void useAsSensor(topic, sensor.trim() || "depth_camera", output.trim() || word);
          }}
        >
          Put it into grip.yaml
        </button>
      </fieldset>
    </div>
  );
}

/** A camera that tasks ask by name: in the simulated world, and by these topics on the real robot. */
function CameraForm({ camera, suggested, done }: { camera: CameraTopics; suggested: string; done: () => void }): JSX.Element {
  const [name, setName] = useState("");
  return (
    <fieldset>
      <legend>Use as a camera of the real robot</legend>
      <dl className="live-camera">
        {Object.entries(camera).map(([part, topic]) => (
          <div key={part}>
            <dt>{part}</dt>
            <dd>{topic ? <code>{topic}</code> : <span className="hint">not found; to be filled in</span>}</dd>
          </div>
        ))}
      </dl>
      <div className="form-field">
        <label htmlFor="camera-name">Camera</label>
        <input id="camera-name" type="text" value={name} placeholder={suggested} onChange={(event) => setName(event.target.value)} />
      </div>
      <button
        onClick={() => {
          done();
          void useAsCamera(camera, name.trim() || suggested);
        }}
      >
        Put the camera into grip.yaml
      </button>
    </fieldset>
  );
}
